#include "render/frame_files.h"

#include <fmt/format.h>

#include "pipeline/base/error.h"
#include "pipeline/contract/atomic_file.h"
#include "pipeline/contract/hash.h"
#include "pipeline/contract/ownership.h"

namespace thixo::render {

namespace fs = std::filesystem;

namespace {
constexpr const char* kPngKey = "thixo.png";  // checksum of the PNG beside the EXR
}  // namespace

fs::path exr_path(const fs::path& folder, int frame) { return folder / fmt::format("beauty.{:04d}.exr", frame); }
fs::path png_path(const fs::path& folder, int frame) { return folder / fmt::format("beauty.{:04d}.png", frame); }

PictureState picture_state(const fs::path& folder, const PictureIdentity& identity) {
    const fs::path path = exr_path(folder, identity.frame);
    if (!fs::exists(path)) return PictureState::absent;
    try {
        const Image image = read_exr(path, Checksum::required);
        const auto is = [&](const char* name, const std::string& value) {
            const auto found = image.attributes.find(name);
            return found != image.attributes.end() && found->second == value;
        };
        if (!is("thixo.look", identity.look)) return PictureState::other_look;
        const std::string png = read_whole(png_path(folder, identity.frame));
        // Pictures of earlier versions do not state the checksum of their PNG.
        const bool same = image.attributes.contains(kPngKey) ? is(kPngKey, hash_hex(png)) : is_own_png(png);
        return same && is("thixo.cache_frame", identity.cache) ? PictureState::done : PictureState::absent;
    } catch (const CacheError&) {
        return PictureState::absent;  // cut off or damaged: no loss to render it again
    }
}

void require_own_picture(const fs::path& folder, int frame) {
    require_own(exr_path(folder, frame), is_own_exr);
    if (!fs::exists(exr_path(folder, frame))) require_own(png_path(folder, frame), is_own_png);
}

void write_picture(const fs::path& folder, const PictureIdentity& identity, Image image, const Image8& display) {
    const std::string png = encode_png(display);
    image.attributes = {{"thixo.scene", identity.scene},
                        {"thixo.look", identity.look},
                        {"thixo.cache_frame", identity.cache},
                        {"thixo.frame", fmt::format("{}", identity.frame)},
                        {"thixo.time", fmt::format("{}", identity.time)},
                        {"thixo.samples", fmt::format("{}", identity.samples)},
                        {kPngKey, hash_hex(png)},
                        {"thixo.version", THIXO_VERSION}};
    write_whole(png_path(folder, identity.frame), png);
    write_exr(exr_path(folder, identity.frame), image);
}

}  // namespace thixo::render
