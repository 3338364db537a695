// How often the surface is brought up to date: as often as the motion of the matter asks, not as often as it is fast.
#include <gtest/gtest.h>

#include "pipeline/contract/scene_io.h"
#include "sim/loop/step.h"
#include "sim/stage/setup.h"
#include "sim/surface/volume.h"

namespace thixo {
namespace {

Simulation started(const std::string& blocks) {
    Simulation s =
        make_simulation(scene::parse_scene("frames: {first: 0, last: 8, fps: 24}\n" + blocks, "updates.yaml"));
    refresh_surface(s);
    evaluate(s);
    return s;
}

int updates_of_next_frame(Simulation& s) {
    const int before = s.stats.surface_updates;
    advance_frame(s);
    return s.stats.surface_updates - before;
}

double volume_error(const Simulation& s) {
    const Real radius = static_cast<Real>(s.problem.scene.surface.radius) * s.problem.smoothing.spacing;
    const double matter = parallel_sum(s.particles.size(),
                                       [&](std::size_t i) { return static_cast<double>(s.particles.rest_volume[i]); });
    return std::abs(surface_volume(s.surface, s.particles, s.walls, radius) / matter - 1);
}

const std::string kWater = "materials: {water: {}}\n", kFine = "solver: {spacing: 0.01, pressure: dfsph}\n",
                  kCoarse = "solver: {spacing: 0.015, pressure: dfsph}\n";

TEST(SurfaceUpdates, MatterThatFallsFreelyIsUpdatedOnceAFrameHoweverFast) {
    const std::string drops =
        "bodies: {drops: {material: water, velocity: [0, 0, -9], shape: {repeat: {count: 6, step: [0.03, 0, 0], "
        "shapes: [{repeat: {count: 6, step: [0, 0.03, 0], shapes: [{sphere: {radius: 0.006}}]}}]}}}}\n";
    const std::string ball =
        "bodies: {ball: {material: water, velocity: [3, 0, -9], shape: {sphere: {radius: 0.05}}}}\n";
    for (const std::string& body : {drops, ball}) {
        Simulation s = started(kWater + kFine + body);
        for (int frame = 1; frame <= 4; ++frame) EXPECT_EQ(updates_of_next_frame(s), 1) << body << " frame " << frame;
    }
}

TEST(SurfaceUpdates, TheSurfaceOfASplashHoldsItsVolumeWithSevenUpdatesAFrameOrFewer) {
    const std::string splash =
        "world: {boundaries: {tank: {inside: true, shape: {box: {size: [0.24, 0.24, 0.6]}, translate: [0, 0, 0.3]}}}}\n"
        "bodies:\n"
        "  pool: {material: water, shape: {box: {size: [0.24, 0.24, 0.06]}, translate: [0, 0, 0.03]}}\n"
        "  ball: {material: water, velocity: [0, 0, -4], shape: {sphere: {radius: 0.06}, translate: [0, 0, 0.2]}}\n";
    Simulation s = started(kWater + kCoarse + splash);
    int most = 0;
    for (int frame = 1; frame <= 4; ++frame) {
        const int updates = updates_of_next_frame(s);
        EXPECT_LE(updates, 7) << frame;
        most = std::max(most, updates);
        EXPECT_LT(volume_error(s), 0.02) << frame;  // the need: two hundredths, as in the film of a pour
    }
    EXPECT_GT(most, 1);  // surfels that come from far are not left where the first update puts them
}

}  // namespace
}  // namespace thixo
