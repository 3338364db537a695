#include "sim/fracture/image_cracks.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "pipeline/base/error.h"
#include "pipeline/contract/atomic_file.h"
#include "pipeline/contract/hash.h"
#include "pipeline/contract/image.h"
#include "sim/fracture/image_lines.h"
#include "sim/fracture/painted.h"

namespace thixo {
namespace {

Image8 read_picture(const scene::CrackImage& image) {
    try {
        const std::string bytes = read_whole(image.file);
        if (!image.content.empty() && hash_hex(bytes) != image.content)
            throw InputError("the image file {} is no longer the one the scene was read with; start again", image.file);
        return decode_png(bytes, image.file);
    } catch (const CacheError& e) {  // a picture that a user names is input
        throw InputError("{}", e.what());
    }
}

/// Pixels darker than the threshold. What is transparent lies on white ground.
LineMask dark_pixels(const Image8& picture, double threshold) {
    LineMask mask{picture.width, picture.height, {}};
    const auto channels = static_cast<std::size_t>(picture.channels);
    for (std::size_t at = 0; at < picture.values.size(); at += channels) {
        const auto value = [&](std::size_t c) { return picture.values[at + c] / 255.0; };
        const double grey = 0.2126 * value(0) + 0.7152 * value(1) + 0.0722 * value(2);
        const double cover = channels == 4 ? value(3) : 1;
        mask.dark.push_back(cover * grey + 1 - cover < threshold ? 1 : 0);
    }
    return mask;
}

/// The lines of the picture in its plane, simplified to half a pixel.
std::vector<PixelLine> lines_in(const Image8& picture, double threshold) {
    const LineMask mask = dark_pixels(picture, threshold), thin = thinned(mask);
    const auto count = [](const LineMask& m) { return static_cast<double>(std::ranges::count(m.dark, 1)); };
    constexpr double kOff = 0.5;  // pixels
    // The thinning of a stroke may leave spurs of about half of its width.
    const double width = count(mask) / std::max(count(thin), 1.0);
    std::vector<PixelLine> lines;
    for (const PixelLine& line : trace_lines(thin, width)) lines.push_back(simplified(line, kOff));
    return lines;
}

/// A picture that hangs in the material frame.
struct Screen {
    Vec3d origin, across, up;  // m
    Vec3d ahead;               // unit, to the body
    Vec2d pixels;
    Vec3 place(const Vec2d& at) const {
        return (origin + at.x() / pixels.x() * across + (1 - at.y() / pixels.y()) * up).cast<Real>();
    }
};

/// Where a way from x straight ahead first meets the body.
std::optional<Vec3> first_on_body(const Vec3& x, const Vec3& ahead, const Breaking& breaking) {
    const Real least = breaking.row / 16;
    const auto box = breaking.shape.bounds();
    THIXO_ASSERT(box, "a body has no bounds");
    const Vec3 middle = (box->lower + box->upper) / 2 - breaking.origin;
    const Real far = (middle - x).dot(ahead) + (box->upper - box->lower).norm();
    Real before = 0, t = 0, d = breaking.distance(x);
    if (d < 0) throw InputError("the picture stands within the body: give it an \"origin\" in front of it");
    while (d > 0) {
        before = t;
        t += std::max(d, least);
        if (t > far) return std::nullopt;
        d = breaking.distance(x + t * ahead);
    }
    for (int k = 0; k < 20; ++k) {
        const Real half = (before + t) / 2;
        (breaking.distance(x + half * ahead) > 0 ? before : t) = half;
    }
    return Vec3(x + t * ahead);
}

/// The parts of a line that lie on the body, each with two points at least.
std::vector<std::vector<Vec3>> on_body(const std::vector<Vec3>& line, const Vec3& ahead, const Breaking& breaking) {
    const bool ring = line.size() > 3 && line.front() == line.back();
    std::vector<Vec3> steps = even_steps(line, breaking.row, ring);
    if (ring) steps.push_back(steps.front());
    constexpr Real kStep = 3;  // rows: a surface that leaves more between two points is not seen from the picture
    std::vector<std::vector<Vec3>> parts(1);
    for (const Vec3& x : steps) {
        const std::optional<Vec3> at = first_on_body(x, ahead, breaking);
        const bool off = !at || (!parts.back().empty() && (*at - parts.back().back()).norm() > kStep * breaking.row);
        if (off && !parts.back().empty()) parts.emplace_back();
        if (at) parts.back().push_back(*at);
    }
    std::erase_if(parts, [](const std::vector<Vec3>& part) { return part.size() < 2; });
    return parts;
}

}  // namespace

std::vector<std::vector<Vec3>> lines_of_image(const scene::CrackImage& image, const Breaking& breaking) {
    const Image8 picture = read_picture(image);
    const Vec3d origin = image.origin - breaking.origin.cast<double>();
    const Screen screen{origin, image.across, image.up, -image.across.cross(image.up).normalized(),
                        Vec2d(picture.width, picture.height)};
    std::vector<std::vector<Vec3>> lines;
    for (const PixelLine& pixels : lines_in(picture, image.threshold)) {
        if (pixels.size() < 2) continue;
        std::vector<Vec3> line;
        for (const Vec2d& at : pixels) line.push_back(screen.place(at));
        const auto parts = on_body(line, screen.ahead.cast<Real>(), breaking);
        if (parts.empty())
            throw InputError("the line from pixel ({:.0f}, {:.0f}) to ({:.0f}, {:.0f}) of '{}' misses the body",
                             pixels.front().x(), pixels.front().y(), pixels.back().x(), pixels.back().y(), image.file);
        lines.insert(lines.end(), parts.begin(), parts.end());
    }
    if (lines.empty())
        throw InputError("'{}' shows no line: none of its pixels, or single ones, are darker than {}", image.file,
                         image.threshold);
    return lines;
}

}  // namespace thixo
