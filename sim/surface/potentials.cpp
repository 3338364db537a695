#include "sim/surface/potentials.h"

#include <algorithm>
#include <array>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/implicit_surface.h"
#include "pipeline/geometry/neighbour_lists.h"

namespace thixo {
namespace {

constexpr Real kAgree = Real(0.70710678);   // cosine of 45 degrees
constexpr Real kFlatMean = Real(0.2461);    // distance of the particles' mean from a flat surface, in supports: 1/10 / int_0^1 (1 - u^2)^4 du
constexpr Real kRepulsion = Real(0.1);
constexpr Real kDeepest = Real(0.8);        // phi beyond which a surfel is inside the body and lost
constexpr int kNearest = 10;                // |S_sub|

/// What one iteration knows of a surfel before any moves.
struct Pull {
    Vec3 guide{0, 0, 0};     // psi_I(s) - s [m]
    Vec3 n_guide{0, 0, 0};
    Real attract = 0;        // along the normal [m]
    Real smooth = 0;         // psi_orth(s) - s along the normal [m]
    Vec3 n_smooth{0, 0, 0};
    Vec3 repel{0, 0, 0};
    bool wall = false;
};

/// Guiding and attracting: the particles' forces. False where the surfel is lost.
bool pull_of_particles(Pull& pull, const Vec3& s, const Vec3& n, std::int32_t component, const LiquidShape& shape) {
    const DepthSample at = shape.depth(s, component);
    const Real slope2 = at.gradient.squaredNorm();
    if (!at.defined || (at.phi > kDeepest && !at.wall)) return false;
    if (slope2 < square(Real(0.05))) return false;
    pull.guide = -at.depth / slope2 * at.gradient;
    const Real length = pull.guide.norm(), longest = Real(0.5) * shape.spacing;
    if (length > longest) pull.guide *= longest / length;
    pull.n_guide = at.outward();
    if (pull.n_guide.dot(n) < 0) return false;  // the side it belonged to is gone
    pull.wall = at.wall;
    if (!at.wall) pull.attract = n.dot(at.centre) + kFlatMean * shape.support;
    return true;
}

/// Smoothing and repulsion: the neighbouring surfels' forces.
void pull_of_surfels(Pull& pull, Index i, const WorkingSurfels& all, std::span<const Index> neighbours, Real support) {
    const Poly6 w(support);
    const Vec3 &s = all.position[i], &n = all.normal[i];
    SurfelAverage average;
    average.add(w.value(0), Vec3(0, 0, 0), n);
    std::array<std::pair<Real, Index>, kNearest> nearest;
    std::size_t count = 0;
    for (const Index j : neighbours) {
        if (all.component[j] != all.component[i] || all.normal[j].dot(n) < kAgree) continue;
        const Vec3 offset = all.position[j] - s;
        const Real r2 = offset.squaredNorm();
        average.add(w.value(r2), offset, all.normal[j]);
        const std::pair<Real, Index> entry(r2, j);
        if (count == nearest.size() && !(entry < nearest.back())) continue;
        const std::size_t last = count < nearest.size() ? count++ : count - 1;
        nearest[last] = entry;
        for (std::size_t k = last; k > 0 && nearest[k] < nearest[k - 1]; --k) std::swap(nearest[k], nearest[k - 1]);
    }
    pull.n_smooth = average.unit_normal();
    pull.smooth = -average.value();
    // The farthest of S_sub ends the force, so that it does not jump when another surfel takes that place.
    const Real reach = count == nearest.size() ? std::sqrt(nearest.back().first) : support;
    for (std::size_t k = 0; k < count; ++k) {
        const Real r = std::sqrt(nearest[k].first);
        if (r > 0 && r < reach) pull.repel += (reach - r) / r * (s - all.position[nearest[k].second]);
    }
}

/// Mean of psi_orth(s_j) - s_j over the neighbours of i and itself.
Real mean_smooth(const std::vector<Pull>& pulls, Index i, const WorkingSurfels& all, std::span<const Index> neighbours, Real support) {
    const Poly6 w(support);
    Real weight = w.value(0), sum = weight * pulls[i].smooth;
    for (const Index j : neighbours) {
        if (all.lost[j] || pulls[j].wall || all.component[j] != all.component[i] || all.normal[j].dot(all.normal[i]) < kAgree) continue;
        const Real a = w.value((all.position[j] - all.position[i]).squaredNorm());
        weight += a;
        sum += a * pulls[j].smooth;
    }
    return sum / weight;
}

/// The step of one surfel; returns its length.
Real step(Vec3& s, Vec3& n, const Pull& pull, Real smooth, const scene::Surface& k, Real damping, Real radius) {
    const Real k_guide = Real(k.guide), k_attract = Real(k.attract), k_smooth = Real(k.smooth);
    // Walls are smooth and exactly known: the liquid's coat follows them at once.
    const Real normal_force = pull.wall ? n.dot(pull.guide)
                                        : n.dot(k_guide * pull.guide) + k_attract * pull.attract + k_smooth * smooth;
    Vec3 tangent_force = kRepulsion * (pull.repel - n * n.dot(pull.repel));
    const Real length = tangent_force.norm();
    if (length > Real(0.25) * radius) tangent_force *= Real(0.25) * radius / length;
    const Vec3 move = damping * (n * normal_force + tangent_force);
    s += move;
    n = pull.wall ? pull.n_guide : (k_guide * pull.n_guide + k_smooth * pull.n_smooth).normalized();
    return move.norm();
}

/// Brings back what left the iso-surface I_min; a surfel that cannot be is lost.
void constrain(const WorkingSurfels& all, const LiquidShape& shape) {
    const Real least = Real(0.6) * shape.iso;
    parallel_for(all.size(), [&](std::size_t i) {
        if (all.lost[i]) return;
        const DepthSample at = shape.depth(all.position[i], all.component[i], least);
        if (at.defined && (at.wall || at.depth >= 0)) return;
        if (!shape.project(all.position[i], all.component[i], shape.spacing, least)) all.lost[i] = 1;
    });
}

}  // namespace

RelaxReport relax(WorkingSurfels all, const LiquidShape& shape, const scene::Surface& params) {
    const Real radius = Real(params.radius) * shape.spacing, support = Real(params.support) * radius;
    std::vector<Pull> pulls(all.size());
    PointGrid grid;
    NeighbourLists neighbours;
    RelaxReport report;
    Real damping = 1;
    for (; report.iterations < params.iterations; ++report.iterations) {
        grid.build(all.position, support);
        neighbours.build(grid, support);
        parallel_for(all.size(), [&](std::size_t i) {
            pulls[i] = Pull{};
            if (all.lost[i]) return;
            pull_of_surfels(pulls[i], static_cast<Index>(i), all, neighbours[i], support);
            if (!pull_of_particles(pulls[i], all.position[i], all.normal[i], all.component[i], shape)) all.lost[i] = 1;
        });
        std::vector<Real> smooth(all.size(), 0), moved(all.size(), 0);
        parallel_for(all.size(), [&](std::size_t i) {
            if (!all.lost[i])
                smooth[i] = pulls[i].smooth - mean_smooth(pulls, static_cast<Index>(i), all, neighbours[i], support);
        });
        parallel_for(all.size(), [&](std::size_t i) {
            if (!all.lost[i]) moved[i] = step(all.position[i], all.normal[i], pulls[i], smooth[i], params, damping, radius);
        });
        report.largest_move = parallel_reduce(
            all.size(), Real(0), [&](std::size_t i) { return moved[i]; }, [](Real a, Real b) { return std::max(a, b); });
        damping *= Real(0.9);
        if (report.largest_move < Real(0.01) * shape.spacing) {
            ++report.iterations;
            break;
        }
    }
    constrain(all, shape);
    return report;
}

}  // namespace thixo
