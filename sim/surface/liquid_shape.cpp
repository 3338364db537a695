#include "sim/surface/liquid_shape.h"

#include "pipeline/geometry/kernels.h"

namespace thixo {

namespace {

/// Adds up the points that for_each(f) passes to f(j, |x - x_j|^2).
template <class ForEach>
ColourSample sum_colour(const LiquidShape& shape, const Vec3& x, std::int32_t component, ForEach&& for_each) {
    const Poly6 w(shape.support);
    const LiquidPoints& points = shape.points;
    const Real image_depth = shape.image_depth();
    ColourSample sample;
    for_each([&](Index j, Real r2) {
        if (points.component[j] != component || !points.counts_at(j, x, image_depth)) return;
        if (points.is_image(j)) {
            sample.near_wall = true;
            for (const Index plane : points.mirrors[j])
                if (plane != kNone) sample.out += points.planes[plane].normal;
        }
        const Real volume = points.volume[j] * points.colour[j];
        const Vec3 offset = points.position[j] - x;
        sample.value += volume * w.value(r2);
        sample.gradient -= volume * w.gradient_factor(r2) * offset;
        sample.centre += volume * w.value(r2) * offset;
    });
    if (sample.value > 0) sample.centre /= sample.value;
    if (sample.near_wall) sample.out.normalize();
    return sample;
}

}  // namespace

ColourSample LiquidShape::colour(const Vec3& x, std::int32_t component) const {
    return sum_colour(*this, x, component, [&](auto&& add) { points.grid.for_each_neighbour(x, support, add); });
}

ColourSample LiquidShape::colour(const Vec3& x, std::int32_t component, std::span<const Index> near) const {
    return sum_colour(*this, x, component, [&](auto&& add) {
        for (const Index j : near) {
            const Real r2 = (points.position[j] - x).squaredNorm();
            if (r2 < square(support)) add(j, r2);
        }
    });
}

DepthSample LiquidShape::depth_of(const ColourSample& c, const Vec3& x, Real iso_value) const {
    const Real per_phi = support * Real(256.0 / 315.0);
    DepthSample sample{(c.value - iso_value) * per_phi, c.gradient * per_phi, c.centre, c.value, false, c.value > 0};
    if (c.near_wall) {
        const WallPlane wall = wall_plane(x, c.out);
        const Real below_wall = wall.distance(x) + wall_depth();
        if (below_wall < sample.depth) {
            sample.depth = below_wall;
            sample.gradient = wall.normal;
            sample.wall = true;
        }
    }
    return sample;
}

WallPlane LiquidShape::wall_plane(const Vec3& x, const Vec3& out) const {
    const Vec3 beside = x + Real(0.5) * spacing * out;
    const WallContact contact = wall_contact(walls, beside);
    return {contact.normal, contact.normal.dot(beside) - contact.distance};
}

SheetSample LiquidShape::sheet(const ColourSample& c, const WallPlane& wall, const Vec3& x, const Vec3& n) const {
    constexpr Real kLeastSlope = Real(0.05);
    SheetSample sample;
    sample.phi = c.value;
    sample.centre = c.centre;
    sample.to_crease = std::numeric_limits<Real>::max();
    const Real per_phi = support * Real(256.0 / 315.0);
    const Real field = (c.value - iso) * per_phi;
    const Vec3 field_slope = c.gradient * per_phi;
    Real below_wall = std::numeric_limits<Real>::max();
    Vec3 wall_normal(0, 0, 0);
    if (c.near_wall) {
        below_wall = wall.distance(x) + wall_depth();
        wall_normal = wall.normal;
        sample.coat = on_coat(wall, x, n);
    }
    if (c.near_wall && !sample.coat && below_wall < 0 && field > Real(0.35) * spacing &&
        std::abs(n.dot(wall_normal)) < Real(0.8)) {
        // A coat's surfel, for it is deep in the field, that came behind another wall than its own: only the way back
        // to the crease of the two is known.
        const Vec3 across = wall_normal - n * n.dot(wall_normal);
        sample.defined = sample.coat = true;
        sample.outward = n;
        sample.to_crease = below_wall / across.norm();
        sample.towards_crease = -across.normalized();
        return sample;
    }
    const Real depth = sample.coat ? below_wall : field, other = sample.coat ? field : below_wall;
    const Vec3 slope = sample.coat ? wall_normal : field_slope;
    const Real slope2 = slope.squaredNorm();
    // A coat lines liquid. What passes for the coat of a dry wall, such as the far side of a thin one, is none.
    const bool dry = sample.coat && field < -Real(0.25) * spacing;
    sample.defined = c.value > 0 && !dry && slope2 > square(kLeastSlope);
    if (!sample.defined) return sample;
    sample.outward = -slope / std::sqrt(slope2);
    sample.guide = -depth / slope2 * slope;
    const Real length = sample.guide.norm(), longest = Real(0.5) * spacing;
    if (length > longest) sample.guide *= longest / length;
    if (c.near_wall) {
        const Vec3& other_slope = sample.coat ? field_slope : wall_normal;
        const Vec3 across = other_slope - n * n.dot(other_slope);
        const Real rate = across.norm();
        if (rate > Real(0.2)) {
            sample.to_crease = other / rate;
            sample.towards_crease = -across / rate;
        }
    }
    return sample;
}

Real LiquidShape::curvature(const Vec3& x, const Vec3& n, std::int32_t component) const {
    const Poly6 w(support);
    Vec3 a, b;
    orthonormal_basis(n, a, b);
    // grad grad w = gradient_factor 1 + 24 scale/h^4 q r r^T, q = 1 - r^2/h^2; only its part across n is summed.
    const Real factor = 24 * w.scale * square(w.h2_inv);
    Real aa = 0, ab = 0, bb = 0, slope = 0;
    Vec3 out(0, 0, 0);
    points.grid.for_each_neighbour(x, support, [&](Index j, Real r2) {
        if (points.component[j] != component || !points.counts_at(j, x, image_depth())) return;
        const Real volume = points.volume[j] * points.colour[j];
        const Vec3 r = x - points.position[j];
        const Real even = volume * w.gradient_factor(r2), along = volume * factor * (1 - r2 * w.h2_inv), ra = a.dot(r),
                   rb = b.dot(r);
        aa += even + along * ra * ra;
        bb += even + along * rb * rb;
        ab += along * ra * rb;
        slope += even * n.dot(r);
        if (points.is_image(j)) out += points.planes[points.mirrors[j][0]].normal;
    });
    if (out != Vec3(0, 0, 0)) {
        const WallPlane wall = wall_plane(x, out.normalized());
        if (wall.distance(x) < 0 || on_coat(wall, x, n)) return 0;
    }
    if (!(slope != 0)) return 0;
    const Real mean = (aa + bb) / 2, spread = std::hypot((aa - bb) / 2, ab);
    return (std::abs(mean) + spread) / std::abs(slope);
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
    // A tenth of what blending by the neighbours hides anyway: near the crease at a wall Newton's method rests a little
    // off.
    if (!at.defined || std::abs(at.depth) > Real(0.05) * spacing || (y - x).norm() > reach) return false;
    x = y;
    return true;
}

}  // namespace thixo
