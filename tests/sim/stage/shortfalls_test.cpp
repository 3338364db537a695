// What steps could not do is counted where it happens, and what can be known is known before.
#include "sim/stage/shortfalls.h"

#include <gtest/gtest.h>

#include "pipeline/contract/scene_io.h"
#include "sim/loop/solid_steps.h"
#include "sim/stage/estimate.h"
#include "sim/stage/frame_output.h"
#include "tests/sim/fixture.h"

namespace thixo {
namespace {

const Shortfall* find(const std::vector<Shortfall>& list, Lack lack) {
    const auto at = std::ranges::find(list, lack, &Shortfall::lack);
    return at == list.end() ? nullptr : &*at;
}

Simulation simulation_of(const std::string& blocks) {
    return make_simulation(scene::parse_scene(
        "frames: {first: 0, last: 8, fps: 32}\nsurface: {enabled: false}\n" + blocks, "shortfalls.yaml"));
}

Simulation after(const std::string& blocks, int frames) {
    Simulation s = simulation_of(blocks);
    for (int k = 0; k < frames; ++k) advance_frame(s);
    return s;
}

const std::string kTap =
    "materials: {water: {viscosity: 0.01}}\nsolver: {spacing: 0.015}\nemitters: {tap: {material: "
    "water, radius: 0.03, speed: 1}}\n";
const std::string kBlock = "world: {boundaries: {block: {shape: {box: {size: [0.2, 0.2, 0.2]}}}}}\n";

TEST(Shortfalls, OfARunThatDoesAllIsNothing) {
    // A pool at rest, a jet into free space, and rubber on the floor, each for two frames.
    const std::string pool =
                          "materials: {water: {}}\nworld: {boundaries: {tank: {inside: true, shape: {box: {}}}}}\n"
                          "bodies: {pool: {material: water, shape: {box: {size: [1, 1, 0.5]}, translate: [0, 0, "
                          "-0.25]}}}\nsolver: {spacing: 0.1}\n",
                      rubber =
                          "materials: {rubber: {youngs_modulus: 1.0e5}}\nsolver: {spacing: 0.1}\nworld: "
                          "{boundaries: {floor: {shape: {plane: {offset: -0.5}}}}}\n"
                          "bodies: {cube: {material: rubber, shape: {box: {}}}}\n";
    for (const std::string& blocks : {pool, rubber, kTap}) {
        EXPECT_TRUE(find_shortfalls(after(blocks, 2)).empty()) << blocks;
        EXPECT_TRUE(expect_shortfalls(simulation_of(blocks)).empty()) << blocks;
    }
}

TEST(Estimate, CountsTheSurfelsOfLongThinBodiesToo) {
    // Surfels lie surface.radius spacings apart. The area of the sides is known.
    for (const double length : {0.1, 2.0, 10.0}) {
        const scene::Scene s = scene::parse_scene(
            fmt::format("materials: {{m: {{youngs_modulus: 1.0e5}}}}\nsolver: {{spacing: 0.02}}\nbodies: {{bar: {{"
                        "material: m, shape: {{box: {{size: [{}, 0.1, 0.1]}}}}}}}}\n",
                        length),
            "bar.yaml");
        const double expected = (4 * 0.1 * length + 2 * 0.01) / square(s.surface.radius * s.solver.spacing);
        EXPECT_NEAR(estimate_run(s).size.surfels / expected, 1, 0.25) << length << " m";  // as estimate.h promises
    }
}

TEST(Shortfalls, NameAnEmitterInsideAnObstacleBeforeAndAfter) {
    for (const auto& list :
         {find_shortfalls(after(kTap + kBlock, 4)), expect_shortfalls(simulation_of(kTap + kBlock))}) {
        const Shortfall* blocked = find(list, Lack::blocked);
        ASSERT_NE(blocked, nullptr);
        EXPECT_EQ(blocked->name, "tap");
        EXPECT_GT(blocked->of, 0);
        EXPECT_EQ(blocked->count, blocked->of);
    }
}

TEST(Shortfalls, KnowThatHalfAnEmitterIsInAnObstacle) {
    // Its centre lies on a face. A site of the packing is 1.1 spacings wide, the disc 4: a quarter more or less.
    const Simulation s = simulation_of(kTap +
                                       "world: {boundaries: {block: {shape: {box: {size: [0.2, 1, 1]}, "
                                       "translate: [0.1, 0, 0]}}}}\n");
    const std::vector<Shortfall> list = expect_shortfalls(s);
    const Shortfall* blocked = find(list, Lack::blocked);
    ASSERT_NE(blocked, nullptr);
    EXPECT_NEAR(static_cast<double>(blocked->count) / static_cast<double>(blocked->of), 0.5, 0.25);
}

TEST(Shortfalls, AnEmitterFlushWithAWallIsNotBlocked) {
    const Simulation s = simulation_of(kTap + "world: {boundaries: {floor: {shape: {plane: {normal: [0, 0, -1]}}}}}\n");
    EXPECT_EQ(find(expect_shortfalls(s), Lack::blocked), nullptr);
}

const std::string kDrop =
    "materials: {water: {viscosity: 0.01}}\nworld: {boundaries: {floor: {shape: {plane: {offset: "
    "-0.1}}}}}\nbodies: {drop: {material: water, shape: {sphere: {radius: 0.05}}}}\n";

TEST(Shortfalls, TellAFixedStepAboveTheLimitBeforeAndAfter) {
    for (const char* fixed : {"0.02", "0.01", "0.005"}) {
        const std::string blocks = kDrop + "solver: {spacing: 0.015, time_step: {fixed: " + fixed + "}}\n";
        const Simulation start = simulation_of(blocks);
        const std::vector<Shortfall> before = expect_shortfalls(start);
        ASSERT_NE(find(before, Lack::long_step), nullptr) << fixed;
        // cfl h/c, of matter at rest
        const double limit = 0.4 * 0.03 / static_cast<double>(start.problem.materials[0].sound_speed);
        EXPECT_NEAR(find(before, Lack::long_step)->worst, std::stod(fixed) / limit, 1e-4 * std::stod(fixed) / limit);
        Simulation s = simulation_of(blocks);
        s.clock.next_frame = 1;
        step(s);
        const std::vector<Shortfall> list = find_shortfalls(s);
        ASSERT_NE(find(list, Lack::long_step), nullptr) << fixed;
        EXPECT_EQ(find(list, Lack::long_step)->name, "signal");
        EXPECT_GE(find(list, Lack::long_step)->worst, 0.999 * find(before, Lack::long_step)->worst);
    }
}

TEST(Shortfalls, AFixedStepBelowTheLimitIsNone) {
    const Simulation s = after(kDrop + "solver: {spacing: 0.015, time_step: {fixed: 0.0001}}\n", 1);
    EXPECT_EQ(find(find_shortfalls(s), Lack::long_step), nullptr);
    EXPECT_TRUE(expect_shortfalls(s).empty());
}

/// A drop of this material that is thrown at 10 m/s at a plate, from 3 cm above it.
Simulation thrown(double thickness, const std::string& material, const std::string& step) {
    return after(
        fmt::format(
            "materials: {{water: {}}}\nworld: {{gravity: [0, 0, 0], boundaries: {{plate: {{shape: {{box: "
            "{{size: [1, 1, {}]}}}}}}}}}}\nbodies: {{drop: {{material: water, shape: {{sphere: {{radius: 0.03}}, "
            "translate: [0, 0, {}]}}, velocity: [0, 0, -10]}}}}\nsolver: {{spacing: 0.01, time_step: "
            "{{{}}}}}\n",
            material, thickness, thickness / 2 + 0.06, step),
        1);
}

TEST(Shortfalls, CountWhatALongStepCarriesThroughAWall) {
    const std::vector<Shortfall> list = find_shortfalls(thrown(0.02, "{stiffness: 1}", "fixed: 0.005"));
    ASSERT_NE(find(list, Lack::passed), nullptr);
    EXPECT_GT(find(list, Lack::passed)->count, 10);  // of 113 or so
}

TEST(Shortfalls, NothingGoesThroughAWallWhereTheStepIsTheStatesOwn) {
    for (const double thickness : {0.02, 0.04, 0.5}) {
        const Simulation s = thrown(thickness, "{}", "cfl: 0.4");
        const std::vector<Shortfall> list = find_shortfalls(s);
        EXPECT_EQ(find(list, Lack::passed), nullptr) << thickness;
        EXPECT_EQ(find(list, Lack::inside), nullptr) << thickness;
        for (const Vec3& x : s.particles.position) EXPECT_GT(x.z(), 0) << thickness;
    }
}

TEST(Shortfalls, CountWhatIsInsideWalls) {
    Simulation s = simulation_of(kDrop + "solver: {spacing: 0.015}\n");
    evaluate(s);
    EXPECT_EQ(find(find_shortfalls(s), Lack::inside), nullptr);
    for (std::size_t i = 0; i < 3; ++i) s.particles.position[i].z() = Real(-0.12);  // the floor stands at -0.1
    const std::vector<Shortfall> list = find_shortfalls(s);
    ASSERT_NE(find(list, Lack::inside), nullptr);
    EXPECT_EQ(find(list, Lack::inside)->count, 3);
}

TEST(Shortfalls, CountCrushedAndInvertedParticlesOfSolids) {
    for (const Real squeeze : {Real(0.6), Real(1.4)}) {  // to 0.4 of its height; to -0.4: inside out
        Simulation s = simulation_of(
            "materials: {jelly: {youngs_modulus: 1.0e4}}\nsolver: {spacing: 0.1}\nworld: {gravity: [0, 0, 0]}\n"
            "bodies: {whole: {material: jelly, shape: {box: {}}}, cube: {material: jelly, shape: {box: {}, translate: "
            "[2, 0, 0]}}}\n");
        for (const Index e : s.solids.bodies[1].elements)
            s.solids.elements.displacement[e].z = -squeeze * s.solids.elements.rest[e].z;
        evaluate(s);
        write_particles(s.solids, s.particles);
        const std::vector<Shortfall> list = find_shortfalls(s);
        ASSERT_EQ(list.size(), 1u) << squeeze;
        EXPECT_EQ(list[0].lack, Lack::crushed);
        EXPECT_EQ(list[0].name, "cube");
        EXPECT_EQ(list[0].count, static_cast<std::int64_t>(s.solids.bodies[1].size()));
        EXPECT_EQ(list[0].of, list[0].count);
    }
}

TEST(Shortfalls, CountSolvesThatWereCutOff) {
    const std::string tank =
        "materials: {water: {}}\nworld: {boundaries: {tank: {inside: true, shape: {box: {}}}}}\n"
        "bodies: {drop: {material: water, shape: {sphere: {radius: 0.3}, translate: [0, 0, "
        "-0.15]}, velocity: [0, 0, -5]}}\n";
    const Simulation s =
        after(tank + "solver: {spacing: 0.05, pressure: dfsph, iterations: 1, density_tolerance: 1.0e-6}\n", 2);
    const std::vector<Shortfall> list = find_shortfalls(s);
    ASSERT_NE(find(list, Lack::cut_off), nullptr);
    EXPECT_GT(find(list, Lack::cut_off)->count, 0);
    EXPECT_EQ(find(list, Lack::cut_off)->of, s.stats.density.solves);
}

TEST(Shortfalls, StandInTheFrameThatShowsThem) {
    EXPECT_EQ(make_frame(after(kTap + kBlock, 2), {}).shortfalls, find_shortfalls(after(kTap + kBlock, 2)));
}

}  // namespace
}  // namespace thixo
