#include "pipeline/geometry/point_grid.h"

#include <gtest/gtest.h>

#include <numeric>

#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"
#include "pipeline/geometry/neighbour_lists.h"

namespace thixo {
namespace {

Real random_in(std::uint64_t id, std::uint64_t use, double low, double high) {
    return static_cast<Real>(low + (high - low) * random_unit(11, id, 0, use));
}

std::vector<Vec3> uniform(std::size_t n, double low, double high) {
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < n; ++i)
        points.emplace_back(random_in(i, 0, low, high), random_in(i, 1, low, high), random_in(i, 2, low, high));
    return points;
}

std::vector<Vec3> clustered(std::size_t n) {
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < n; ++i) {
        const Vec3 centre(random_in(i % 7, 3, -3, 3), random_in(i % 7, 4, -3, 3), random_in(i % 7, 5, -3, 3));
        points.push_back(centre +
                         Real(0.2) * Vec3(random_in(i, 0, -1, 1), random_in(i, 1, -1, 1), random_in(i, 2, -1, 1)));
    }
    return points;
}

/// A cluster, and points so far away that no table of cells could hold them; some beyond the range of cell coordinates.
std::vector<Vec3> with_outliers() {
    std::vector<Vec3> points = uniform(200, -0.5, 0.5);
    for (const Real far : {Real(50), Real(-3e4), Real(2e7), Real(-1e18)}) {
        points.emplace_back(far, Real(0), Real(0.1));
        points.emplace_back(far, far, -far);
        points.emplace_back(far, far, -far);
    }
    return points;
}

std::vector<Vec3> duplicates() {
    std::vector<Vec3> points = uniform(60, 0, 0.5);
    for (int i = 0; i < 60; ++i) points.push_back(points[static_cast<std::size_t>(i) / 2]);
    return points;
}

/// Points almost a cell apart, near the corners of cells, where rounding decides the cell. Not a whole cell: whether
/// two points exactly one radius apart are neighbours is a matter of rounding in every method.
std::vector<Vec3> on_cell_borders() {
    const Real cell = Real(0.3) * (1 - Real(5e-6));
    std::vector<Vec3> points;
    for (int z = -3; z < 3; ++z)
        for (int y = -3; y < 3; ++y)
            for (int x = -3; x < 3; ++x) points.push_back(cell * Vec3(Real(x), Real(y), Real(z)));
    return points;
}

std::vector<std::vector<Vec3>> all_clouds() {
    return {uniform(700, -1, 1), uniform(300, -5, -4), clustered(500),  with_outliers(),
            duplicates(),        on_cell_borders(),    {Vec3(1, 2, 3)}, {}};
}

constexpr Real kRadius = Real(0.3);

std::vector<Index> brute_force(const std::vector<Vec3>& points, const Vec3& x, Real radius) {
    std::vector<Index> found;
    for (std::size_t j = 0; j < points.size(); ++j)
        if (square(points[j].x() - x.x()) + square(points[j].y() - x.y()) + square(points[j].z() - x.z()) <
            radius * radius)
            found.push_back(static_cast<Index>(j));
    return found;
}

std::vector<Vec3> in_cell_order(const std::vector<Vec3>& points) {
    std::vector<std::int64_t> ids(points.size());
    std::iota(ids.begin(), ids.end(), 0);
    std::vector<Vec3> sorted;
    for (const Index k : PointGrid::sort_order(points, ids, kRadius)) sorted.push_back(points[k]);
    return sorted;
}

TEST(PointGrid, GivesTheSameNeighboursAsBruteForce) {
    for (const auto& points : all_clouds()) {
        PointGrid grid;
        grid.build(points, kRadius);
        std::vector<Vec3> queries = points;
        for (const Vec3& x : uniform(50, -1.5, 1.5)) queries.push_back(x);
        for (const Vec3& x : queries) {
            std::vector<Index> found;
            grid.for_each_neighbour(x, kRadius, [&](Index j, Real r2) {
                found.push_back(j);
                EXPECT_LT(r2, kRadius * kRadius);
            });
            std::sort(found.begin(), found.end());
            ASSERT_EQ(found, brute_force(points, x, kRadius));
        }
    }
}

TEST(PointGrid, CandidatesHoldAllNeighboursOnce) {
    for (const auto& points : all_clouds()) {
        PointGrid grid;
        grid.build(points, kRadius);
        for (const Vec3& x : points) {
            std::vector<Index> found;
            grid.for_each_candidate(x, [&](Index j) { found.push_back(j); });
            std::sort(found.begin(), found.end());
            EXPECT_EQ(std::adjacent_find(found.begin(), found.end()), found.end());
            const auto near = brute_force(points, x, kRadius);
            EXPECT_TRUE(std::includes(found.begin(), found.end(), near.begin(), near.end()));
        }
    }
}

TEST(PointGrid, PointsInCellOrderKeepTheirIndicesAndAscend) {
    const auto points = in_cell_order(uniform(700, -1, 1));
    PointGrid grid;
    grid.build(points, kRadius);
    EXPECT_TRUE(grid.identity());
    for (const Vec3& x : points) {
        Index last = 0;
        grid.for_each_neighbour(x, kRadius, [&](Index j, Real) {
            EXPECT_GE(j, last);
            last = j;
        });
    }
}

TEST(PointGrid, OrderIsAFunctionOfCellAndIdOnly) {
    const auto points = clustered(500);
    std::vector<std::int64_t> ids(points.size());
    for (std::size_t i = 0; i < ids.size(); ++i) ids[i] = static_cast<std::int64_t>(mix64(i) >> 20);
    std::vector<Vec3> backwards(points.rbegin(), points.rend());
    std::vector<std::int64_t> ids_backwards(ids.rbegin(), ids.rend());
    const auto order = PointGrid::sort_order(points, ids, kRadius);
    const auto order_backwards = PointGrid::sort_order(backwards, ids_backwards, kRadius);
    for (std::size_t k = 0; k < order.size(); ++k) EXPECT_EQ(ids[order[k]], ids_backwards[order_backwards[k]]);
}

TEST(PointGrid, OrderOfNearlySortedPointsIsThatOfAPlainSort) {
    // Each point has a cell of its own along x, so that the order is that of x and ids. There are a few strays, rows of
    // strays, and no order at all.
    constexpr std::size_t kCount = 3000;
    const auto stray = [](std::uint64_t kind, std::size_t i) {
        const double r = random_unit(kind, i, 0, 0);
        switch (kind) {
            case 0:
                return r < 0.05 ? 4000 * random_unit(1, i, 0, 1) : static_cast<double>(i);
            case 1:
                return i / 40 % 9 == 4 ? static_cast<double>(i) + 700 : static_cast<double>(i);
            case 2:
                return i / 40 % 9 == 4 ? static_cast<double>(i) - 700 : static_cast<double>(i);
            case 3:
                return static_cast<double>(kCount - i);
            default:
                return std::floor(50 * r);
        }
    };
    for (std::uint64_t kind = 0; kind < 5; ++kind) {
        std::vector<Vec3> points;
        std::vector<std::int64_t> ids;
        for (std::size_t i = 0; i < kCount; ++i) {
            points.emplace_back(static_cast<Real>(std::floor(stray(kind, i)) + 0.5), Real(0.5), Real(0.5));
            ids.push_back(static_cast<std::int64_t>(7919 * i % kCount));
        }
        std::vector<Index> expected(kCount);
        std::iota(expected.begin(), expected.end(), Index(0));
        std::sort(expected.begin(), expected.end(), [&](Index a, Index b) {
            return std::pair(points[a].x(), ids[a]) < std::pair(points[b].x(), ids[b]);
        });
        EXPECT_EQ(PointGrid::sort_order(points, ids, 1), expected) << kind;
    }
}

TEST(PointGrid, NearestAreThoseOfBruteForce) {
    for (const auto& points : all_clouds()) {
        PointGrid grid;
        grid.build(points, kRadius);
        for (const Vec3& x : uniform(40, -2, 2))
            for (const int k : {1, 10, 1000})
                for (const Real reach : {Real(0.2), Real(5)}) {
                    std::vector<std::pair<Real, Index>> expected, found;
                    for (std::size_t j = 0; j < points.size(); ++j) {
                        const Real r2 = square(points[j].x() - x.x()) + square(points[j].y() - x.y()) +
                                        square(points[j].z() - x.z());
                        if (r2 < reach * reach) expected.emplace_back(r2, static_cast<Index>(j));
                    }
                    std::sort(expected.begin(), expected.end());
                    if (expected.size() > static_cast<std::size_t>(k)) expected.resize(static_cast<std::size_t>(k));
                    grid.nearest(x, k, reach, found);
                    ASSERT_EQ(found, expected);
                }
    }
}

TEST(PointGrid, PointsThatAreNotFiniteAreNeverFound) {
    auto points = uniform(100, 0, 1);
    const Real nan = std::numeric_limits<Real>::quiet_NaN(), inf = std::numeric_limits<Real>::infinity();
    points[3] = Vec3(nan, 0, 0);
    points[50] = Vec3(0.5, inf, 0);
    PointGrid grid;
    grid.build(points, kRadius);
    NeighbourLists lists;
    lists.build(grid, kRadius);
    for (std::size_t i = 0; i < points.size(); ++i)
        for (const Index j : lists[i]) EXPECT_TRUE(j != 3 && j != 50);
    grid.for_each_neighbour(points[3], kRadius, [](Index, Real) { FAIL(); });
}

TEST(PointGrid, RefusesACellWithoutSize) {
    PointGrid grid;
    EXPECT_DEATH(grid.build({}, 0), "cell edge 0");
}

TEST(NeighbourLists, AreThoseOfBruteForceWithoutTheParticleItself) {
    for (const auto& cloud : all_clouds())
        for (const auto& points : {cloud, in_cell_order(cloud)}) {
            PointGrid grid;
            grid.build(points, kRadius);
            NeighbourLists lists;
            // Twice, with a smaller radius first: storage is kept between builds and must not show.
            for (const Real radius : {Real(0.5) * kRadius, kRadius}) {
                lists.build(grid, radius);
                ASSERT_EQ(lists.size(), points.size());
                std::size_t total = 0;
                for (std::size_t i = 0; i < points.size(); ++i) {
                    auto expected = brute_force(points, points[i], radius);
                    std::erase(expected, static_cast<Index>(i));
                    std::vector<Index> found(lists[i].begin(), lists[i].end());
                    if (grid.identity()) {
                        EXPECT_TRUE(std::is_sorted(found.begin(), found.end()));
                    }
                    std::sort(found.begin(), found.end());
                    ASSERT_EQ(found, expected);
                    total += found.size();
                }
                EXPECT_EQ(lists.total(), total);
            }
        }
}

TEST(NeighbourLists, OfQueriesAreThoseOfBruteForce) {
    for (const auto& points : all_clouds()) {
        PointGrid grid;
        grid.build(points, kRadius);
        const auto queries = uniform(100, -1.5, 1.5);
        NeighbourLists lists;
        lists.build(grid, queries, kRadius);
        ASSERT_EQ(lists.size(), queries.size());
        for (std::size_t q = 0; q < queries.size(); ++q) {
            std::vector<Index> found(lists[q].begin(), lists[q].end());
            std::sort(found.begin(), found.end());
            ASSERT_EQ(found, brute_force(points, queries[q], kRadius));
        }
    }
}

TEST(NeighbourLists, DoNotDependOnTheThreadCount) {
    const auto points = in_cell_order(uniform(5000, -1, 1));
    std::vector<std::vector<Index>> first;
    for (const int threads : {1, 2, 3}) {
        set_thread_count(threads);
        PointGrid grid;
        grid.build(points, kRadius);
        NeighbourLists lists;
        lists.build(grid, kRadius);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const std::vector<Index> list(lists[i].begin(), lists[i].end());
            if (threads == 1)
                first.push_back(list);
            else
                ASSERT_EQ(list, first[i]);
        }
    }
    set_thread_count(0);
}

}  // namespace
}  // namespace thixo
