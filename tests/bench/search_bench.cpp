// Neighbour search: all neighbours of all particles, by the grid and by nanoflann on the same sorted points, in the
// same run. Read the ratio of the two processor times. The aim is that the grid is seven times as fast.
#include <benchmark/benchmark.h>

#include <nanoflann.hpp>

#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"
#include "pipeline/geometry/neighbour_lists.h"

namespace {

using thixo::Index;
using thixo::Real;
using thixo::Vec3;

constexpr Real kSpacing = 0.01f;

/// A cube of about n particles on a lattice shaken by a quarter of the spacing, in cell order.
std::vector<Vec3> shaken_cube(std::size_t n, Real cell) {
    const int side = static_cast<int>(std::cbrt(static_cast<double>(n)) + 0.5);
    std::vector<Vec3> points;
    std::vector<std::int64_t> ids;
    for (int z = 0; z < side; ++z)
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                const std::uint64_t id = points.size();
                const auto shake = [&](int use) { return Real(thixo::random_unit(1, id, 0, use) - 0.5) * Real(0.5); };
                points.push_back(kSpacing * Vec3(Real(x) + shake(0), Real(y) + shake(1), Real(z) + shake(2)));
                ids.push_back(static_cast<std::int64_t>(id));
            }
    std::vector<Vec3> sorted;
    for (const Index k : thixo::PointGrid::sort_order(points, ids, cell)) sorted.push_back(points[k]);
    return sorted;
}

struct Adaptor {
    const std::vector<Vec3>& points;
    std::size_t kdtree_get_point_count() const { return points.size(); }
    Real kdtree_get_pt(std::size_t i, std::size_t axis) const { return points[i][static_cast<Eigen::Index>(axis)]; }
    template <class B>
    bool kdtree_get_bbox(B&) const {
        return false;
    }
};
using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<Real, Adaptor>, Adaptor, 3>;

void report(benchmark::State& state, std::size_t points, std::size_t pairs) {
    state.counters["neighbours"] = static_cast<double>(pairs) / static_cast<double>(points);
    state.counters["s/particle"] =
        benchmark::Counter(static_cast<double>(points) * static_cast<double>(state.iterations()),
                           benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void grid_search(benchmark::State& state) {
    thixo::set_thread_count(1);
    const Real radius = Real(0.01 * state.range(1)) * kSpacing;
    const auto points = shaken_cube(static_cast<std::size_t>(state.range(0)), radius);
    thixo::PointGrid grid;
    thixo::NeighbourLists lists;
    for (auto _ : state) {
        grid.build(points, radius);
        lists.build(grid, radius);
        benchmark::DoNotOptimize(lists[0].data());
    }
    report(state, points.size(), lists.total());
}

void grid_visit(benchmark::State& state) {
    thixo::set_thread_count(1);
    const Real radius = Real(0.01 * state.range(1)) * kSpacing;
    const auto points = shaken_cube(static_cast<std::size_t>(state.range(0)), radius);
    thixo::PointGrid grid;
    std::size_t pairs = 0;
    for (auto _ : state) {
        grid.build(points, radius);
        pairs = 0;
        for (const Vec3& p : points) grid.for_each_neighbour(p, radius, [&](Index, Real) { ++pairs; });
    }
    report(state, points.size(), pairs);
}

void nanoflann_search(benchmark::State& state) {
    const Real radius = Real(0.01 * state.range(1)) * kSpacing;
    const auto points = shaken_cube(static_cast<std::size_t>(state.range(0)), radius);
    const Adaptor adaptor{points};
    std::vector<std::pair<std::uint32_t, Real>> found;
    nanoflann::SearchParams unsorted;
    unsorted.sorted = false;
    std::size_t pairs = 0;
    for (auto _ : state) {
        Tree tree(3, adaptor, nanoflann::KDTreeSingleIndexAdaptorParams(16));
        tree.buildIndex();
        pairs = 0;
        for (const Vec3& p : points) pairs += tree.radiusSearch(p.data(), radius * radius, found, unsorted);
    }
    report(state, points.size(), pairs);
}

// Arguments: particles, radius in hundredths of the spacing. A radius of 2.12 spacings sees 40 particles, itself
// included.
BENCHMARK(grid_search)->Args({300763, 212})->Args({97336, 212})->Args({97336, 200})->Unit(benchmark::kMillisecond);
BENCHMARK(grid_visit)->Args({300763, 212})->Unit(benchmark::kMillisecond);
BENCHMARK(nanoflann_search)->Args({300763, 212})->Args({97336, 212})->Args({97336, 200})->Unit(benchmark::kMillisecond);

}  // namespace
