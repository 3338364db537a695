// One writer of an output folder at a time.
#pragma once

#include <filesystem>

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

}  // namespace thixo
