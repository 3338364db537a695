#include "tests/physics/pour_check.h"

#include <algorithm>
#include <numeric>

#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"
#include "sim/loop/step.h"
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
        grid.for_each_neighbour(x, h / 2, [&](Index, Real) { near = true; });
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

/// Connected pieces of surfels, which touch each other and face the same side.
Sets pieces_of(const SurfelCloud& cloud, Real touch) {
    const PointGrid grid = grid_of(cloud.position, touch);
    Sets pieces(cloud.size());
    for (Index i = 0; i < cloud.size(); ++i)
        grid.for_each_neighbour(cloud.position[i], touch, [&](Index j, Real) {
            if (cloud.normal[i].dot(cloud.normal[j]) > kAgree) pieces.join(i, j);
        });
    return pieces;
}

/// Distance of x from disc i. It is a little too large beside very long ellipses.
Real distance_from_disc(const SurfelCloud& cloud, Index i, const Vec3& x) {
    const Vec3 offset = x - cloud.position[i], &a = cloud.axis1[i], &b = cloud.axis2[i];
    Real u = offset.dot(a) / a.squaredNorm(), v = offset.dot(b) / b.squaredNorm();
    const Real out = std::max(std::hypot(u, v), Real(1));
    return (offset - u / out * a - v / out * b).norm();
}

/// Largest distances between two surfaces.
class Comparison {
  public:
    Comparison(const Walls& walls, Real touch, Real support) : walls_(walls), touch_(touch), support_(support) {}

    void compare(const SurfelCloud& a, const SurfelCloud& b) {
        note_gone(a, b);
        note_gone(b, a);
        const PointGrid left_out = grid_of(gone_, support_);
        add_distances(a, b, left_out);
        add_distances(b, a, left_out);
        std::ranges::sort(distances_);
    }
    const std::vector<Real>& distances() const { return distances_; }  // [m], sorted

  private:
    /// The surfels of those pieces of `a` that have no surfel of `b` near them on their side.
    void note_gone(const SurfelCloud& a, const SurfelCloud& b) {
        Sets pieces = pieces_of(a, touch_);
        const PointGrid grid = grid_of(b.position, touch_);
        std::vector<char> goes_on(a.size(), 0);
        for (Index i = 0; i < a.size(); ++i)
            grid.for_each_neighbour(a.position[i], touch_, [&](Index j, Real) {
                if (a.normal[i].dot(b.normal[j]) > kAgree) goes_on[pieces.root(i)] = 1;
            });
        for (Index i = 0; i < a.size(); ++i)
            if (!goes_on[pieces.root(i)]) gone_.push_back(a.position[i]);
    }
    void add_distances(const SurfelCloud& a, const SurfelCloud& b, const PointGrid& left_out) {
        const PointGrid grid = grid_of(b.position, support_);
        for (const Vec3& x : a.position) {
            bool skip = wall_distance(walls_, x) < 0;
            if (!gone_.empty()) left_out.for_each_neighbour(x, support_, [&](Index, Real) { skip = true; });
            if (skip) continue;
            Real distance = support_;
            grid.for_each_neighbour(x, support_,
                                    [&](Index j, Real) { distance = std::min(distance, distance_from_disc(b, j, x)); });
            distances_.push_back(distance);
        }
    }

    const Walls& walls_;
    Real touch_, support_;
    std::vector<Vec3> gone_;
    std::vector<Real> distances_;
};

Real touch_of(const Simulation& s) {
    return static_cast<Real>(2 * s.problem.scene.surface.radius) * s.problem.smoothing.spacing;
}

void measure_pops(const Simulation& s, PourFrame& frame) {
    const std::vector<Real> moves = moves_when_frozen(s);
    if (moves.empty()) return;
    frame.pop = static_cast<double>(moves.back());
    frame.pop99 = static_cast<double>(moves[moves.size() * 99 / 100]);
}

/// The surfels that are not hidden in walls: places and normals.
SurfelCloud seen_of(const Simulation& s) {
    SurfelCloud seen;
    const SurfelCloud& all = s.surface.surfels;
    for (std::size_t i = 0; i < all.size(); ++i)
        if (wall_distance(s.walls, all.position[i]) >= 0) {
            seen.position.push_back(all.position[i]);
            seen.normal.push_back(all.normal[i]);
        }
    return seen;
}

void count_pieces(const Simulation& s, PourFrame& frame) {
    const SurfelCloud seen = seen_of(s);
    const auto &x = s.particles.position, &y = seen.position;
    const Real h = s.problem.smoothing.support, reach = Real(1.15) * h;
    const PointGrid particles = grid_of(x, reach);
    Sets clusters(x.size());
    for (Index i = 0; i < x.size(); ++i)
        particles.for_each_neighbour(x[i], reach, [&](Index j, Real) { clusters.join(i, j); });
    Sets pieces = pieces_of(seen, touch_of(s));
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

std::vector<Real> moves_between(const Simulation& s, const SurfelCloud& a, const SurfelCloud& b) {
    const Real h = s.problem.smoothing.support;
    Comparison comparison(s.walls, touch_of(s), h);
    comparison.compare(a, b);
    std::vector<Real> moves = comparison.distances();
    for (Real& move : moves) move /= h;
    return moves;
}

std::vector<Real> moves_when_frozen(const Simulation& s) {
    const scene::Surface& params = s.problem.scene.surface;
    const SurfaceSetting setting{s.walls, params, s.problem.smoothing.spacing, s.problem.smoothing.support,
                                 s.problem.moulds};
    SurfaceState again = s.surface;
    Particles frozen = s.particles;
    frozen.surface_position = frozen.position;
    if (s.embedded.size() == 0) {
        update_surface(again, frozen, setting);
    } else {
        Solids solids = s.solids;
        MixedSurface mixed = s.mixed_surface;
        std::vector<Index> source = s.embedded_source;
        update_mixed_surface(s.embedded, solids, frozen, setting, mixed, again, source);
    }
    return moves_between(s, s.surface.surfels, again.surfels);
}

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
