#include "pipeline/contract/picture_files.h"

#include <fmt/format.h>

#include <map>

#include "pipeline/base/error.h"
#include "pipeline/contract/atomic_file.h"
#include "pipeline/contract/hash.h"
#include "pipeline/contract/ownership.h"

namespace thixo {

namespace fs = std::filesystem;

namespace {
constexpr const char *kLookKey = "thixo.look", *kCacheKey = "thixo.cache_frame";
constexpr const char* kPngKey = "thixo.png";  // checksum of the PNG beside the EXR
}  // namespace

fs::path exr_path(const fs::path& folder, int frame) { return folder / fmt::format("beauty.{:04d}.exr", frame); }
fs::path png_path(const fs::path& folder, int frame) { return folder / fmt::format("beauty.{:04d}.png", frame); }

StoredPicture read_picture(const fs::path& folder, int frame) {
    StoredPicture stored;
    try {
        const Image image = read_exr(exr_path(folder, frame), Checksum::required);
        const auto attribute = [&](const char* name) {
            const auto found = image.attributes.find(name);
            return found == image.attributes.end() ? std::string() : found->second;
        };
        stored.exr_there = true;
        stored.look = attribute(kLookKey);
        stored.cache = attribute(kCacheKey);
        stored.lights = attribute(kLightsKey);
        const std::string png = read_whole(png_path(folder, frame)), stated = attribute(kPngKey);
        // Pictures of earlier versions do not state the checksum of their PNG.
        if (stated.empty() ? !is_own_png(png) : stated != hash_hex(png))
            stored.problem =
                fmt::format("'{}' is damaged: it is not the one that its EXR states", png_path(folder, frame).string());
    } catch (const CacheError& e) {
        stored.problem = e.what();
    }
    return stored;
}

PictureState picture_state(const fs::path& folder, const PictureIdentity& identity) {
    const StoredPicture stored = read_picture(folder, identity.frame);
    if (!stored.exr_there) return PictureState::absent;  // cut off or damaged: no loss to render it again
    if (stored.look != identity.look) return PictureState::other_look;
    return stored.problem.empty() && stored.cache == identity.cache ? PictureState::done : PictureState::absent;
}

void require_own_picture(const fs::path& folder, int frame) {
    require_own(exr_path(folder, frame), is_own_exr);
    if (!fs::exists(exr_path(folder, frame))) require_own(png_path(folder, frame), is_own_png);
}

void write_picture(const fs::path& folder, const PictureIdentity& identity, Image image, const Image8& display) {
    const std::string png = encode_png(display);
    // A picture that was mixed from another one brings that one's along.
    const std::map<std::string, std::string> own{{"thixo.scene", identity.scene},
                                                 {kLookKey, identity.look},
                                                 {kCacheKey, identity.cache},
                                                 {"thixo.frame", fmt::format("{}", identity.frame)},
                                                 {"thixo.time", fmt::format("{}", identity.time)},
                                                 {"thixo.samples", fmt::format("{}", identity.samples)},
                                                 {kPngKey, hash_hex(png)},
                                                 {"thixo.version", THIXO_VERSION}};
    for (const auto& [key, value] : own) image.attributes.insert_or_assign(key, value);
    write_whole(png_path(folder, identity.frame), png);
    write_exr(exr_path(folder, identity.frame), image);
}

}  // namespace thixo
