#include "pipeline/driver/scratch_folder.h"

#include "pipeline/base/error.h"
#include "pipeline/contract/atomic_file.h"

namespace thixo {
namespace fs = std::filesystem;

ScratchFolder::ScratchFolder(fs::path path) : path_(std::move(path)) {
    std::error_code failure;
    fs::remove_all(path_, failure);
    if (failure)
        throw ResourceError("cannot remove {}: {}; remove it or choose another --out", path_.string(),
                            failure.message());
    make_folder(path_);
}

ScratchFolder::~ScratchFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
}

}  // namespace thixo
