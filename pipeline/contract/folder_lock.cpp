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

int open_lock(const std::filesystem::path& folder) {
    const std::string path = (folder / ".lock").string();
    const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0644);
    if (file < 0 && errno == ELOOP)
        throw InputError("'{}' is a link, and output goes through none; remove it or give --out for another folder",
                         path);
    if (file < 0) throw ResourceError("cannot open '{}': {}", path, std::strerror(errno));
    return file;
}

[[noreturn]] void cannot_lock(const std::filesystem::path& folder, int error) {
    throw ResourceError("cannot lock '{}': {}", (folder / ".lock").string(), std::strerror(error));
}

/// Whether the byte of this number could be locked or let go.
bool set_lock(int file, int number, short type) {
    struct flock lock {};
    lock.l_type = type;
    lock.l_whence = SEEK_SET;
    lock.l_start = number;
    lock.l_len = 1;
    return ::fcntl(file, F_OFD_SETLK, &lock) == 0;
}

}  // namespace

FolderLock::FolderLock(const std::filesystem::path& folder) {
    make_folder(folder);
    file_ = open_lock(folder);
    const int error = lock_patiently(file_);
    if (error == 0) return;
    ::close(file_);
    if (error == EWOULDBLOCK)
        throw InputError("'{}' is being written by another simulation; wait for it, or give --out for another folder",
                         folder.string());
    cannot_lock(folder, error);
}

FolderLock::~FolderLock() { ::close(file_); }

NumberLocks::~NumberLocks() {
    if (file_ >= 0) ::close(file_);
}

bool NumberLocks::take(int number) {
    if (file_ < 0) file_ = open_lock(folder_);
    if (set_lock(file_, number, F_WRLCK)) return true;
    if (errno != EAGAIN && errno != EACCES) cannot_lock(folder_, errno);
    return false;
}

void NumberLocks::release(int number) { set_lock(file_, number, F_UNLCK); }

}  // namespace thixo
