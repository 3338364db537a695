// One writer of an output folder at a time, or one a frame.
#pragma once

#include <filesystem>
#include <utility>

namespace thixo {

/// Holds `folder`/.lock (flock) while it lives; the system lets go of it where the process ends, however that is. The
/// file stays. Makes the folder.
class FolderLock {
  public:
    /// Waits up to 2 s for a holder that is ending. Throws InputError where another process still holds it then, or
    /// `.lock` is a link; ResourceError where there can be no lock.
    explicit FolderLock(const std::filesystem::path& folder);
    ~FolderLock();
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;

  private:
    int file_;
};

/// Locks on numbers, for processes that share the work on one folder: who holds a frame makes it. A lock is a byte of
/// `folder`/.lock, let go of where the process ends, however that is.
class NumberLocks {
  public:
    explicit NumberLocks(std::filesystem::path folder) : folder_(std::move(folder)) {}
    ~NumberLocks();
    NumberLocks(const NumberLocks&) = delete;
    NumberLocks& operator=(const NumberLocks&) = delete;

    /// False where another process holds the number. Throws InputError where `.lock` is a link, ResourceError where
    /// there can be no lock.
    bool take(int number);
    void release(int number);

  private:
    std::filesystem::path folder_;
    int file_ = -1;  // opened with the first lock
};

}  // namespace thixo
