#include "render/image_map.h"

#include <cmath>

namespace thixo::render {
namespace {

/// Which coordinates go right and up in a picture projected along an axis.
constexpr int kRight[3] = {1, 0, 0}, kUp[3] = {2, 2, 1};

/// Seen from outside, the picture of each side of a box reads the right way: its right is mirrored on these.
bool mirrored(int axis, bool negative_side) { return axis == 1 ? !negative_side : negative_side; }

/// Outward normal in the space of the picture; any length.
Vec3f normal_of(const Hit& hit, bool in_rest) {
    const Vec3f rest = hit.attributes.rest_a.cross(hit.attributes.rest_b);
    return in_rest && rest.squaredNorm() > 0 ? rest : hit.geometric;
}

}  // namespace

Vec3f ImageMap::colour(const Hit& hit, bool in_rest) const {
    using scene::Mapping;
    if (mapping == Mapping::uv)
        return texture->colour(hit.attributes.uv.cwiseQuotient(size),
                               Vec2f(hit.footprint * hit.attributes.uv_per_metre / size.array()));
    const Vec3f x = (in_rest ? hit.attributes.rest : hit.position) - origin;
    float footprint = hit.footprint;
    if (in_rest && hit.attributes.rest_a.squaredNorm() > 0)
        footprint *= std::max(hit.attributes.rest_a.norm(), hit.attributes.rest_b.norm());
    if (mapping == Mapping::cylinder) {
        const int a = (axis + 1) % 3, b = (axis + 2) % 3;
        const float radius = std::max(std::hypot(x[a], x[b]), 1e-12f), round = 2 * float(kPi);
        return texture->colour({std::atan2(x[b], x[a]) / round + 0.5f, x[axis] / size.y()},
                               {footprint / (round * radius), footprint / size.y()});
    }
    int along = axis;
    float right = 1;
    if (mapping == Mapping::box) {
        const Vec3f n = normal_of(hit, in_rest);
        n.cwiseAbs().maxCoeff(&along);
        if (mirrored(along, n[along] < 0)) right = -1;
    }
    const Vec2f uv(right * x[kRight[along]], x[kUp[along]]);
    return texture->colour(uv.cwiseQuotient(size), Vec2f(footprint / size.array()));
}

}  // namespace thixo::render
