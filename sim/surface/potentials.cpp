#include "sim/surface/potentials.h"

#include <algorithm>
#include <array>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/implicit_surface.h"
#include "pipeline/geometry/neighbour_lists.h"
#include "sim/surface/resample.h"

namespace thixo {
namespace {

constexpr Real kAgree = Real(0.70710678);  // cosine of 45 degrees
constexpr Real kFlatMean =
    Real(0.2461);  // distance of the particles' mean from a flat surface, in supports: 1/10 / int_0^1 (1 - u^2)^4 du
constexpr Real kRepulsion = Real(0.1);
constexpr Real kDeepest = Real(0.8);  // phi beyond which a surfel is inside the body and lost
constexpr int kNearest = 10;          // |S_sub|

/// P_i, S_i and S_sub of every surfel, listed with a margin to move in.
struct Surroundings {
    NeighbourLists particles;                          // points of the liquid within h
    NeighbourLists surfels;                            // within h_s
    std::vector<std::array<Index, kNearest>> nearest;  // the ten nearest of its side; kNone where there are fewer
    std::vector<WallPlane> walls;                      // beside each
    PointGrid wide, surfel_grid;
    Real travelled = std::numeric_limits<Real>::max();  // at most, by any surfel, since the lists were made [m]
};

/// What one iteration knows of a surfel before any moves.
struct Pull {
    Vec3 guide{0, 0, 0};  // psi_I(s) - s [m]
    Vec3 n_guide{0, 0, 0};
    Real attract = 0;  // along the normal [m]
    Real smooth = 0;   // psi_orth(s) - s along the normal [m]
    Vec3 n_smooth{0, 0, 0};
    Vec3 repel{0, 0, 0};
    Vec3 slide{0, 0, 0};    // back from the crease where the sheet ends [m]
    Vec3 towards{0, 0, 0};  // the crease, unit tangent; zero: none near
    Real room = 0;          // towards it [m]
    bool coat = false;      // lines a wall
};

/// Guiding and attracting: the particles' forces. False where the surfel is lost.
bool pull_of_particles(Pull& pull, const Vec3& s, const Vec3& n, std::int32_t component, const LiquidShape& shape,
                       std::span<const Index> near, const WallPlane& wall, Real radius) {
    const SheetSample at = shape.sheet(shape.colour(s, component, near), wall, s, n);
    if (!at.defined || at.outward.dot(n) < 0) return false;       // the side it belonged to is gone
    if (!at.coat && at.phi > kDeepest) return false;              // inside the body
    if (at.to_crease < -Real(0.7) * shape.spacing) return false;  // far beyond the edge of its sheet
    pull.guide = at.guide;
    pull.n_guide = at.outward;
    pull.coat = at.coat;
    // The row along the crease stands kFromCrease away from it: its discs, shortened to end there, then still overlap
    // the next row's.
    const Real excess = at.to_crease - kFromCrease * radius;
    if (excess < radius) {
        pull.slide = std::clamp(excess, Real(-0.2) * shape.spacing, Real(0)) * at.towards_crease;
        pull.towards = at.towards_crease;
        pull.room = std::max(excess, Real(0));
    }
    if (!at.coat && at.to_crease > shape.support) pull.attract = n.dot(at.centre) + kFlatMean * shape.support;
    return true;
}

/// Whether two surfels are neighbours on one side of one body.
bool same_side(const WorkingSurfels& all, Index i, Index j) {
    return all.component[j] == all.component[i] && all.normal[j].dot(all.normal[i]) >= kAgree;
}

std::array<Index, kNearest> find_nearest(const WorkingSurfels& all, Index i, std::span<const Index> neighbours) {
    std::array<std::pair<Real, Index>, kNearest> found;
    found.fill({std::numeric_limits<Real>::max(), kNone});
    for (const Index j : neighbours) {
        const std::pair<Real, Index> entry((all.position[j] - all.position[i]).squaredNorm(), j);
        if (!(entry < found.back()) || !same_side(all, i, j)) continue;
        found.back() = entry;
        for (std::size_t k = found.size() - 1; k > 0 && found[k] < found[k - 1]; --k) std::swap(found[k], found[k - 1]);
    }
    std::array<Index, kNearest> nearest;
    for (std::size_t k = 0; k < nearest.size(); ++k) nearest[k] = found[k].second;
    return nearest;
}

/// Makes the lists anew where surfels may have left their margins.
void look_around(Surroundings& around, const WorkingSurfels& all, const LiquidShape& shape, Real surfel_support) {
    const Real margin = Real(0.2) * shape.spacing;
    if (around.travelled < margin / 2) return;
    around.travelled = 0;
    around.wide.build(shape.points.position, shape.support + margin);
    around.particles.build(around.wide, all.position, shape.support + margin / 2);
    around.surfel_grid.build(all.position, surfel_support + margin);
    around.surfels.build(around.surfel_grid, surfel_support + margin);
    around.walls.resize(all.size());
    parallel_for(all.size(), [&](std::size_t i) {
        const ColourSample c = shape.colour(all.position[i], all.component[i], around.particles[i]);
        if (c.near_wall) around.walls[i] = shape.wall_plane(all.position[i], c.out);
    });
    around.nearest.resize(all.size());
    parallel_for(all.size(), [&](std::size_t i) {
        around.nearest[i] = find_nearest(all, static_cast<Index>(i), around.surfels[i]);
    });
}

/// f_repel: away from the nearest, the more the nearer, ending at the farthest of them so that it does not jump when
/// another takes that place. Distances count in radii of the pair: the spacing follows the surfels' size.
Vec3 repulsion(const WorkingSurfels& all, Index i, const std::array<Index, kNearest>& nearest, Real per_radius) {
    const auto distance = [&](Index j) {
        return (all.position[i] - all.position[j]).norm() / ((all.radius[i] + all.radius[j]) / 2);
    };
    Real reach = nearest.back() == kNone ? per_radius : Real(0);
    for (const Index j : nearest)
        if (j != kNone) reach = std::max(reach, distance(j));
    Vec3 force(0, 0, 0);
    for (const Index j : nearest) {
        if (j == kNone) break;
        const Real r = distance(j);
        if (r > 0 && r < reach) force += (reach - r) * (all.position[i] - all.position[j]).normalized();
    }
    return force * all.radius[i];
}

/// Smoothing and repulsion: the neighbouring surfels' forces.
void pull_of_surfels(Pull& pull, Index i, const WorkingSurfels& all, const Surroundings& around, Real per_radius) {
    const Poly6 w(per_radius * all.radius[i]);
    SurfelAverage average;
    average.add(w.value(0), Vec3(0, 0, 0), all.normal[i]);
    for (const Index j : around.surfels[i]) {
        const Vec3 offset = all.position[j] - all.position[i];
        const Real a = w.value(offset.squaredNorm());
        if (a > 0 && same_side(all, i, j)) average.add(a, offset, all.normal[j]);
    }
    pull.n_smooth = average.unit_normal();
    pull.smooth = -average.value();
    pull.repel = repulsion(all, i, around.nearest[i], per_radius);
}

/// Mean of psi_orth(s_j) - s_j over the neighbours of i and itself.
Real mean_smooth(const std::vector<Pull>& pulls, Index i, const WorkingSurfels& all, std::span<const Index> neighbours,
                 Real support) {
    const Poly6 w(support);
    Real weight = w.value(0), sum = weight * pulls[i].smooth;
    for (const Index j : neighbours) {
        const Real a = w.value((all.position[j] - all.position[i]).squaredNorm());
        if (a <= 0 || all.lost[j] || pulls[j].coat || !same_side(all, i, j)) continue;
        weight += a;
        sum += a * pulls[j].smooth;
    }
    return sum / weight;
}

/// The step of one surfel; returns how far a point of its disc moves by it.
Real step(Vec3& s, Vec3& n, const Pull& pull, Real smooth, Real smoothness, const scene::Surface& k, Real damping,
          Real radius) {
    const Real k_guide = Real(k.guide), k_attract = Real(k.attract) * smoothness,
               k_smooth = Real(k.smooth) * smoothness;
    // Walls are smooth and exactly known: the liquid's coat follows them at once.
    const Real normal_force =
        pull.coat ? n.dot(pull.guide) : n.dot(k_guide * pull.guide) + k_attract * pull.attract + k_smooth * smooth;
    Vec3 tangent_force = kRepulsion * (pull.repel - n * n.dot(pull.repel));
    const Real length = tangent_force.norm();
    if (length > Real(0.25) * radius) tangent_force *= Real(0.25) * radius / length;
    const Real beyond = tangent_force.dot(pull.towards) - pull.room;
    if (beyond > 0) tangent_force -= beyond * pull.towards;  // no neighbour pushes a surfel over the edge of its sheet
    const Vec3 move = damping * (n * normal_force + tangent_force) + pull.slide;
    const Vec3 old_n = n;
    s += move;
    n = pull.coat ? pull.n_guide : (k_guide * pull.n_guide + k_smooth * pull.n_smooth).normalized();
    return std::max(move.norm(), radius * (n - old_n).norm());
}

/// A surfel rests while neither it nor a neighbour moves: most of a calm surface does after one look.
void find_active(std::vector<char>& active, const WorkingSurfels& all, const std::vector<Real>& moved,
                 const Surroundings& around, Real tolerance) {
    parallel_for(all.size(), [&](std::size_t i) {
        bool any = moved[i] >= tolerance;
        for (const Index j : around.surfels[i]) any = any || moved[j] >= tolerance;
        active[i] = any && !all.lost[i];
    });
}

/// Brings back what left the iso-surface I_min; a surfel that cannot be is lost.
void constrain(const WorkingSurfels& all, const LiquidShape& shape) {
    const Real least = Real(0.6) * shape.iso;
    parallel_for(all.size(), [&](std::size_t i) {
        if (all.lost[i]) return;
        if (shape.colour(all.position[i], all.component[i]).value >= least) return;
        if (!shape.project(all.position[i], all.component[i], shape.spacing, least)) all.lost[i] = 1;
    });
}

}  // namespace

RelaxReport relax(WorkingSurfels all, const LiquidShape& shape, const scene::Surface& params) {
    const Real per_radius = Real(params.support), widest = per_radius * Real(params.radius) * shape.spacing;
    std::vector<Pull> pulls(all.size());
    Surroundings around;
    RelaxReport report;
    Real damping = 1;
    const Real tolerance = Real(0.01) * shape.spacing;
    std::vector<char> active(all.size(), 0);
    for (std::size_t i = 0; i < all.size(); ++i) active[i] = !all.lost[i];
    std::vector<Real> smooth(all.size(), 0), moved(all.size(), 0), smoothness(all.size(), 1);
    parallel_for(all.size(), [&](std::size_t i) {
        const Real bend = per_radius * all.radius[i] * all.curvature[i];
        smoothness[i] = clamp01((Real(1.4) - bend) / Real(0.5));
    });
    for (; report.iterations < params.iterations; ++report.iterations) {
        look_around(around, all, shape, widest);
        parallel_for(all.size(), [&](std::size_t i) {
            if (!active[i]) return;
            pulls[i] = Pull{};
            pull_of_surfels(pulls[i], static_cast<Index>(i), all, around, per_radius);
            if (!pull_of_particles(pulls[i], all.position[i], all.normal[i], all.component[i], shape,
                                   around.particles[i], around.walls[i], all.radius[i]))
                all.lost[i] = 1;
        });
        parallel_for(all.size(), [&](std::size_t i) {
            if (active[i])
                smooth[i] = pulls[i].smooth - mean_smooth(pulls, static_cast<Index>(i), all, around.surfels[i],
                                                          per_radius * all.radius[i]);
        });
        parallel_for(all.size(), [&](std::size_t i) {
            moved[i] = 0;
            if (active[i] && !all.lost[i])
                moved[i] = step(all.position[i], all.normal[i], pulls[i], smooth[i], smoothness[i], params, damping,
                                all.radius[i]);
        });
        report.largest_move = parallel_reduce(
            all.size(), Real(0), [&](std::size_t i) { return moved[i]; },
            [](Real a, Real b) { return std::max(a, b); });
        around.travelled += report.largest_move;
        damping *= Real(0.9);
        if (report.largest_move < tolerance) {
            ++report.iterations;
            break;
        }
        find_active(active, all, moved, around, tolerance);
    }
    constrain(all, shape);
    return report;
}

}  // namespace thixo
