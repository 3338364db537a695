// Liquid surfaces part and join (dissertation 6.6.5): the events of fig. 6.8, in the scene itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "pipeline/contract/scene_io.h"
#include "pipeline/geometry/point_grid.h"
#include "sim/loop/step.h"
#include "sim/stage/setup.h"

namespace thixo {
namespace {

/// Connected pieces of surfels, by their highest z. Surfels of one piece touch (less than two radii apart) and face the
/// same way to 45 degrees.
std::vector<Real> pieces(const SurfaceState& surface) {
    const auto& x = surface.surfels.position;
    const auto& n = surface.surfels.normal;
    Real radius = 0;
    for (const Vec3& axis : surface.surfels.axis2) radius = std::max(radius, axis.norm());
    std::vector<Index> parent(x.size());
    std::iota(parent.begin(), parent.end(), Index(0));
    const auto root = [&](Index i) {
        while (parent[i] != i) i = parent[i] = parent[parent[i]];
        return i;
    };
    PointGrid grid;
    grid.build(x, 2 * radius);
    for (Index i = 0; i < x.size(); ++i)
        grid.for_each_neighbour(x[i], 2 * radius, [&](Index j, Real) {
            if (n[i].dot(n[j]) > Real(0.7071)) parent[root(i)] = root(j);
        });
    std::vector<Real> top(x.size(), -1);
    for (Index i = 0; i < x.size(); ++i) top[root(i)] = std::max(top[root(i)], x[i].z());
    std::erase(top, Real(-1));
    return top;
}

struct Count {
    long upper = 0, lower = 0;
};
Count count(const Simulation& s) {
    const std::vector<Real> top = pieces(s.surface);
    Count c;
    c.upper = std::ranges::count_if(top, [](Real z) { return z > 0; });
    c.lower = static_cast<long>(top.size()) - c.upper;
    return c;
}

TEST(Topology, ADrawnOutDropPartsAndTwoThatMeetBecomeOne) {
    Simulation s = make_simulation(scene::load_scene(THIXO_SOURCE_DIR "/configs/thesis/fig_6_08_topology.yaml"));
    refresh_surface(s);
    const Count first = count(s);
    EXPECT_EQ(first.upper, 1);
    EXPECT_EQ(first.lower, 2);
    // The lower drops are 0.102 m apart and approach each other at 0.32 m/s. Surfaces that bulged towards each other
    // would meet early.
    while (s.clock.time < 0.29) advance_frame(s);
    EXPECT_EQ(count(s).lower, 2) << "merged before they touched, at " << s.clock.time;
    while (s.clock.frame < s.problem.scene.frames.last) advance_frame(s);
    const Count last = count(s);
    EXPECT_GE(last.upper, 3) << "two drops and what was between";
    EXPECT_EQ(last.lower, 1);
}

}  // namespace
}  // namespace thixo
