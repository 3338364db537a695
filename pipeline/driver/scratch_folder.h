// A folder for the time of a scope.
#pragma once

#include <filesystem>
#include <string_view>

namespace thixo {

/// Makes a folder in `parent` that belongs to this process alone; removes it at the end, and first what killed
/// processes left there. Throws ResourceError.
class ScratchFolder {
  public:
    ScratchFolder(const std::filesystem::path& parent, std::string_view name);
    ~ScratchFolder();
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;
    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

}  // namespace thixo
