// Which files in an output folder are Thixo's: nothing else there is changed or removed.
#pragma once

#include <filesystem>
#include <functional>
#include <string_view>
#include <vector>

namespace thixo {

/// Whether a file's content shows that Thixo wrote it: it carries Thixo's checksum, or is as Thixo alone would write
/// it.
using IsOwn = std::function<bool(std::string_view bytes)>;

/// The test for a file of a cache, by its name relative to the cache folder; empty where no cache has such a name.
IsOwn own_cache_file(std::string_view name);

/// Whether something is at `path` that Thixo did not write. What is empty belongs to nobody; a link or a folder is
/// another's.
bool is_foreign(const std::filesystem::path& path, const IsOwn& is_own);

/// Throws InputError with the names where there are any.
void require_none_foreign(const std::vector<std::filesystem::path>& foreign);

/// Throws InputError where something is at `path` that Thixo did not write.
void require_own(const std::filesystem::path& path, const IsOwn& is_own);

}  // namespace thixo
