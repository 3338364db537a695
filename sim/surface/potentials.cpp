#include "sim/surface/potentials.h"

#include <algorithm>
#include <array>

#include "pipeline/base/lanes.h"
#include "pipeline/base/parallel.h"
#include "pipeline/geometry/implicit_surface.h"

namespace thixo {
namespace {

constexpr Real kFacesAlike = Real(0.70710678);  // cosine of 45 degrees
constexpr Real kFlatMean =
    Real(0.2461);  // distance of the particles' mean from a flat surface, in supports: 1/10 / int_0^1 (1 - u^2)^4 du
constexpr Real kRepulsion = Real(0.1);
constexpr Real kMostLag = Real(0.1);  // largest lag behind the iso-surface, in spacings
// In spacings: distance of a surfel adrift from the iso-surface; that of one still on the way; moves of such a surfel.
constexpr Real kAdrift = Real(0.12), kLate = Real(0.10), kStillMoves = Real(0.05);
/// S_i and S_sub of every surfel, and the packed fields for sums over S_i.
struct Surroundings {
    SurfelLists& lists;
    std::vector<Quad> place;   // s, psi_orth(s) - s along n [m]
    std::vector<Quad> facing;  // n, 1 where the last component of `place` counts
};

/// The forces on a surfel in one iteration, before any surfel moves.
struct Pull {
    Vec3 guide{0, 0, 0};  // psi_I(s) - s [m]
    Vec3 n_guide{0, 0, 0};
    Real attract = 0;  // along the normal [m]
    Real smooth = 0;   // psi_orth(s) - s along the normal [m]
    Vec3 n_smooth{0, 0, 0};
    Vec3 repel{0, 0, 0};
    Vec3 slide{0, 0, 0};    // the way back from the crease where the sheet ends [m]
    Vec3 towards{0, 0, 0};  // unit tangent to the crease; zero: none near
    Real room = 0;          // towards it [m]
    bool coat = false;      // lines a wall
    MouldPull mould;
};

/// Guiding and attracting forces: those of the particles.
Fate pull_of_particles(Pull& pull, const WorkingSurfels& all, Index i, const LiquidShape& shape) {
    const Vec3& n = all.normal[i];
    const Real radius = all.radius[i];
    const SheetSample at = shape.sheet(all.position[i], n, all.component[i], all.wall[i], all.colour[i]);
    if (!at.coat && at.phi > kDeepest) return Fate::buried;
    if (!at.defined || at.outward.dot(n) < 0) return Fate::lost;       // the side that it belonged to is gone
    if (at.to_crease < -Real(0.7) * shape.spacing) return Fate::lost;  // far beyond the edge of its sheet
    pull.guide = at.guide;
    pull.n_guide = at.outward;
    pull.coat = at.coat;
    // The row along the crease stands off from it. Its discs are shortened to end there, and still overlap the next
    // row's.
    const Real excess = at.to_crease - at.stand_off * radius;
    if (excess < radius) {
        pull.slide = std::clamp(excess, Real(-0.2) * shape.spacing, Real(0)) * at.towards_crease;
        pull.towards = at.towards_crease;
        pull.room = std::max(excess, Real(0));
    }
    if (!at.coat && at.to_crease > shape.support) pull.attract = n.dot(at.centre) + kFlatMean * shape.support;
    return Fate::stays;
}

void pack(Surroundings& around, const WorkingSurfels& all) {
    around.place.resize(all.size() + 1);
    around.facing.resize(all.size() + 1);
    // The last entry pads runs: no normal agrees with zero.
    around.place[all.size()] = around.facing[all.size()] = {0, 0, 0, 0};
    parallel_for(all.size(), [&](std::size_t i) {
        const Vec3 &place = all.position[i], &n = all.normal[i];
        around.place[i] = {place.x(), place.y(), place.z(), 0};
        around.facing[i] = {n.x(), n.y(), n.z(), 0};
    });
}

/// f_repel: away from the nearest surfels, stronger for nearer ones. It ends at the farthest of them, and does not jump
/// when another takes that place. Distances are in radii of the pair: the spacing follows the surfels' size.
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

/// A run of neighbours of a surfel. Weights are w_poly6 over the support up to a factor, zero for those of another
/// side.
struct WeightedRun {
    Lanes weight;
    Lanes x, y, z;         // offsets [m]
    Lanes nx, ny, nz;      // normals
    Lanes smooth, counts;  // the last components of Surroundings' quads
};

/// Calls f(WeightedRun) for runs of the neighbours of surfel i.
template <class F>
void for_each_weighted_run(const Surroundings& around, Index i, Real support, F&& f) {
    const Quad p = around.place[i], n = around.facing[i];
    const Real per_h2 = 1 / square(support);
    const auto nobody = static_cast<Index>(around.place.size() - 1);
    for_each_run(around.lists.near(i), nobody, [&](const Index* j) {
        Lanes x, y, z, smooth, nx, ny, nz, counts;
        gather(around.place.data(), j, x, y, z, smooth);
        gather(around.facing.data(), j, nx, ny, nz, counts);
        x -= p.x;
        y -= p.y;
        z -= p.z;
        const Lanes q = positive(1 - (x * x + y * y + z * z) * per_h2), agree = nx * n.x + ny * n.y + nz * n.z;
        const Lanes w = agree >= kFacesAlike ? q * q * q : Lanes{};
        f(WeightedRun{w, x, y, z, nx, ny, nz, smooth, counts});
    });
}

/// The smoothing force: the average of the neighbouring surfels.
void pull_of_average(Pull& pull, Index i, const WorkingSurfels& all, const Surroundings& around, Real support) {
    SurfelSums sums;
    for_each_weighted_run(around, i, support, [&](const WeightedRun& run) {
        sums.add(run.weight, run.x, run.y, run.z, run.nx, run.ny, run.nz);
    });
    SurfelAverage average = sums.average();
    average.add(1, Vec3(0, 0, 0), all.normal[i]);  // the surfel itself
    pull.n_smooth = average.unit_normal();
    pull.smooth = -average.value();
}

/// Mean of psi_orth(s_j) - s_j over the neighbours of i and itself.
Real mean_smooth(const Surroundings& around, Index i, Real support) {
    Lanes weight{}, sum{};
    for_each_weighted_run(around, i, support, [&](const WeightedRun& run) {
        weight += run.weight * run.counts;
        sum += run.weight * run.counts * run.smooth;
    });
    return (around.place[i].w + sum_of(sum)) / (1 + sum_of(weight));
}

/// What all surfels share in one iteration.
struct IterationParams {
    const scene::Surface& params;
    Real damping;   // a [1]
    Real most_lag;  // [m]
};

/// Moves surfel i by a step, with `smooth` as f_smooth along the normal. Returns how far a point of its disc moves.
Real step(const WorkingSurfels& all, Index i, const Pull& pull, Real smooth, Real smoothness,
          const IterationParams& iteration) {
    Vec3 &place = all.position[i], &n = all.normal[i];
    const Real radius = all.radius[i], most_lag = iteration.most_lag, damping = iteration.damping;
    const scene::Surface& k = iteration.params;
    const Real k_guide = Real(k.guide), k_attract = Real(k.attract) * smoothness,
               k_smooth = Real(k.smooth) * smoothness;
    const Real k_ext = pull.mould.weight;
    const Real share = k_ext > 0 ? 1 / std::max(Real(1), k_guide + k_attract + k_smooth + k_ext) : Real(1);
    // Walls are smooth and exactly known: the liquid's coat follows them at once. So does the part of a lag behind the
    // iso-surface beyond the largest: otherwise it would follow in later updates, when nothing else moves.
    const Real off = n.dot(pull.guide), lag = off - std::clamp(off, -most_lag, most_lag);
    const Real potentials =
        k_guide * off + k_attract * pull.attract + k_smooth * smooth + k_ext * n.dot(pull.mould.force);
    const Real normal_force = pull.coat ? off : share * potentials + (1 - share * k_ext) * (1 - share * k_guide) * lag;
    Vec3 tangent_force = kRepulsion * (pull.repel - n * n.dot(pull.repel));
    const Real length = tangent_force.norm();
    if (length > Real(0.25) * radius) tangent_force *= Real(0.25) * radius / length;
    const Real beyond = tangent_force.dot(pull.towards) - pull.room;
    if (beyond > 0) tangent_force -= beyond * pull.towards;  // no neighbour pushes a surfel over the edge of its sheet
    const Vec3 move = damping * (n * normal_force + tangent_force) + pull.slide;
    const Vec3 old_n = n;
    place += move;
    const Vec3 turned = k_guide * pull.n_guide + k_smooth * pull.n_smooth + k_ext * pull.mould.outward;
    if (pull.coat)
        n = pull.n_guide;
    else if (turned.squaredNorm() > 0)  // without any weight the normal stays
        n = turned.normalized();
    return std::max(move.norm(), radius * (n - old_n).norm());
}

/// A surfel is inactive while neither it nor a neighbour moves: most of a calm surface is so after one iteration.
void find_active(std::vector<char>& active, const WorkingSurfels& all, const std::vector<Real>& moved,
                 const Surroundings& around, Real tolerance) {
    parallel_for(all.size(), [&](std::size_t i) {
        bool any = moved[i] >= tolerance;
        for (const Index j : around.lists.near(i)) {
            if (any) break;
            any = moved[j] >= tolerance;
        }
        active[i] = any && !all.lost[i] && all.melt[i] > 0;
    });
}

/// Whether a surfel is adrift. It may have come to rest off the surface although liquid and walls alone guide it. The
/// cavity, drop or coat that it lay on has then vanished. Or it is still on its way from afar, below faster ones.
/// `moved` is its move in the last iteration [m].
bool is_adrift(const WorkingSurfels& all, std::size_t i, Real smoothness, Real moved, const LiquidShape& shape) {
    const SheetSample at = shape.sheet(all.position[i], all.normal[i], all.component[i], all.wall[i], all.colour[i]);
    if (!at.defined || (!at.coat && at.phi > kDeepest)) return true;
    const Real off = std::abs(at.guide.dot(all.normal[i])) / shape.spacing;
    return at.coat || smoothness <= 0 ? off > kAdrift : off > kLate && moved > kStillMoves * shape.spacing;
}

/// Brings surfels outside the iso-surface I_min back to it. Those that cannot be brought back are lost.
void constrain(const WorkingSurfels& all, const std::vector<Real>& smoothness, const std::vector<Real>& moved,
               const LiquidShape& shape) {
    const Real least = Real(0.6) * shape.iso;
    parallel_for(all.size(), [&](std::size_t i) {
        if (all.lost[i] || !(all.melt[i] > 0)) return;
        if (is_adrift(all, i, smoothness[i], moved[i], shape)) {
            all.lost[i] = static_cast<char>(Fate::lost);
            return;
        }
        if (shape.colour(all.position[i], all.component[i], all.colour[i]).value >= least) return;
        if (!shape.project(all.position[i], all.component[i], shape.spacing, least))
            all.lost[i] = static_cast<char>(Fate::lost);
    });
}

}  // namespace

RelaxReport relax(WorkingSurfels all, const LiquidShape& shape, const scene::Surface& params,
                  const std::vector<Mould>& moulds) {
    constexpr std::size_t kGrain = 64;
    const std::size_t n = all.size();
    const Real per_radius = Real(params.support), margin = Real(0.3) * shape.spacing;
    std::vector<Pull> pulls(n);
    Surroundings around{all.lists, {}, {}};
    RelaxReport report;
    Real damping = 1;
    const Real tolerance = Real(0.01) * shape.spacing;
    std::vector<char> active(n, 0);
    std::vector<Real> moved(n, 0), smoothness(n, 1);
    parallel_for(n, [&](std::size_t i) {
        active[i] = !all.lost[i] && all.melt[i] > 0;
        const Real bend = per_radius * all.radius[i] * all.curvature[i];
        smoothness[i] = clamp01((Real(1.4) - bend) / Real(0.5));
    });
    for (; report.iterations < params.iterations; ++report.iterations) {
        if (around.lists.stale(all.position))
            around.lists.build({all.position, all.normal, all.component}, all.radius, per_radius, margin);
        pack(around, all);
        const auto pull = [&](std::size_t k) {
            if (!active[k]) return;
            const auto i = static_cast<Index>(k);
            pulls[i] = Pull{};
            all.lost[i] = static_cast<char>(pull_of_particles(pulls[i], all, i, shape));
            if (all.lost[i]) return;
            if (!pulls[i].coat && smoothness[i] > 0)
                pull_of_average(pulls[i], i, all, around, per_radius * all.radius[i]);
            if (!moulds.empty() && !pulls[i].coat)
                pulls[i].mould = pull_of_moulds(moulds, all.position[i], all.normal[i], shape.spacing / 64);
            pulls[i].repel = repulsion(all, i, around.lists.nearest(i), per_radius);
        };
        parallel_for(n, pull, kGrain);
        parallel_for(n, [&](std::size_t i) {
            around.place[i].w = pulls[i].smooth;
            around.facing[i].w = all.lost[i] || pulls[i].coat || smoothness[i] <= 0 ? Real(0) : Real(1);
        });
        const auto move = [&](std::size_t k) {
            const auto i = static_cast<Index>(k);
            moved[i] = 0;
            if (!active[i] || all.lost[i]) return;
            const bool smooths = !pulls[i].coat && smoothness[i] > 0;
            const Real smooth =
                smooths ? pulls[i].smooth - mean_smooth(around, i, per_radius * all.radius[i]) : Real(0);
            moved[i] = step(all, i, pulls[i], smooth, smoothness[i], {params, damping, kMostLag * shape.spacing});
        };
        parallel_for(n, move, kGrain);
        report.largest_move = parallel_reduce(
            n, Real(0), [&](std::size_t i) { return moved[i]; }, [](Real a, Real b) { return std::max(a, b); });
        damping *= Real(0.9);
        if (report.largest_move < tolerance) {
            ++report.iterations;
            break;
        }
        find_active(active, all, moved, around, tolerance);
    }
    constrain(all, smoothness, moved, shape);
    return report;
}

}  // namespace thixo
