#include "pipeline/contract/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

#include "pipeline/base/error.h"
#include "pipeline/contract/atomic_file.h"

namespace thixo {

namespace {

/// A stage whose driver was killed saves its state before it lets go: whoever comes meanwhile waits so long for it.
constexpr auto kPatience = std::chrono::seconds(2);
constexpr auto kPause = std::chrono::milliseconds(50);

/// 0 once the lock is held, EWOULDBLOCK where another holds it for longer than kPatience, or what went wrong.
int lock_patiently(int file) {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (::flock(file, LOCK_EX | LOCK_NB) != 0) {
        if (errno != EWOULDBLOCK && errno != EINTR) return errno;
        if (std::chrono::steady_clock::now() >= end || interrupted() != 0) return EWOULDBLOCK;
        std::this_thread::sleep_for(kPause);
    }
    return 0;
}

}  // namespace

FolderLock::FolderLock(const std::filesystem::path& folder) {
    make_folder(folder);
    const std::string path = (folder / ".lock").string();
    file_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0644);
    if (file_ < 0 && errno == ELOOP)
        throw InputError("'{}' is a link, and output goes through none; remove it or give --out for another folder",
                         path);
    if (file_ < 0) throw ResourceError("cannot open '{}': {}", path, std::strerror(errno));
    const int error = lock_patiently(file_);
    if (error == 0) return;
    ::close(file_);
    if (error == EWOULDBLOCK)
        throw InputError("'{}' is being written by another simulation; wait for it, or give --out for another folder",
                         folder.string());
    throw ResourceError("cannot lock '{}': {}", path, std::strerror(error));
}

FolderLock::~FolderLock() { ::close(file_); }

}  // namespace thixo
