// The one place that opens, writes and removes files of an output folder. A file is there whole, or what was there
// before still is. No link leads out of the folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace thixo {

/// Writes `bytes` to `path`. The bytes go to a temporary file in the same folder, which is flushed to disk and renamed;
/// then the folder is flushed. Every return value is checked. Throws InputError where `path` is a link. Throws
/// ResourceError (path and the system's reason) on any failure. No temporary is then left, and `path` is unchanged
/// unless flushing the folder was all that failed.
///
/// Tests of full disks and of kills set the environment variable THIXO_WRITE_FAULT:
///     THIXO_WRITE_FAULT=<nth>:<bytes>:<how>
/// The nth call of this process since it was set (from 1) then fails after so many bytes. `how` is enospc or kill.
/// enospc: that call and all later ones report a full disk. kill: the process sends SIGKILL to itself.
void write_whole(const std::filesystem::path& path, std::string_view bytes);

/// Appends one line to a regular file, which it makes where there is none. False where that fails, or where `path` is a
/// link. That is no error: no run needs what such files hold.
bool append_line(const std::filesystem::path& path, std::string_view line);

/// The bytes of a regular file that the user names. Throws CacheError naming the file where it is missing or cannot be
/// read.
std::string read_whole(const std::filesystem::path& path);

/// The bytes of a regular file below a folder, for names that come from a file: no component of `name` may be a link or
/// "..". A file of more than `most` bytes is refused unread. Throws CacheError.
std::string read_inside(const std::filesystem::path& folder, const std::string& name, std::uint64_t most);

/// Whether `path` is a regular file, no link, that starts so.
bool starts_with(const std::filesystem::path& path, std::string_view start);

/// Makes the folder and its parents. Throws ResourceError.
void make_folder(const std::filesystem::path& folder);

/// Makes `name`, one or more components, below a folder, and the folder itself. Throws InputError where a component is
/// a link or no folder, ResourceError where the system refuses. Returns the path.
std::filesystem::path make_subfolder(const std::filesystem::path& folder, const std::filesystem::path& name);

/// A name in `folder` that belongs to this process alone, and that remove_stale_temporaries knows once it has ended.
std::filesystem::path temporary_path(const std::filesystem::path& folder, std::string_view name);

/// Removes files and folders of temporary names that a killed process left in `folder`; those of living processes stay.
/// Call before the first write to a folder. Returns how many it removed; a folder that is not there has none.
int remove_stale_temporaries(const std::filesystem::path& folder);

}  // namespace thixo
