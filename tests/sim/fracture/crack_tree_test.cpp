// Sight through sheets: a segment crosses a sheet or it does not, and no shared edge lets one slip through.
#include "sim/fracture/crack_tree.h"

#include <gtest/gtest.h>

#include <numeric>
#include <set>

#include "pipeline/base/random.h"

namespace thixo {
namespace {

double unit(std::uint64_t id, std::uint64_t use) { return random_unit(7, id, 0, use); }

/// A wavy sheet over the unit square, of n x n squares.
Cracks wavy_sheet(int n) {
    Cracks cracks;
    cracks.cracks = {{}};
    for (int i = 0; i <= n; ++i)
        for (int k = 0; k <= n; ++k) {
            const Real x = static_cast<Real>(i) / static_cast<Real>(n), y = static_cast<Real>(k) / static_cast<Real>(n);
            cracks.vertex.push_back({x, y, Real(0.1) * std::sin(7 * x) * std::cos(5 * y)});
        }
    const auto at = [&](int i, int k) { return static_cast<Index>(i * (n + 1) + k); };
    CrackTriangles& t = cracks.triangles;
    for (int i = 0; i < n; ++i)
        for (int k = 0; k < n; ++k)
            for (const auto& v : {std::array{at(i, k), at(i + 1, k), at(i + 1, k + 1)},
                                  std::array{at(i, k), at(i + 1, k + 1), at(i, k + 1)}}) {
                const Index row = append_row(t);
                t.a[row] = v[0], t.b[row] = v[1], t.c[row] = v[2];
            }
    return cracks;
}

CrackTree tree_of(const Cracks& cracks) {
    std::vector<Index> rows(cracks.triangles.size());
    std::iota(rows.begin(), rows.end(), Index(0));
    return CrackTree(cracks, rows);
}

/// Of a wavy sheet, as it is, or sheared so that its triangles are slivers.
class FanOfWays : public testing::TestWithParam<double> {};

TEST_P(FanOfWays, CrossesWhatEachWayDoes) {
    Cracks cracks = wavy_sheet(20);
    const auto shear = static_cast<Real>(GetParam());
    for (Vec3& v : cracks.vertex) v.x() += shear * v.y();
    const CrackTree tree = tree_of(cracks);
    std::size_t crossings = 0;
    for (std::uint64_t n = 0; n < 3000; ++n) {
        // From lattice places too, on the sheet and beside it: there ways meet edges and vertices.
        const bool exact = n % 3 == 0;
        const auto place = [&](std::uint64_t use, double height) {
            const auto along = [&](std::uint64_t axis) {
                const double u = unit(n, 3 * use + axis);
                return static_cast<Real>(exact ? std::floor(u * 19 + 1) / 20 : 0.01 + 0.98 * u);
            };
            const Real y = along(1);
            return Vec3(along(0) + shear * y, y, static_cast<Real>(height * (2 * unit(n, 3 * use + 2) - 1)));
        };
        const Vec3 from = n % 2 == 0 ? cracks.vertex[n % cracks.vertex.size()] : place(0, 0.2);
        std::vector<Vec3> to;
        for (std::uint64_t k = 1; k <= 1 + n % 61; ++k) to.push_back(place(k, 0.3));
        WayFan fan;
        fan.start(from);
        for (const Vec3& x : to) fan.add(x);
        fan.finish();
        std::set<std::pair<std::size_t, Index>> together, alone;
        const bool any = tree.for_each_crossing(
            fan, [&](std::size_t k) { return to[k]; }, [](std::size_t) { return true; },
            [&](std::size_t k, Index row) { together.emplace(k, row); });
        for (std::size_t k = 0; k < to.size(); ++k)
            tree.for_each_crossing(from, to[k], [&](Index row, const Vec3&) { alone.emplace(k, row); });
        ASSERT_EQ(together, alone) << "fan " << n;
        ASSERT_EQ(any, !alone.empty());
        crossings += alone.size();
    }
    EXPECT_GT(crossings, 10000u);
}
INSTANTIATE_TEST_SUITE_P(Sheared, FanOfWays, testing::Values(0.0, 30.0));

TEST(CrackTree, NoSegmentSlipsThroughASheet) {
    const Cracks cracks = wavy_sheet(20);
    const CrackTree tree = tree_of(cracks);
    // Through vertices and along lattice lines as well: there two or more triangles share the crossing.
    for (std::uint64_t k = 0; k < 100000; ++k) {
        const bool exact = k % 4 == 0;
        const auto coordinate = [&](std::uint64_t use) {
            const double u = unit(k, use);
            return static_cast<Real>(exact ? std::floor(u * 19 + 1) / 20 : 0.01 + 0.98 * u);
        };
        const Vec3 a(coordinate(1), coordinate(2), 1),
            b(exact ? a.x() : coordinate(3), exact ? a.y() : coordinate(4), -1);
        int crossings = 0;
        tree.for_each_crossing(a, b, [&](Index, const Vec3&) { ++crossings; });
        ASSERT_GE(crossings, 1) << "segment " << k;
    }
}

TEST(CrackTree, FindsTheCrossingsThatAllTrianglesGive) {
    const Cracks cracks = wavy_sheet(8);
    const CrackTree tree = tree_of(cracks);
    const CrackTriangles& t = cracks.triangles;
    for (std::uint64_t k = 0; k < 2000; ++k) {
        const auto place = [&](std::uint64_t use) {
            return Vec3(static_cast<Real>(unit(k, use)), static_cast<Real>(unit(k, use + 1)),
                        static_cast<Real>(0.4 * unit(k, use + 2) - 0.2));
        };
        const Vec3 a = place(1), b = place(4);
        std::set<Index> found, all;
        tree.for_each_crossing(a, b, [&](Index row, const Vec3&) { found.insert(row); });
        for (Index row = 0; row < t.size(); ++row) {
            const CrackTree one(cracks, std::array{row});
            one.for_each_crossing(a, b, [&](Index r, const Vec3&) { all.insert(r); });
        }
        ASSERT_EQ(found, all) << "segment " << k;
    }
}

TEST(CrackTree, TheNearestTriangleIsNearest) {
    const Cracks cracks = wavy_sheet(8);
    const CrackTree tree = tree_of(cracks);
    for (std::uint64_t k = 0; k < 500; ++k) {
        const Vec3 x(static_cast<Real>(unit(k, 1)), static_cast<Real>(unit(k, 2)), static_cast<Real>(unit(k, 3) - 0.5));
        const auto odd = [](Index row) { return row % 2 == 1; };
        const auto near = tree.nearest(x, 2, odd);
        ASSERT_TRUE(near.has_value());
        Real least = 2;
        for (Index row = 1; row < cracks.triangles.size(); row += 2)
            if (const auto one = CrackTree(cracks, std::array{row}).nearest(x, 2, odd))
                least = std::min(least, one->distance);
        EXPECT_EQ(near->distance, least);
        EXPECT_EQ(near->triangle % 2, 1u);
        EXPECT_FALSE(tree.nearest(x, near->distance, odd).has_value()) << "closer than the reach, or none";
    }
}

}  // namespace
}  // namespace thixo
