#include "sim/surface/resample.h"

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/implicit_surface.h"

namespace thixo {
namespace {

// In surfel radii.
constexpr Real kCrowded = Real(0.45), kSparse = Real(0.8), kApart = Real(0.7);
constexpr Real kSameSide = Real(0.7);  // cosine between normals of surfels that cover for each other
constexpr int kDirections = 12;
constexpr Real kHalf = Real(0.5), kRoot = Real(0.8660254037844386);
constexpr struct {
    Real x, y;
} kCircle[kDirections] = {{1, 0},  {kRoot, kHalf},   {kHalf, kRoot},   {0, 1},  {-kHalf, kRoot}, {-kRoot, kHalf},
                          {-1, 0}, {-kRoot, -kHalf}, {-kHalf, -kRoot}, {0, -1}, {kHalf, -kRoot}, {kRoot, -kHalf}};
constexpr int kRounds = 40;  // a sheet grows from one seed by a radius a round

/// A surfel that may come to be.
struct Proposal {
    Vec3 position{0, 0, 0};
    Vec3 normal{0, 0, 0};
    std::int32_t component = 0, body = 0;
    Real curvature = 0, radius = 0;
    bool good = false;
};

struct Cover {
    const std::vector<Vec3>& position;
    const std::vector<Vec3>& normal;
    const std::vector<std::int32_t>& component;
    const std::vector<Real>& radius;
    PointGrid grid;

    Cover(const SurfaceState& surface, const SurfelNotes& notes, Real reach)
        : position(surface.surfels.position),
          normal(surface.surfels.normal),
          component(notes.component),
          radius(notes.radius) {
        grid.build(position, reach);
    }
    /// Whether a surfel of the same side lies within `radius` of a place.
    bool covers(const Proposal& p, Real radius) const {
        bool found = false;
        grid.for_each_neighbour(p.position, radius, [&](Index j, Real) {
            found = found || (component[j] == p.component && normal[j].dot(p.normal) > kSameSide);
        });
        return found;
    }
};

void fit(Proposal& p, const LiquidShape& shape, Real full) {
    p.curvature = shape.curvature(p.position, p.normal, p.component);
    p.radius = fitting_radius(p.curvature, full);
}

/// Puts a proposal on the surface: that of its neighbours where three or more blend there, the liquid's otherwise.
/// Its radius is that of the surfel it comes from; it gets its own.
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
    if (count >= 3 && average.defined()) {
        const Vec3 n = average.unit_normal();
        Vec3 place = p.position - average.value() * n;
        SheetSample at = shape.sheet(place, n, p.component);
        const Real excess = at.to_crease - kFromCrease * p.radius;
        if (at.defined && excess < 0) {  // the sheet ends here
            if (at.to_crease < -Real(0.7) * shape.spacing) return;
            place += excess * at.towards_crease;
            at = shape.sheet(place, n, p.component);
        }
        if (at.defined && at.guide.norm() < Real(0.3) * shape.spacing && at.outward.dot(n) > Real(0.7) &&
            at.to_crease > -Real(0.1) * shape.spacing) {
            p.position = at.coat ? Vec3(place + at.guide) : place;
            p.normal = at.coat ? at.outward : n;
            fit(p, shape, full);
            p.good = true;
        }
        return;
    }
    if (!shape.project(p.position, p.component, shape.spacing)) return;
    const DepthSample at = shape.depth(p.position, p.component);
    if (!(at.gradient.squaredNorm() > square(Real(0.05)))) return;
    p.normal = at.outward();
    fit(p, shape, full);
    p.good = true;
}

/// The least covered point of the circle about surfel i, if it is too little covered.
Proposal beside_surfel(Index i, const SurfaceState& surface, const Cover& cover) {
    const Real radius = cover.radius[i];
    const Vec3 &s = cover.position[i], &n = cover.normal[i];
    Vec3 a, b;
    orthonormal_basis(n, a, b);
    Vec3 place[kDirections];
    Real clearance[kDirections];
    for (int k = 0; k < kDirections; ++k) {
        place[k] = s + radius * (kCircle[k].x * a + kCircle[k].y * b);
        clearance[k] = std::numeric_limits<Real>::max();
    }
    cover.grid.for_each_neighbour(s, 2 * radius, [&](Index j, Real) {
        if (j == i || cover.component[j] != cover.component[i] || cover.normal[j].dot(n) < kSameSide) return;
        // In the tangent plane: on a bent surface the neighbour lies below it.
        const Vec3 flat = cover.position[j] - n * n.dot(cover.position[j] - s);
        for (int k = 0; k < kDirections; ++k) clearance[k] = std::min(clearance[k], (flat - place[k]).squaredNorm());
    });
    const int best = static_cast<int>(std::max_element(clearance, clearance + kDirections) - clearance);
    Proposal p{
        place[best], n, cover.component[i], surface.body[i], 0, radius, clearance[best] > square(kSparse * radius)};
    return p;
}

/// The surface nearest to a particle, where it is near and uncovered: outwards along the field's slope, or into the
/// wall beside it.
Proposal over_particle(Index j, const Particles& particles, const LiquidShape& shape, const Cover& cover, Real radius) {
    constexpr Real kSurfaceFill = Real(0.85);  // outermost particles have about 0.7, the next layer 0.95
    Proposal p{particles.position[j], Vec3(0, 0, 0), particles.material[j], particles.body[j], 0, radius, false};
    const Real wall = shape.points.particle_wall[j];
    if (wall > 0 && wall < shape.spacing) {
        const WallContact contact = wall_contact(shape.walls, p.position);
        p.position -= contact.normal * (contact.distance + shape.wall_depth());
        p.normal = -contact.normal;
        const DepthSample at = shape.depth(p.position, p.component);
        if (at.defined && at.wall) {
            p.good = !cover.covers(p, radius);
            return p;
        }
        p.position = particles.position[j];
    }
    if (shape.points.particle_fill[j] > kSurfaceFill) return p;
    // Off the particle's centre: a lone one has no slope there.
    const Vec3& slope = shape.points.particle_slope[j];
    p.normal = slope.norm() * shape.support > Real(1e-3) ? Vec3(-slope.normalized()) : Vec3(0, 0, 1);
    p.position += Real(0.5) * shape.spacing * p.normal;
    if (cover.covers(p, Real(0.8) * radius)) return p;  // most are, and need no closer look
    if (!shape.project(p.position, p.component, shape.spacing)) return p;
    p.normal = shape.depth(p.position, p.component).outward();
    fit(p, shape, radius);
    p.good = !cover.covers(p, p.radius);
    return p;
}

void append(SurfaceState& surface, SurfelNotes& notes, const Proposal& p) {
    Vec3 a, b;
    orthonormal_basis(p.normal, a, b);
    surface.surfels.position.push_back(p.position);
    surface.surfels.normal.push_back(p.normal);
    surface.surfels.axis1.push_back(p.radius * a);
    surface.surfels.axis2.push_back(p.radius * b);
    surface.id.push_back(surface.next_id++);
    surface.body.push_back(p.body);
    surface.rest.push_back(p.position);
    surface.velocity.push_back(Vec3(0, 0, 0));
    surface.temperature.push_back(0);
    notes.component.push_back(p.component);
    notes.curvature.push_back(p.curvature);
    notes.radius.push_back(p.radius);
    notes.lost.push_back(0);
}

/// Accepts the good proposals one after the other, each unless an accepted one is near; returns how many.
std::size_t accept(SurfaceState& surface, SurfelNotes& notes, const std::vector<Proposal>& proposals, Real full) {
    std::vector<Vec3> place;
    std::vector<Index> which;
    for (Index k = 0; k < proposals.size(); ++k)
        if (proposals[k].good) {
            place.push_back(proposals[k].position);
            which.push_back(k);
        }
    if (which.empty()) return 0;
    PointGrid grid;
    grid.build(place, full);
    std::vector<char> accepted(which.size(), 0);
    std::size_t count = 0;
    for (Index k = 0; k < which.size(); ++k) {
        const Proposal& p = proposals[which[k]];
        bool taken = false;
        grid.for_each_neighbour(p.position, kApart * p.radius, [&](Index other, Real) {
            const Proposal& q = proposals[which[other]];
            taken = taken || (accepted[other] && q.component == p.component && q.normal.dot(p.normal) > kSameSide);
        });
        if (taken) continue;
        accepted[k] = 1;
        ++count;
        append(surface, notes, p);
    }
    return count;
}

template <class T>
void keep(std::vector<T>& array, const std::vector<Index>& kept) {
    for (std::size_t k = 0; k < kept.size(); ++k) array[k] = array[kept[k]];
    array.resize(kept.size());
}

std::size_t remove_lost_and_crowded(SurfaceState& surface, SurfelNotes& notes, Real full) {
    const Cover cover(surface, notes, full);
    std::vector<char> gone(notes.lost);
    std::vector<Index> kept;
    for (Index i = 0; i < surface.size(); ++i) {
        cover.grid.for_each_neighbour(cover.position[i], kCrowded * cover.radius[i], [&](Index j, Real r2) {
            // The elder stays: surfels that are seen keep their places.
            if (gone[j] || surface.id[j] >= surface.id[i] || r2 >= square(kCrowded * cover.radius[j])) return;
            if (cover.component[j] == cover.component[i] && cover.normal[j].dot(cover.normal[i]) > kSameSide)
                gone[i] = 1;
        });
        if (!gone[i]) kept.push_back(i);
    }
    const std::size_t deleted = surface.size() - kept.size();
    for_each_array(surface, [&](const char*, auto& array) { keep(array, kept); });
    keep(notes.component, kept);
    keep(notes.curvature, kept);
    keep(notes.radius, kept);
    notes.lost.assign(kept.size(), 0);
    return deleted;
}

}  // namespace

ResampleReport resample(SurfaceState& surface, SurfelNotes& notes, const LiquidShape& shape, const Particles& particles,
                        const scene::Surface& params) {
    const Real full = Real(params.radius) * shape.spacing, per_radius = Real(params.support),
               reach = std::max(per_radius, Real(2)) * full;
    ResampleReport report;
    report.deleted = remove_lost_and_crowded(surface, notes, full);
    std::vector<Proposal> proposals(particles.size());
    {
        const Cover cover(surface, notes, reach);
        parallel_for(particles.size(), [&](std::size_t j) {
            proposals[j] = over_particle(static_cast<Index>(j), particles, shape, cover, full);
        });
    }
    report.inserted = accept(surface, notes, proposals, full);
    // Only surfels with a new neighbour can have got or lost a gap; in the first round that may be any.
    std::size_t looked_from = 0;
    for (int round = 0; round < kRounds; ++round) {
        const Cover cover(surface, notes, reach);
        std::vector<char> look(surface.size(), round == 0);
        for (std::size_t i = looked_from; i < surface.size(); ++i)
            cover.grid.for_each_neighbour(cover.position[i], 2 * full, [&](Index j, Real) { look[j] = 1; });
        looked_from = surface.size();
        proposals.assign(surface.size(), Proposal{});
        parallel_for(surface.size(), [&](std::size_t i) {
            if (!look[i]) return;
            Proposal& p = proposals[i];
            p = beside_surfel(static_cast<Index>(i), surface, cover);
            if (!p.good) return;
            settle(p, cover, shape, per_radius, full);
            if (p.good) p.good = !cover.covers(p, kApart * p.radius);
        });
        const std::size_t added = accept(surface, notes, proposals, full);
        report.inserted += added;
        if (added == 0) break;
    }
    return report;
}

}  // namespace thixo
