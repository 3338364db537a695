// Runs of matter that melts and freezes: the same bits after a resume, and at any thread count.
#include <gtest/gtest.h>

#include "pipeline/base/parallel.h"
#include "sim/phase/phases.h"
#include "sim/stage/checkpoint.h"
#include "tests/sim/heat/heat_of.h"
#include "tests/sim/phase/wax.h"

namespace thixo {
namespace {

using namespace fixture::melting;

TEST(Melting, ResumedRunEqualsTheUninterruptedOneBitForBit) {
    Simulation whole = make_simulation(busy());
    for (int k = 0; k < 3; ++k) advance_frame(whole);
    const std::string half = print_checkpoint(whole, "hash");
    for (int k = 0; k < 3; ++k) advance_frame(whole);
    Simulation resumed = make_simulation(busy());
    parse_checkpoint(half, "half", "hash", resumed);
    for (int k = 0; k < 3; ++k) advance_frame(resumed);
    bool part = false;
    for (const Real b : whole.particles.melt) part = part || (b > 0 && b < 1);
    EXPECT_TRUE(part);
    // Surfels of the melting block and of the liquids are animated, those of the toy displaced.
    EXPECT_GT(whole.mixed_surface.animated.size(), 400u);
    EXPECT_GT(whole.surface.size(), whole.mixed_surface.animated.size());
    EXPECT_TRUE(print_checkpoint(whole, "hash") == print_checkpoint(resumed, "hash"));
}

TEST(Melting, ARunResumedAfterFreezingEqualsTheUninterruptedOne) {
    scene::Scene scene = fixture::empty_space();
    scene.world.gravity = {0, 0, -9.81};
    scene.surface.enabled = true;
    scene.world.boundaries = {fixture::floor_at(0)};
    scene.materials = {wax()};
    scene.materials[0].melting.liquid.viscosity = 20;
    scene.bodies = {of(fixture::body("block", box({0, 0, 0.031}, {0.06, 0.06, 0.06})), "wax", 80)};
    Simulation whole = make_simulation(scene);
    advance_frame(whole);
    set_temperature(whole, [](const Vec3&) { return 20; });
    advance_frame(whole);
    set_temperature(whole, [](const Vec3& x) { return x.x() > 0 ? 52 : 20; });
    advance_frame(whole);
    const std::string half = print_checkpoint(whole, "hash");
    advance_frame(whole);
    Simulation resumed = make_simulation(scene);
    parse_checkpoint(half, "half", "hash", resumed);
    advance_frame(resumed);
    EXPECT_TRUE(whole.solids.bodies[0].refrozen);
    EXPECT_TRUE(print_checkpoint(whole, "hash") == print_checkpoint(resumed, "hash"));
}

TEST(Melting, StateIsTheSameAtAnyThreadCount) {
    std::string first;
    for (const int threads : {1, 2, 3}) {
        set_thread_count(threads);
        Simulation s = make_simulation(busy());
        for (int k = 0; k < 4; ++k) advance_frame(s);
        const std::string state = print_checkpoint(s, "hash");
        if (first.empty()) first = state;
        EXPECT_TRUE(state == first) << threads << " threads";
    }
    set_thread_count(0);
}

}  // namespace
}  // namespace thixo
