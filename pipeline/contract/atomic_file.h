// The one place that writes files: a file is there whole, or what was there before still is.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace thixo {

/// Writes `bytes` to `path`: temporary name in the same folder, every return checked, flushed to disk, renamed, folder
/// flushed. Throws ResourceError (path and the system's reason) on any failure, and then neither `path` nor a temporary
/// has changed.
///
/// For tests of full disks and of kills the environment variable THIXO_WRITE_FAULT=<nth>:<bytes>:<how> makes the nth
/// call of this process since it was set (from 1) fail after so many bytes: how = enospc (that call and all later ones
/// report a full disk) or kill (SIGKILL to itself).
void write_whole(const std::filesystem::path& path, std::string_view bytes);

/// The bytes of a regular file. Throws CacheError naming the file where it is missing or cannot be read.
std::string read_whole(const std::filesystem::path& path);

/// Makes the folder and its parents. Throws ResourceError.
void make_folder(const std::filesystem::path& folder);

/// Removes temporaries that a killed process left in `folder`; those of living processes stay. Call before the first
/// write to a folder. Returns how many it removed; a folder that is not there has none.
int remove_stale_temporaries(const std::filesystem::path& folder);

}  // namespace thixo
