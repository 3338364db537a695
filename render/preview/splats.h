// From a cache frame to what the preview draws: spheres or discs with one colour each, and the legend that explains the
// colours.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/contract/frame.h"
#include "pipeline/contract/scene.h"
#include "render/preview/view.h"

namespace thixo::preview {

/// Lowest and highest value that the colours run over.
struct ValueRange {
    double lower = 1e300, upper = -1e300;
    bool empty() const { return lower > upper; }
    void add(double value) {
        if (value < lower) lower = value;
        if (value > upper) upper = value;
    }
};

/// How the colours of a picture are to be read.
struct Legend {
    enum class Kind { none, scale, categories };
    Kind kind = Kind::none;
    std::string title;                                              // attribute and unit
    ValueRange range;                                               // scale
    std::vector<std::pair<std::string, std::uint32_t>> categories;  // label, packed colour
};

/// Spheres (axes empty) or elliptical discs of a frame.
struct Splats {
    std::vector<std::array<float, 4>> centre;  // x, y, z, radius [m]
    std::vector<std::array<float, 4>> axes;    // two per disc: its half-axes t1, t2 [m]
    std::vector<std::uint32_t> colour;         // packed display colour
    Bounds bounds;                             // of the centres, grown by the largest radius
    double typical_radius = 0;                 // m, mean
    Legend legend;
};

/// `particles` or `surfels`: what `auto` means for this frame. An attribute only one of them has decides; else surfels
/// where there are any. Throws InputError for another word.
std::string resolve_what(const Frame& frame, const std::string& what, const std::string& attribute);

/// Values of an attribute as numbers: scalars as they are, vectors by magnitude, and name.x, name.y, name.z by
/// component. Throws InputError, naming the attributes there are, where it is missing.
std::vector<double> attribute_values(const PointSet& points, const std::string& attribute);

/// Smallest and largest finite value of an attribute.
ValueRange attribute_range(const PointSet& points, const std::string& attribute);

/// What to draw of a frame. An empty attribute colours by Cd where the points have it, else by the material's
/// appearance in the look. The attributes N and Cd are drawn as colours. `sheet` gives each crack one, on both of its faces. Whole numbers over fewer than ten values get a
/// colour each. All others run over `range`, or the frame's own range. Throws CacheError where P, pscale (particles) or
/// t1, t2 (surfels) are missing.
Splats make_splats(const Frame& frame, const scene::Look& look, const std::string& what, const std::string& attribute,
                   const std::optional<ValueRange>& range);

}  // namespace thixo::preview
