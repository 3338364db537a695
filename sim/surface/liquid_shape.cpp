#include "sim/surface/liquid_shape.h"

#include "pipeline/geometry/kernels.h"
#include "pipeline/geometry/near_runs.h"
#include "pipeline/geometry/power_of_two.h"

namespace thixo {

namespace {

constexpr Real kAcross = Real(0.7);  // cosine between normals that belong to one wall

/// Sums over field points of a v and of a q d, with a = weight q^2, v = a q, q = 1 - r^2/h^2, and d the offsets.
struct FieldSums {
    Lanes value{}, dispersion{}, gx{}, gy{}, gz{}, cx{}, cy{}, cz{};
};

}  // namespace

ColourSample LiquidShape::colour(const Vec3& x, std::int32_t component) const {
    ColourSample sample;
    const LiquidPart* of = part(component);
    if (!of) return sample;
    const Poly6 w(support);
    FieldSums sums;
    const Real *weight = of->own.weight.data(), *dispersion = of->own.dispersion.data();
    for_each_near_run(of->own.grid, x, support, [&](Index slot, Lanes dx, Lanes dy, Lanes dz, Lanes r2) {
        const Lanes q = positive(1 - r2 * w.h2_inv), slope = load_lanes(weight + slot) * q * q, value = slope * q;
        sums.value += value;
        sums.dispersion += value * load_lanes(dispersion + slot);
        sums.gx += slope * dx;
        sums.gy += slope * dy;
        sums.gz += slope * dz;
        sums.cx += value * dx;
        sums.cy += value * dy;
        sums.cz += value * dz;
    });
    sample.value = w.scale * sum_of(sums.value);
    Real apart = w.scale * sum_of(sums.dispersion);
    sample.gradient = 6 * w.scale * w.h2_inv * Vec3(sum_of(sums.gx), sum_of(sums.gy), sum_of(sums.gz));
    sample.centre = w.scale * Vec3(sum_of(sums.cx), sum_of(sums.cy), sum_of(sums.cz));
    of->images.grid.for_each_neighbour(x, support, [&](Index j, Real r2) {
        if (!points.counts_at(of->mirrors[j], x, depth_of_images(spacing))) return;
        sample.near_wall = true;
        for (const Index plane : of->mirrors[j])
            if (plane != kNone) sample.out += points.planes[plane].normal;
        const Real volume = of->images.weight[j], value = volume * w.value(r2);
        const Vec3 offset = of->images.position[j] - x;
        sample.value += value;
        apart += value * of->images.dispersion[j];
        sample.gradient -= volume * w.gradient_factor(r2) * offset;
        sample.centre += value * offset;
    });
    if (sample.value > 0) {
        sample.centre /= sample.value;
        sample.lift_share = kLeastLiftShare + (1 - kLeastLiftShare) * apart / sample.value;
        sample.lift = of->lift * sample.lift_share;
    }
    if (sample.near_wall) sample.out.normalize();
    return sample;
}

ColourSample LiquidShape::colour(const Vec3& x, std::int32_t component, ColourNote& note) const {
    const Vec3 away = x - note.asked;
    if (!(away.squaredNorm() < square(Real(0.06) * spacing))) {
        note = {colour(x, component), x};
        return note.sample;
    }
    ColourSample sample = note.sample;
    sample.value += sample.gradient.dot(away);
    sample.centre -= away;
    return sample;
}

DepthSample LiquidShape::depth_of(const ColourSample& c, const Vec3& x, Real iso_value) const {
    const Real per_phi = support * Real(256.0 / 315.0);
    DepthSample sample{(c.value - iso_value + c.lift * c.gradient.norm()) * per_phi,
                       c.gradient * per_phi,
                       c.centre,
                       c.value,
                       false,
                       c.value > 0};
    if (!c.near_wall) return sample;
    const WallPlane wall = wall_plane(x, c);
    const Real below_wall = wall.distance(x) + wall_depth();
    if (below_wall < sample.depth) {
        sample.depth = below_wall;
        sample.gradient = wall.normal;
        sample.wall = true;
    }
    return sample;
}

WallPlane LiquidShape::plane_from(const Vec3& beside) const {
    const WallContact contact = wall_contact(walls, beside);
    return {contact.normal, contact.normal.dot(beside) - contact.distance};
}

WallPlane LiquidShape::wall_plane(const Vec3& x, const ColourSample& c) const {
    return c.near_wall ? plane_from(x + Real(0.5) * spacing * c.out) : WallPlane{};
}

WallPair LiquidShape::walls_beside(const Vec3& x, const Vec3& n, std::int32_t component) const {
    WallPair pair;
    const LiquidPart* of = part(component);
    if (!of) return pair;
    Vec3 own(0, 0, 0), out(0, 0, 0);
    const auto for_each_plane = [&](auto&& f) {
        of->images.grid.for_each_neighbour(x, support, [&](Index j, Real) {
            if (!points.counts_at(of->mirrors[j], x, depth_of_images(spacing))) return;
            for (const Index plane : of->mirrors[j])
                if (plane != kNone) f(points.planes[plane]);
        });
    };
    for_each_plane([&](const WallPlane& plane) {
        out += plane.normal;
        if (plane.normal.dot(n) < -kAcross) own += plane.normal;
    });
    if (out == Vec3(0, 0, 0)) return pair;
    const bool lines = own != Vec3(0, 0, 0);
    const Vec3 direction = (lines ? own : out).normalized();
    Vec3 beside = x + Real(0.5) * spacing * direction;
    pair.first = plane_from(beside);
    // Where another wall is nearer, the look-up is farther from that one, and in a corner from a third.
    for (int other = 0; lines && other < 2 && pair.first.normal.dot(n) > -kAcross; ++other) {
        const Real away = std::clamp(Real(0.8) * spacing - pair.first.distance(x), Real(0), spacing);
        beside += away * pair.first.normal;
        pair.first = plane_from(beside);
    }
    // Where walls meet in a convex edge, as at the spout of a funnel, the plane of one continues through the room
    // before the other. No sheet ends there.
    const bool in_room = pair.first.distance(beside) > 0;
    // The plane of a convex edge continues past the wall, too: a near plane must have a wall at the foot of x.
    Real beyond = -std::numeric_limits<Real>::max();
    for (int tries = 0; tries < 3; ++tries) {
        pair.second = {};
        for_each_plane([&](const WallPlane& plane) {
            if (in_room && plane.distance(beside) < 0) return;
            const Real distance = plane.distance(x);
            if (plane.normal.dot(pair.first.normal) < kAcross && distance > beyond &&
                distance < pair.second.distance(x))
                pair.second = plane;
        });
        const Real distance = pair.second.distance(x);
        if (distance > spacing) break;
        // Deeper in a corner of three walls the foot of x is behind the third.
        const Real off = wall_distance(walls, x - distance * pair.second.normal), most = Real(0.3) * spacing;
        if (off < most && off > std::min(distance, Real(0)) - most) return pair;
        beyond = distance;
    }
    if (pair.second.distance(x) < spacing) pair.second = {};
    return pair;
}

const WallPair& LiquidShape::walls_beside(const Vec3& x, const Vec3& n, std::int32_t component, WallNote& note) const {
    if (!((x - note.asked).squaredNorm() < square(Real(0.15) * spacing)) || n.dot(note.normal) < Real(0.94))
        note = {walls_beside(x, n, component), x, n};
    return note.walls;
}

/// Where the free surface runs along a wall, both sheets fit the normal: the right one is the one that ends the body.
/// If the free surface were taken for the coat, it would stop half a spacing before the wall.
bool LiquidShape::field_ends_first(Real field, const Vec3& field_slope, Real below_wall, const WallPlane& wall) const {
    return field < below_wall - Real(0.1) * spacing && field_slope.dot(wall.normal) > kAcross * field_slope.norm();
}

SheetSample LiquidShape::sheet(const ColourSample& c, const WallPair& beside, const Vec3& x, const Vec3& n) const {
    SheetSample sample;
    sample.phi = c.value;
    sample.centre = c.centre;
    sample.lift_share = c.lift_share;
    sample.to_crease = std::numeric_limits<Real>::max();
    const Real per_phi = support * Real(256.0 / 315.0);
    const Real field = (c.value - iso + c.lift * c.gradient.norm()) * per_phi;
    const Vec3 field_slope = c.gradient * per_phi;
    // The crease with the surface that ends the sheet, where `depth` falls to zero. The nearest of all candidates
    // counts.
    const auto end_at = [&](Real depth, const Vec3& slope, Real stand_off) {
        const Vec3 across = slope - n * n.dot(slope);
        const Real rate = across.norm();
        if (rate < Real(0.2) || depth / rate >= sample.to_crease) return;
        sample.to_crease = depth / rate;
        sample.towards_crease = -across / rate;
        sample.stand_off = stand_off;
    };
    Real below_wall = std::numeric_limits<Real>::max();
    if (c.near_wall) {
        below_wall = beside.first.distance(x) + wall_depth();
        sample.coat = on_coat(beside.first, x, n) && !field_ends_first(field, field_slope, below_wall, beside.first);
    }
    const Real depth = sample.coat ? below_wall : field;
    const Vec3 slope = sample.coat ? beside.first.normal : field_slope;
    const Real slope2 = slope.squaredNorm();
    // A coat lines liquid. At a dry wall, such as the far side of a thin one, there is none.
    const bool dry = sample.coat && field < -Real(0.25) * spacing;
    sample.defined = c.value > 0 && !dry && slope2 > square(kLeastSlope);
    if (!sample.defined) return sample;
    sample.outward = -slope / std::sqrt(slope2);
    sample.guide = -depth / slope2 * slope;
    const Real length = sample.guide.norm(), longest = Real(0.5) * spacing;
    if (length > longest) sample.guide *= longest / length;
    if (!c.near_wall) return sample;
    if (sample.coat)
        end_at(field, field_slope, kFromCrease);
    else
        end_at(below_wall, beside.first.normal, kFromCrease);
    end_at(beside.second.distance(x) + wall_depth(), beside.second.normal, sample.coat ? Real(0) : kFromCrease);
    return sample;
}

Real LiquidShape::curvature(const Vec3& x, const Vec3& n, std::int32_t component, WallNote& note) const {
    const LiquidPart* of = part(component);
    if (!of) return 0;
    // Lengths are in units of a power of two near the support. Otherwise h^7 leaves the range of a float where the
    // spacing is a micrometre or a thousand kilometres. Powers of two change no other bit.
    const Real per_unit = 1 / power_of_two_below(support), per_volume = cube(per_unit);
    const Poly6 w(support * per_unit);
    Vec3 a, b;
    orthonormal_basis(n, a, b);
    a *= per_unit;
    b *= per_unit;
    const Vec3 up = per_unit * n;
    // grad grad w = gradient_factor 1 + 24 scale/h^4 q r r^T, q = 1 - r^2/h^2; only its part across n is summed.
    const Real even_factor = -6 * w.scale * w.h2_inv * per_volume,
               factor = 24 * w.scale * square(w.h2_inv) * per_volume;
    const Real h2_inv = w.h2_inv * square(per_unit);
    Lanes aa_{}, ab_{}, bb_{}, slope_{};
    const Real* weight = of->own.weight.data();
    for_each_near_run(of->own.grid, x, support, [&](Index slot, Lanes dx, Lanes dy, Lanes dz, Lanes r2) {
        const Lanes q = positive(1 - r2 * h2_inv), m = load_lanes(weight + slot) * q;
        const Lanes even = even_factor * m * q, along = factor * m;
        const Lanes ra = a.x() * dx + a.y() * dy + a.z() * dz, rb = b.x() * dx + b.y() * dy + b.z() * dz;
        aa_ += even + along * ra * ra;
        bb_ += even + along * rb * rb;
        ab_ += along * ra * rb;
        slope_ -= even * (up.x() * dx + up.y() * dy + up.z() * dz);
    });
    Real aa = sum_of(aa_), ab = sum_of(ab_), bb = sum_of(bb_), slope = sum_of(slope_);
    bool near_wall = false;
    of->images.grid.for_each_neighbour(x, support, [&](Index j, Real r2) {
        if (!points.counts_at(of->mirrors[j], x, depth_of_images(spacing))) return;
        const Real volume = of->images.weight[j];
        const Vec3 r = x - of->images.position[j];
        const Real even = volume * per_volume * w.gradient_factor(r2 * square(per_unit)),
                   along = volume * factor * (1 - r2 * h2_inv), ra = a.dot(r), rb = b.dot(r);
        aa += even + along * ra * ra;
        bb += even + along * rb * rb;
        ab += along * ra * rb;
        slope += even * up.dot(r);
        near_wall = true;
    });
    if (near_wall) {
        const WallPlane& wall = walls_beside(x, n, component, note).first;
        if (on_coat(wall, x, n)) return 0;
    }
    if (!(slope != 0)) return 0;
    const Real mean = (aa + bb) / 2, spread = std::hypot((aa - bb) / 2, ab);
    return (std::abs(mean) + spread) / std::abs(slope) * per_unit;
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
    // The limit is a tenth of what blending by the neighbours hides anyway. Near the crease at a wall Newton's method
    // ends a little off.
    if (!at.defined || std::abs(at.depth) > Real(0.05) * spacing || (y - x).norm() > reach) return false;
    x = y;
    return true;
}

}  // namespace thixo
