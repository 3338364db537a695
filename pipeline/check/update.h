// Makes one result the reference for later checks.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/check/report.h"

namespace thixo {

/// Copies the pictures `names_a` of folder a over folder b, each file whole, and removes those of `names_b` that a has
/// not. Files of equal bytes stay untouched. Throws ResourceError; files done before it stay done.
Update update_pictures(const std::filesystem::path& a, const std::vector<std::string>& names_a,
                       const std::filesystem::path& b, const std::vector<std::string>& names_b);

/// Copies one picture over another.
Update update_picture(const std::filesystem::path& a, const std::filesystem::path& b);

/// Copies cache a over b, an output folder or cache folder (made where it is not there): first the files of the
/// manifest, then the manifest, then away with files that only the old manifest named. Throws ResourceError and
/// CacheError.
Update update_cache(const std::filesystem::path& a, const std::filesystem::path& b);

}  // namespace thixo
