// A folder for the time of a scope.
#pragma once

#include <filesystem>
#include <string>

namespace thixo {

/// Makes the folder; removes what a killed process left there, and the folder itself at the end. Throws ResourceError.
class ScratchFolder {
  public:
    explicit ScratchFolder(std::filesystem::path path);
    ~ScratchFolder();
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;
    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

}  // namespace thixo
