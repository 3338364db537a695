// Makes one result the reference for later checks.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/check/report.h"

namespace thixo {

/// Copies the pictures `names_a` of folder a into folder b and removes the files `names_b` that a does not have. Each
/// file is written whole; files of equal bytes stay untouched. Throws ResourceError, and what was copied by then stays.
Update update_pictures(const std::filesystem::path& a, const std::vector<std::string>& names_a,
                       const std::filesystem::path& b, const std::vector<std::string>& names_b);

/// Copies one picture over another.
Update update_picture(const std::filesystem::path& a, const std::filesystem::path& b);

/// Copies cache a over b, an output folder or cache folder, which is made where it does not exist. The files of the
/// manifest come first, then the manifest. Files that only the old manifest lists are removed last. Throws
/// ResourceError and CacheError.
Update update_cache(const std::filesystem::path& a, const std::filesystem::path& b);

}  // namespace thixo
