#include "sim/surface/liquid_shape.h"

#include "pipeline/geometry/kernels.h"

namespace thixo {

ColourSample LiquidShape::colour(const Vec3& x, std::int32_t component) const {
    const Poly6 w(support);
    const Real image_depth = wall_depth() + Real(0.1) * spacing;
    ColourSample sample;
    points.grid.for_each_neighbour(x, support, [&](Index j, Real r2) {
        if (points.component[j] != component || !points.counts_at(j, x, image_depth)) return;
        sample.near_wall = sample.near_wall || points.is_image(j);
        const Real volume = points.volume[j] * points.colour[j];
        const Vec3 offset = points.position[j] - x;
        sample.value += volume * w.value(r2);
        sample.gradient -= volume * w.gradient_factor(r2) * offset;
        sample.centre += volume * w.value(r2) * offset;
    });
    if (sample.value > 0) sample.centre /= sample.value;
    return sample;
}

DepthSample LiquidShape::depth(const Vec3& x, std::int32_t component, Real iso_value) const {
    const ColourSample c = colour(x, component);
    const Real per_phi = support * Real(256.0 / 315.0);
    DepthSample sample{(c.value - iso_value) * per_phi, c.gradient * per_phi, c.centre, c.value, false, c.value > 0};
    if (c.near_wall) {
        const WallContact contact = wall_contact(walls, x);
        const Real below_wall = contact.distance + wall_depth();
        if (below_wall < sample.depth) {
            sample.depth = below_wall;
            sample.gradient = contact.normal;
            sample.wall = true;
        }
    }
    return sample;
}

bool LiquidShape::project(Vec3& x, std::int32_t component, Real reach, Real iso_value) const {
    constexpr int kSteps = 12, kHalvings = 4;
    const Real close_enough = Real(1e-3) * spacing, longest = Real(0.5) * spacing;
    Vec3 y = x;
    DepthSample at = depth(y, component, iso_value);
    for (int step = 0; step < kSteps; ++step) {
        if (!at.defined || (y - x).norm() > reach) return false;
        if (std::abs(at.depth) < close_enough) break;
        const Real slope2 = at.gradient.squaredNorm();
        if (slope2 < square(Real(0.02))) return false;
        Vec3 move = -at.depth / slope2 * at.gradient;
        const Real length = move.norm();
        if (length > longest) move *= longest / length;
        DepthSample next = depth(y + move, component, iso_value);
        for (int h = 0; h < kHalvings && !(next.defined && std::abs(next.depth) < std::abs(at.depth)); ++h) {
            move *= Real(0.5);
            next = depth(y + move, component, iso_value);
        }
        y += move;
        at = next;
    }
    // A tenth of what blending by the neighbours hides anyway: near the crease at a wall Newton's method rests a little off.
    if (!at.defined || std::abs(at.depth) > Real(0.05) * spacing || (y - x).norm() > reach) return false;
    x = y;
    return true;
}

}  // namespace thixo
