// A bust that is melted and cast: the events of fig. 6.12 of the dissertation, in the scene itself.
#include <gtest/gtest.h>

#include <algorithm>

#include "pipeline/contract/scene_io.h"
#include "sim/loop/step.h"
#include "sim/stage/setup.h"
#include "sim/surface/volume.h"
#include "tests/physics/gate.h"

namespace thixo {
namespace {

void go_on_to(Simulation& s, double time) {
    while (s.clock.time < time) advance_frame(s);
}

double mean_melt(const Simulation& s) {
    double sum = 0;
    for (const Real b : s.particles.melt) sum += static_cast<double>(b);
    return sum / static_cast<double>(s.particles.size());
}

double mean_height(const Simulation& s) {
    double sum = 0;
    for (const Vec3& x : s.particles.position) sum += static_cast<double>(x.z());
    return sum / static_cast<double>(s.particles.size());
}

/// The share of the particles whose centres are inside the mould's shape.
double cast_share(const Simulation& s) {
    const Shape& cast = s.problem.moulds.front().shape;
    const auto inside =
        std::ranges::count_if(s.particles.position, [&](const Vec3& x) { return cast.distance(x) < 0; });
    return static_cast<double>(inside) / static_cast<double>(s.particles.size());
}

/// Median distance of the surfels near the mould's shape from it [m].
double distance_from_mould(const Simulation& s) {
    const Mould& mould = s.problem.moulds.front();
    std::vector<double> distance;
    for (const Vec3& x : s.surface.surfels.position) {
        const double d = std::abs(static_cast<double>(mould.shape.distance(x)));
        if (d < static_cast<double>(mould.reach)) distance.push_back(d);
    }
    std::ranges::sort(distance);
    return distance.empty() ? 1 : distance[distance.size() / 2];
}

// Times are those of the scene: it is heated until 1.6 s, cooled from 3.8 to 4.2 s, and the halves part from 4.3 s on.
TEST(Mould, ABustMeltsIntoItFreezesAndDropsOut) {
    Simulation s = make_simulation(scene::load_scene(THIXO_SOURCE_DIR "/configs/thesis/fig_6_12_mould.yaml"));
    refresh_surface(s);
    const double spacing = static_cast<double>(s.problem.smoothing.spacing);
    const Real radius = static_cast<Real>(s.problem.scene.surface.radius) * s.problem.smoothing.spacing;
    double matter = 0;
    for (const Real v : s.particles.rest_volume) matter += static_cast<double>(v);
    EXPECT_EQ(mean_melt(s), 0);
    EXPECT_EQ(cast_share(s), 0);
    go_on_to(s, 3.7);
    EXPECT_GT(mean_melt(s), 0.95);
    gate::expect({"fig_6_12_mould", "of the matter that is in the mould", "%", 100 * cast_share(s), 100, 5,
                  "need: the mould is filled"});
    go_on_to(s, 4.25);
    EXPECT_LT(mean_melt(s), 0.02);
    const double volume = surface_volume(s.surface, s.particles, s.walls, radius);
    gate::expect({"fig_6_12_mould", "error of the surface's volume when frozen", "%", 100 * (volume / matter - 1), 0, 5,
                  gate::kBoundOnChange});
    // Particles fill a mould to half a spacing. The surface lines it up to 0.15 spacings inside its walls
    // (LiquidShape::wall_depth). Another 0.05 are for places that bend more sharply than discs do.
    gate::expect({"fig_6_12_mould", "median distance of the surface from the mould", "spacings",
                  distance_from_mould(s) / spacing, 0, 0.2, "depth of the lining and of its bends"});
    const double held = mean_height(s);
    go_on_to(s, 5.9);
    EXPECT_LT(mean_melt(s), 0.02);
    EXPECT_LT(mean_height(s), held - 0.2) << "it hangs in its mould";
}

}  // namespace
}  // namespace thixo
