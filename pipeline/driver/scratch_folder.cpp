#include "pipeline/driver/scratch_folder.h"

#include "pipeline/contract/atomic_file.h"

namespace thixo {
namespace fs = std::filesystem;

ScratchFolder::ScratchFolder(const fs::path& parent, std::string_view name) : path_(temporary_path(parent, name)) {
    make_folder(parent);
    remove_stale_temporaries(parent);
    make_subfolder(parent, path_.filename());
}

ScratchFolder::~ScratchFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
}

}  // namespace thixo
