#include "sim/surface/resample.h"

#include <algorithm>
#include <numeric>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/implicit_surface.h"
#include "sim/surface/growing_grid.h"

namespace thixo {
namespace {

// In surfel radii.
constexpr Real kCrowded = Real(0.55), kSparse = Real(0.8), kApart = Real(0.7);
// At a crease discs are cut short and cover less to their sides. Where two creases meet, one disc must stand right in
// the corner.
constexpr Real kApartAtCrease[] = {kApart, Real(0.55), Real(0.15), Real(0.15)};
constexpr Real kSameSide = Real(0.7);  // cosine between normals of surfels that cover for each other
// So many directions find every empty circle of a radius: a point at distance r is within 2 sin(5.6 degrees) r of one.
// That is the difference of 1 and kSparse.
constexpr int kDirections = 16;
struct Circle {
    Real x[kDirections], y[kDirections];
    Circle() {
        for (int k = 0; k < kDirections; ++k) {
            x[k] = static_cast<Real>(std::cos(2 * kPi * k / kDirections));
            y[k] = static_cast<Real>(std::sin(2 * kPi * k / kDirections));
        }
    }
};
const Circle kCircle;
constexpr int kRounds = 40;  // a sheet grows from one seed by a radius a round

/// Cosine between normals of surfels that cover for each other where matter has melted by b. Faces of a solid do so at
/// its edges and corners. These round off as they melt, and new surfels come in between.
Real same_side(Real b) { return std::lerp(Real(-0.5), kSameSide, b); }

/// A candidate for a new surfel.
struct Proposal {
    Vec3 position{0, 0, 0};
    Vec3 normal{0, 0, 0};
    std::int32_t component = 0, body = 0;
    Real curvature = 0, radius = 0;
    Real apart = kApart;  // least distance from other surfels, in radii
    Real melt = 1;        // of the matter there
    bool good = false;
    WallNote wall;
};

/// The present surfels, in a grid to which new ones are added.
struct Cover {
    const std::vector<Vec3>& position;
    const std::vector<Vec3>& normal;
    const std::vector<std::int32_t>& component;
    const std::vector<Real>& radius;
    GrowingGrid grid;
    std::size_t first_new;

    Cover(const SurfaceState& surface, const SurfelNotes& notes, Real cell)
        : position(surface.surfels.position),
          normal(surface.surfels.normal),
          component(notes.component),
          radius(notes.radius),
          grid(cell, surface.size()),
          first_new(surface.size()) {
        follow();
    }
    void follow() {
        while (grid.size() < position.size()) grid.add(position[grid.size()]);
    }
    /// Whether a surfel of the same side lies within `reach` of a place.
    bool covers(const Proposal& p, Real reach) const {
        const Real side = same_side(p.melt);
        return grid.any_neighbour(p.position, reach, [&](Index j, Real) {
            return component[j] == p.component && normal[j].dot(p.normal) > side;
        });
    }
    /// Whether a surfel of another side lies within a radius of it.
    bool meets(const Proposal& p) const {
        return grid.any_neighbour(p.position, p.radius, [&](Index j, Real) {
            return component[j] == p.component && normal[j].dot(p.normal) <= kSameSide;
        });
    }
};

void fit(Proposal& p, const LiquidShape& shape, Real full) {
    p.curvature = shape.curvature(p.position, p.normal, p.component, p.wall);
    p.radius = fitting_radius(p.curvature, full);
}

/// Puts a proposal on the sheet through the surfels around it, up to where it meets another sheet. False where the
/// liquid's surface is not there.
bool settle_on_average(Proposal& p, const SurfelAverage& average, const LiquidShape& shape, Real full) {
    const Vec3 n = average.unit_normal();
    Vec3 place = p.position - average.value() * n;
    SheetSample at = shape.sheet(place, n, p.component, p.wall);
    for (int crease = 0; crease < 3 && at.defined; ++crease) {  // in a corner there are several
        const Real excess = at.to_crease - at.stand_off * p.radius;
        if (excess > Real(-0.01) * shape.spacing) break;
        if (at.to_crease < -Real(0.7) * shape.spacing) return false;
        place += excess * at.towards_crease;
        p.apart = kApartAtCrease[crease + 1];
        at = shape.sheet(place, n, p.component, p.wall);
    }
    if (!at.defined || at.guide.norm() >= Real(0.2) * shape.spacing || at.outward.dot(n) <= Real(0.7) ||
        at.to_crease <= -Real(0.1) * shape.spacing || (!at.coat && at.phi > kDeepest))
        return false;
    p.position = at.coat ? Vec3(place + at.guide) : place;
    p.normal = at.coat ? at.outward : n;
    fit(p, shape, full);
    return true;
}

/// Moves a proposal from the liquid's surface back to that of the old surfels, as far as the matter has not melted
/// (6.6.6):
///     s = (1 - b) s_displaced + b s_deformed
/// s_displaced is its foot on the plane of the nearest.
void keep_to_solid(Proposal& p, const Cover& cover, Real reach) {
    Real least = square(reach);
    Index nearest = kNone;
    cover.grid.for_each_neighbour(p.position, reach, [&](Index j, Real r2) {
        if (j >= cover.first_new || r2 >= least || cover.component[j] != p.component ||
            cover.normal[j].dot(p.normal) < Real(0.5))
            return;
        least = r2;
        nearest = j;
    });
    if (nearest == kNone) return;
    const Vec3& n = cover.normal[nearest];
    p.position -= (1 - p.melt) * n.dot(p.position - cover.position[nearest]) * n;
    p.normal = ((1 - p.melt) * n + p.melt * p.normal).normalized();
}

/// Puts a proposal on the surface: that of its neighbours where three or more blend there. The liquid's surface is
/// taken where fewer do, and where it bends too sharply for their mean to lie on it. It is also taken where a sheet
/// leaves its wall at a small angle. The mean does not lie on it there, and no other sheet is near that the mean would
/// have met. The proposal comes with the radius of its parent surfel, and gets its own.
void settle(Proposal& p, const Cover& cover, const LiquidShape& shape, Real per_radius, Real full) {
    p.good = false;
    const Real surfel_support = per_radius * p.radius;
    const Poly6 w(surfel_support);
    SurfelAverage average;
    int count = 0;
    cover.grid.for_each_neighbour(p.position, surfel_support, [&](Index j, Real r2) {
        if (cover.component[j] != p.component || cover.normal[j].dot(p.normal) < Real(0.70710678)) return;
        average.add(w.value(r2), cover.position[j] - p.position, cover.normal[j]);
        ++count;
    });
    if (count >= 3 && average.defined() && p.radius == full) {
        p.good = settle_on_average(p, average, shape, full);
        if (p.good || cover.meets(p)) return;
        p.apart = kApart;
    }
    if (!shape.project(p.position, p.component, shape.spacing)) return;
    const DepthSample at = shape.depth(p.position, p.component);
    if (!(at.gradient.squaredNorm() > square(kLeastSlope))) return;
    p.normal = at.outward();
    if (p.melt < 1) keep_to_solid(p, cover, 2 * full);
    fit(p, shape, full);
    p.good = true;
}

/// Puts a proposal of a coat on the free surface over a dry spot of the wall, as under a bubble. Its field has no slope
/// at the wall that leads there. The search goes from the wall into the room.
void settle_over_dry_spot(Proposal& p, const LiquidShape& shape, Real full) {
    constexpr int kHalvings = 9;  // of a spacing: to 0.002
    p.good = false;
    Vec3 in = p.position - shape.spacing * p.normal;
    if (shape.depth(p.position, p.component).depth >= 0 || shape.depth(in, p.component).depth <= 0) return;
    for (int k = 0; k < kHalvings; ++k) {
        const Vec3 middle = (in + p.position) / 2;
        (shape.depth(middle, p.component).depth > 0 ? in : p.position) = middle;
    }
    const DepthSample at = shape.depth(p.position, p.component);
    if (at.wall || !(at.gradient.squaredNorm() > square(kLeastSlope))) return;
    p.normal = at.outward();
    fit(p, shape, full);
    p.good = true;
}

/// How well other surfels cover the circle of a radius about surfel i.
struct Surround {
    Vec3 a, b;                    // axes of the tangent plane
    Real melt;                    // of the matter about surfel i
    Real side;                    // cosine between normals of surfels that cover for each other
    Real clearance[kDirections];  // squared distance to the nearest surfel, in radii of surfel i

    Surround(Index i, const Cover& cover, Real melt_) : Surround(cover.normal[i], melt_) {
        cover.grid.for_each_neighbour(cover.position[i], 2 * cover.radius[i], [&](Index j, Real) {
            if (j != i) add(i, j, cover);
        });
    }
    /// From the surfels listed about the old index `was`, now at `now[j]` if they still exist. The nearest mostly
    /// suffice.
    Surround(Index i, const Cover& cover, const SurfelLists& lists, Index was, const std::vector<Index>& now,
             Real melt_)
        : Surround(cover.normal[i], melt_) {
        for (const Index j : lists.nearest(was))
            if (j != kNone && now[j] != kNone) add(i, now[j], cover);
        if (clearance[least_covered()] <= square(kSparse)) return;
        for (const Index j : lists.near(was))
            if (now[j] != kNone) add(i, now[j], cover);
    }
    void add(Index i, Index j, const Cover& cover) {
        // In the tangent plane: on a bent surface the neighbour lies below it.
        //     |q - c|^2 = |q|^2 + 1 - 2 q.c
        const Vec3 offset = (cover.position[j] - cover.position[i]) / cover.radius[i];
        if (offset.squaredNorm() > 4 || cover.component[j] != cover.component[i] ||
            cover.normal[j].dot(cover.normal[i]) < side)
            return;
        const Real u = a.dot(offset), v = b.dot(offset), far = u * u + v * v + 1;
        for (int k = 0; k < kDirections; ++k)
            clearance[k] = std::min(clearance[k], far - 2 * (u * kCircle.x[k] + v * kCircle.y[k]));
    }
    int least_covered() const {
        return static_cast<int>(std::max_element(clearance, clearance + kDirections) - clearance);
    }

  private:
    Surround(const Vec3& n, Real melt_) : melt(melt_), side(same_side(melt_)) {
        orthonormal_basis(n, a, b);
        std::fill_n(clearance, kDirections, std::numeric_limits<Real>::max());
    }
};

/// Whether a proposal beside a surfel of that radius is good and no other is near. By its own radius alone it would
/// always be too near to a much smaller surfel that it comes from.
bool keeps_apart(Proposal& p, Real beside, const Cover& cover) {
    p.apart *= std::min(beside / p.radius, Real(1));
    p.good = p.good && !cover.covers(p, p.apart * p.radius);
    return p.good;
}

/// A proposal for the least covered point of the circle about surfel i that can have a surfel, if it is too little
/// covered.
Proposal beside_surfel(Index i, Surround around, const SurfaceState& surface, const Cover& cover,
                       const LiquidShape& shape, Real per_radius, Real full) {
    // Where the surface bends sharply every try is a search for it.
    int tries = cover.radius[i] < full ? 2 : 8;
    for (int k = around.least_covered(); tries-- > 0 && around.clearance[k] > square(kSparse);
         k = around.least_covered()) {
        Proposal p;
        p.position = cover.position[i] + cover.radius[i] * (kCircle.x[k] * around.a + kCircle.y[k] * around.b);
        p.normal = cover.normal[i];
        p.component = cover.component[i];
        p.body = surface.body[i];
        p.radius = cover.radius[i];
        p.melt = around.melt;
        const Proposal start = p;
        settle(p, cover, shape, per_radius, full);
        const bool sheet_ends = p.apart < start.apart;
        if (keeps_apart(p, cover.radius[i], cover)) return p;
        if (sheet_ends) {
            p = start;
            settle_over_dry_spot(p, shape, full);
            if (keeps_apart(p, cover.radius[i], cover)) return p;
        }
        around.clearance[k] = 0;
    }
    return {};
}

/// A proposal on the surface nearest to a particle, where it is near and uncovered. The search goes outwards along the
/// field's slope, or into the wall beside the particle. Solid particles propose only where a tear has laid them bare:
/// the surface of a solid is its own, not the field's.
Proposal over_particle(std::size_t member, const ParticleRows& particles, const LiquidShape& shape, const Cover& cover,
                       Real radius) {
    constexpr Real kSurfaceFill = Real(0.85);  // outermost particles have about 0.7, the next layer 0.95
    const Particles& all = particles.table();
    const Index j = particles.row(member);
    Proposal p;
    p.component = all.material[j];
    p.body = all.body[j];
    p.radius = radius;
    p.melt = all.melt[j];
    const Vec3& x = all.position[j];
    const WallPlane& wall = shape.points.particle_wall[member];
    if (const Real distance = wall.distance(x); p.melt > 0 && distance > 0 && distance < shape.spacing) {
        p.position = x - wall.normal * (distance + shape.wall_depth());
        p.normal = -wall.normal;
        if (cover.covers(p, radius)) return p;
        const DepthSample at = shape.depth(p.position, p.component);
        p.good = at.defined && at.wall;
        if (p.good) return p;
    }
    p.position = x;
    if (shape.points.particle_fill[member] > kSurfaceFill) return p;
    // Off the particle's centre: a lone particle has no slope there.
    const Vec3& slope = shape.points.particle_slope[member];
    p.normal = slope.norm() * shape.support > Real(1e-3) ? Vec3(-slope.normalized()) : Vec3(0, 0, 1);
    p.position += Real(0.5) * shape.spacing * p.normal;
    if (cover.covers(p, Real(0.8) * radius)) return p;  // most are, and need no closer look
    if (!shape.project(p.position, p.component, shape.spacing)) return p;
    const DepthSample at = shape.depth(p.position, p.component);
    if (!(at.gradient.squaredNorm() > square(kLeastSlope))) return p;
    p.normal = at.outward();
    fit(p, shape, radius);
    p.good = !cover.covers(p, p.melt > 0 ? p.radius : std::max(p.radius, shape.spacing));
    return p;
}

/// m0 of a new surfel: that of its neighbours, continued by a first-order least squares fit. Paint on the material then
/// stays there as the surface spreads. With too few neighbours m0 is its place.
Vec3 rest_of(const Proposal& p, const SurfaceState& surface, const Cover& cover, Real support) {
    const Poly6 w(support);
    Real weight = 0;
    int count = 0;
    Vec3 mean(0, 0, 0), mean_rest(0, 0, 0);
    Mat3 spread = Mat3::Zero(), covariance = Mat3::Zero();
    cover.grid.for_each_neighbour(p.position, support, [&](Index j, Real r2) {
        if (cover.component[j] != p.component || cover.normal[j].dot(p.normal) < kSameSide) return;
        const Real a = w.value(r2);
        const Vec3 x = (cover.position[j] - p.position) / support, m = surface.rest[j] - p.position;
        ++count;
        weight += a;
        mean += a * x;
        mean_rest += a * m;
        covariance += (a * m) * x.transpose();
        spread += (a * x) * x.transpose();
    });
    if (count < 3) return p.position;
    mean /= weight;
    mean_rest /= weight;
    covariance = covariance / weight - mean_rest * mean.transpose();
    spread = spread / weight - mean * mean.transpose() + Real(2e-3) * Mat3::Identity();  // neighbours lie in a plane
    return p.position + mean_rest - covariance * spread.inverse() * mean;
}

void append(SurfaceState& surface, SurfelNotes& notes, const Proposal& p, const Vec3& rest) {
    Vec3 a, b;
    orthonormal_basis(p.normal, a, b);
    surface.surfels.position.push_back(p.position);
    surface.surfels.normal.push_back(p.normal);
    surface.surfels.axis1.push_back(p.radius * a);
    surface.surfels.axis2.push_back(p.radius * b);
    surface.id.push_back(surface.next_id++);
    surface.body.push_back(p.body);
    surface.rest.push_back(rest);
    surface.velocity.push_back(Vec3(0, 0, 0));
    surface.temperature.push_back(0);
    notes.component.push_back(p.component);
    notes.curvature.push_back(p.curvature);
    notes.radius.push_back(p.radius);
    notes.wall.push_back(p.wall);
    notes.colour.push_back({});
    // Its disc must still be fitted, even in solid matter.
    notes.melt.push_back(std::max(p.melt, Real(0.001)));
    notes.lost.push_back(0);
}

/// Accepts the good proposals one after the other, each unless an accepted one is near. Returns their number.
std::size_t accept(SurfaceState& surface, SurfelNotes& notes, const std::vector<Proposal>& proposals, Cover& cover,
                   Real full) {
    const std::size_t before = surface.size();
    for (const Proposal& p : proposals) {
        if (!p.good || cover.covers(p, p.apart * p.radius)) continue;
        append(surface, notes, p, rest_of(p, surface, cover, Real(1.5) * full));
        cover.follow();
    }
    return surface.size() - before;
}

/// `now` is the new index of every old surfel; kNone: it is deleted.
std::size_t remove_lost_and_crowded(SurfaceState& surface, SurfelNotes& notes, Real cell, std::vector<Index>& now) {
    const Cover cover(surface, notes, cell);
    // Of two that are too near each other the older stays: visible surfels keep their places.
    const auto crowds = [&](Index j, Index i, Real r2) {
        return surface.id[j] < surface.id[i] && r2 < square(kCrowded * cover.radius[j]) &&
               cover.component[j] == cover.component[i] && cover.normal[j].dot(cover.normal[i]) > kSameSide;
    };
    std::vector<char> crowded(surface.size()), gone(notes.lost);
    parallel_for(surface.size(), [&](std::size_t k) {
        const auto i = static_cast<Index>(k);
        cover.grid.for_each_neighbour(cover.position[i], kCrowded * cover.radius[i],
                                      [&](Index j, Real r2) { crowded[i] |= char(crowds(j, i, r2)); });
    });
    std::vector<Index> remaining;
    remaining.reserve(surface.size());
    for (Index i = 0; i < surface.size(); ++i) {
        if (crowded[i] && !gone[i] && notes.melt[i] > 0)
            cover.grid.for_each_neighbour(cover.position[i], kCrowded * cover.radius[i], [&](Index j, Real r2) {
                if (!gone[j] && crowds(j, i, r2)) gone[i] = 1;
            });
        if (!gone[i]) remaining.push_back(i);
    }
    now.assign(surface.size(), kNone);
    for (Index k = 0; k < remaining.size(); ++k) now[remaining[k]] = k;
    const std::size_t deleted = surface.size() - remaining.size();
    if (deleted == 0) return 0;
    keep_table_rows(surface, remaining);
    keep_rows(notes.component, remaining);
    keep_rows(notes.curvature, remaining);
    keep_rows(notes.radius, remaining);
    keep_rows(notes.wall, remaining);
    keep_rows(notes.colour, remaining);
    keep_rows(notes.melt, remaining);
    notes.lost.assign(remaining.size(), 0);
    return deleted;
}

}  // namespace

ResampleReport resample(SurfaceState& surface, SurfelNotes& notes, const LiquidShape& shape,
                        const ParticleRows& particles, const scene::Surface& params) {
    constexpr std::size_t kGrain = 32;
    const Real full = Real(params.radius) * shape.spacing, per_radius = Real(params.support);
    ResampleReport report;
    std::vector<Index> now;
    report.deleted = remove_lost_and_crowded(surface, notes, 2 * full, now);
    const std::size_t before = surface.size();
    std::vector<Index> old(before);  // old index of each remaining surfel
    for (Index k = 0; k < now.size(); ++k)
        if (now[k] != kNone) old[now[k]] = k;
    const bool listed_all = notes.lists.size() == now.size();
    Cover cover(surface, notes, 2 * full);
    std::vector<Proposal> proposals(particles.size());
    const auto seed = [&](std::size_t k) { proposals[k] = over_particle(k, particles, shape, cover, full); };
    parallel_for(particles.size(), seed, kGrain);
    accept(surface, notes, proposals, cover, full);
    // Only surfels with a new neighbour can have gained or lost a gap. In the first round that may be any.
    std::vector<Index> look(surface.size());
    std::iota(look.begin(), look.end(), Index(0));
    std::vector<char> listed;
    for (int round = 0; round < kRounds; ++round) {
        proposals.resize(look.size());
        const auto propose = [&](std::size_t k) {
            proposals[k] = {};
            const Index i = look[k];
            if (!(notes.melt[i] > 0)) return;
            const Surround around = round == 0 && listed_all && i < before
                                        ? Surround(i, cover, notes.lists, old[i], now, notes.melt[i])
                                        : Surround(i, cover, notes.melt[i]);
            proposals[k] = beside_surfel(i, around, surface, cover, shape, per_radius, full);
        };
        parallel_for(look.size(), propose, kGrain);
        const std::size_t first_new = surface.size();
        if (accept(surface, notes, proposals, cover, full) == 0) break;
        look.clear();
        listed.resize(surface.size(), 0);
        for (std::size_t i = first_new; i < surface.size(); ++i)
            cover.grid.for_each_neighbour(cover.position[i], 2 * full, [&](Index j, Real) {
                if (!listed[j]) look.push_back(j);
                listed[j] = 1;
            });
        std::sort(look.begin(), look.end());
        for (const Index i : look) listed[i] = 0;
    }
    report.inserted = surface.size() - before;
    return report;
}

}  // namespace thixo
