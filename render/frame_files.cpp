#include "render/frame_files.h"

#include <fmt/format.h>

#include "pipeline/base/error.h"

namespace thixo::render {

namespace fs = std::filesystem;

fs::path exr_path(const fs::path& folder, int frame) { return folder / fmt::format("beauty.{:04d}.exr", frame); }
fs::path png_path(const fs::path& folder, int frame) { return folder / fmt::format("beauty.{:04d}.png", frame); }

PictureState picture_state(const fs::path& folder, const PictureIdentity& identity) {
    const fs::path path = exr_path(folder, identity.frame);
    if (!fs::exists(path) || !fs::exists(png_path(folder, identity.frame))) return PictureState::absent;
    try {
        const Image image = read_exr(path, Checksum::required);
        const auto is = [&](const char* name, const std::string& value) {
            const auto found = image.attributes.find(name);
            return found != image.attributes.end() && found->second == value;
        };
        if (!is("thixo.look", identity.look)) return PictureState::other_look;
        return is("thixo.cache_frame", identity.cache) ? PictureState::done : PictureState::absent;
    } catch (const CacheError&) {
        return PictureState::absent;  // cut off or damaged: no loss to render it again
    }
}

void write_picture(const fs::path& folder, const PictureIdentity& identity, Image image, const Image8& display) {
    image.attributes.insert({{"thixo.scene", identity.scene},
                             {"thixo.look", identity.look},
                             {"thixo.cache_frame", identity.cache},
                             {"thixo.frame", fmt::format("{}", identity.frame)},
                             {"thixo.time", fmt::format("{}", identity.time)},
                             {"thixo.samples", fmt::format("{}", identity.samples)},
                             {"thixo.version", THIXO_VERSION}});
    write_png(png_path(folder, identity.frame), display);
    write_exr(exr_path(folder, identity.frame), image);
}

}  // namespace thixo::render
