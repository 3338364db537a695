#include "tests/physics/pour_check.h"

#include <algorithm>
#include <numeric>

#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"
#include "pipeline/geometry/implicit_surface.h"
#include "sim/step.h"
#include "sim/surface/volume.h"
#include "tests/sim/surface/discs.h"

namespace thixo::gate {
namespace {

constexpr Real kAgree = Real(0.7071);

class Sets {
  public:
    explicit Sets(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), Index(0)); }
    Index root(Index i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    void join(Index a, Index b) { parent_[root(a)] = root(b); }

  private:
    std::vector<Index> parent_;
};

PointGrid grid_of(const std::vector<Vec3>& points, Real cell) {
    PointGrid grid;
    grid.build(points, cell);
    return grid;
}

void count_holes(const Simulation& s, std::size_t rays, PourFrame& frame) {
    const SurfelCloud& cloud = s.surface.surfels;
    const Real h = s.problem.smoothing.support;
    const PointGrid grid = grid_of(cloud.position, h);
    std::vector<Vec3> from;
    for (const Vec3& x : s.particles.position) {
        bool near = false;
        grid.for_each_neighbour(x, h, [&](Index, Real) { near = true; });
        if (!near) from.push_back(x);
    }
    if (from.empty()) return;
    frame.rays = rays;
    const fixture::Discs discs(cloud, fixture::widest(cloud));
    const auto seed = static_cast<std::uint64_t>(frame.frame);
    frame.holes = static_cast<std::size_t>(parallel_sum(rays, [&](std::size_t k) {
        const Vec3& x = from[random_bits(7, k, seed, 2) % from.size()];
        return discs.hit(x, fixture::random_direction(k + seed * rays), 1) ? 0.0 : 1.0;
    }));
}

/// F of a cloud at x among surfels that face as n does.
std::optional<Real> level(const SurfelCloud& cloud, const PointGrid& grid, const Vec3& x, const Vec3& n) {
    const Poly6 w(grid.cell());
    SurfelAverage average;
    grid.for_each_neighbour(x, grid.cell(), [&](Index j, Real r2) {
        if (cloud.normal[j].dot(n) > kAgree) average.add(w.value(r2), cloud.position[j] - x, cloud.normal[j]);
    });
    return average.defined() ? std::optional(average.value()) : std::nullopt;
}

void measure_pops(const Simulation& s, PourFrame& frame) {
    const scene::Surface& params = s.problem.scene.surface;
    const Real spacing = s.problem.smoothing.spacing, h = s.problem.smoothing.support;
    const Real support = static_cast<Real>(params.radius * params.support) * spacing;
    SurfaceState again = s.surface;
    Particles frozen = s.particles;
    frozen.surface_position = frozen.position;
    update_surface(again, frozen, s.walls, params, spacing, h, s.problem.moulds);
    const SurfelCloud &a = s.surface.surfels, &b = again.surfels;
    const PointGrid before = grid_of(a.position, support), after = grid_of(b.position, support);
    std::vector<Vec3> changed;  // where sides came or went
    for (std::size_t i = 0; i < a.size(); ++i)
        if (!level(b, after, a.position[i], a.normal[i])) changed.push_back(a.position[i]);
    for (std::size_t i = 0; i < b.size(); ++i)
        if (!level(a, before, b.position[i], b.normal[i])) changed.push_back(b.position[i]);
    const PointGrid left_out = grid_of(changed, h);
    std::vector<double> moves;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const Vec3& x = a.position[i];
        bool skip = wall_distance(s.walls, x) < 0;  // hidden in a wall
        if (!changed.empty()) left_out.for_each_neighbour(x, h, [&](Index, Real) { skip = true; });
        if (skip) continue;
        moves.push_back(
            static_cast<double>(std::abs(*level(b, after, x, a.normal[i]) - *level(a, before, x, a.normal[i])) / h));
    }
    if (moves.empty()) return;
    std::ranges::sort(moves);
    frame.pop = moves.back();
    frame.pop99 = moves[moves.size() * 99 / 100];
}

void count_pieces(const Simulation& s, PourFrame& frame) {
    const auto &x = s.particles.position, &y = s.surface.surfels.position;
    const auto& n = s.surface.surfels.normal;
    const Real h = s.problem.smoothing.support;
    const PointGrid particles = grid_of(x, h);
    Sets clusters(x.size());
    for (Index i = 0; i < x.size(); ++i)
        particles.for_each_neighbour(x[i], h, [&](Index j, Real) { clusters.join(i, j); });
    const Real touch = static_cast<Real>(2 * s.problem.scene.surface.radius) * s.problem.smoothing.spacing;
    const PointGrid surfels = grid_of(y, touch);
    Sets pieces(y.size());
    for (Index i = 0; i < y.size(); ++i)
        surfels.for_each_neighbour(y[i], touch, [&](Index j, Real) {
            if (n[i].dot(n[j]) > kAgree) pieces.join(i, j);
        });
    std::vector<Index> cluster(y.size(), kNone);  // of each piece, by its root
    std::vector<char> bridge(y.size(), 0);
    for (Index i = 0; i < y.size(); ++i) {
        Real nearest = std::numeric_limits<Real>::max();
        Index of = kNone;
        particles.for_each_neighbour(y[i], h, [&](Index j, Real r2) {
            if (r2 >= nearest) return;
            nearest = r2;
            of = clusters.root(j);
        });
        Index& first = cluster[pieces.root(i)];
        if (first == kNone) first = of;
        if (of != kNone && of != first) bridge[pieces.root(i)] = 1;
    }
    for (Index i = 0; i < y.size(); ++i) frame.pieces += pieces.root(i) == i;
    frame.bridges = static_cast<std::size_t>(std::ranges::count(bridge, 1));
}

}  // namespace

PourFrame check_frame(const Simulation& s, std::size_t rays) {
    PourFrame frame;
    frame.frame = s.clock.frame;
    frame.particles = s.particles.size();
    frame.surfels = s.surface.size();
    if (s.surface.size() == 0) return frame;
    count_holes(s, rays, frame);
    const Real radius = static_cast<Real>(s.problem.scene.surface.radius) * s.problem.smoothing.spacing;
    const double matter =
        parallel_sum(s.particles.size(), [&](std::size_t i) { return double(s.particles.rest_volume[i]); });
    frame.volume = surface_volume(s.surface, s.particles, s.walls, radius) / matter;
    measure_pops(s, frame);
    count_pieces(s, frame);
    return frame;
}

void check_pour(Simulation& s, int last, std::size_t rays, const std::function<void(const PourFrame&)>& f) {
    refresh_surface(s);
    while (s.clock.frame < last) {
        advance_frame(s);
        f(check_frame(s, rays));
    }
}

}  // namespace thixo::gate
