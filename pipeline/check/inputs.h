// Finds out what the two paths of a check are, and pairs their files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace thixo {

enum class CheckKind { cache, folder, picture };

/// A cache (see CacheReader), a folder with pictures (*.exr directly in it), or one picture. Throws CacheError where
/// there is nothing, and InputError where it is none of these.
CheckKind check_kind(const std::filesystem::path& path);
const char* name_of(CheckKind kind);

/// The frame number of a file name, 12 of beauty.0012.exr; -1 where it has none.
int frame_number_of(const std::string& file_name);

/// Names of the *.exr files in the folder, ascending. With `frames` only the files of these frames count. A folder that
/// does not exist has none.
std::vector<std::string> picture_names(const std::filesystem::path& folder, const std::vector<int>* frames);

/// Names of the folders of pictures of an output folder (frames, frames.<look>), ascending. Those without pictures do not
/// count. None where the path is a cache within an output folder.
std::vector<std::string> picture_folders(const std::filesystem::path& path);

/// A name that is in A, in B or in both.
template <class Name>
struct Paired {
    Name name;
    bool in_a = false, in_b = false;
};

/// Merges two ascending lists.
template <class Name>
std::vector<Paired<Name>> pair_names(const std::vector<Name>& a, const std::vector<Name>& b) {
    std::vector<Paired<Name>> pairs;
    std::size_t i = 0, j = 0;
    while (i < a.size() || j < b.size()) {
        const bool take_a = j == b.size() || (i < a.size() && a[i] <= b[j]);
        const bool take_b = i == a.size() || (j < b.size() && b[j] <= a[i]);
        pairs.push_back({take_a ? a[i] : b[j], take_a, take_b});
        i += take_a;
        j += take_b;
    }
    return pairs;
}

}  // namespace thixo
