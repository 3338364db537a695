#include "pipeline/contract/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "pipeline/base/error.h"
#include "pipeline/contract/atomic_file.h"

namespace thixo {

FolderLock::FolderLock(const std::filesystem::path& folder) {
    make_folder(folder);
    const std::string path = (folder / ".lock").string();
    file_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (file_ < 0) throw ResourceError("cannot open '{}': {}", path, std::strerror(errno));
    if (::flock(file_, LOCK_EX | LOCK_NB) == 0) return;
    const int error = errno;
    ::close(file_);
    if (error == EWOULDBLOCK)
        throw InputError("'{}' is being written by another simulation; wait for it, or give --out for another folder",
                         folder.string());
    throw ResourceError("cannot lock '{}': {}", path, std::strerror(error));
}

FolderLock::~FolderLock() { ::close(file_); }

}  // namespace thixo
