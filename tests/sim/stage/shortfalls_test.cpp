// What steps could not do is counted where it happens, and what can be known is known before.
#include "sim/stage/shortfalls.h"

#include <gtest/gtest.h>

#include <chrono>

#include "pipeline/base/error.h"
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

/// What estimate_run says of a scene that it refuses.
std::string refusal_of(const std::string& blocks) {
    try {
        estimate_run(
            scene::parse_scene("frames: {first: 0, last: 1}\nsolver: {spacing: 0.01}\n" + blocks, "late.yaml"));
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

TEST(Estimate, RefusesAtItsPlaceWhatTheSimulationWouldRefuse) {
    const std::string sheet = "{box: {size: [0.2, 0.2, 0.00001]}}",
                      nothing =
                          "{intersection: {shapes: [{sphere: {radius: 0.2}}, {sphere: {radius: 0.2}, translate: [1, "
                          "0, 0]}]}}",
                      vast = "{union: {shapes: [{box: {size: [100, 100, 0.00001]}}, {sphere: {radius: 0.02}}]}}",
                      solid = "materials: {m: {youngs_modulus: 1.0e4}}\n",
                      ball = "bodies: {b: {material: m, shape: {sphere: {radius: 0.05}}}}\n";
    struct Case {
        std::string blocks, place, said;
    };
    const Case cases[] = {
        {solid + "bodies: {b: {material: m, shape: " + sheet + "}}\n", "late.yaml:4:", "body 'b': most of the shape"},
        {solid + "bodies: {b: {material: m, surfels: 2000, shape: " + sheet + "}}\n", "late.yaml:4:", "body 'b': most"},
        {"surface: {enabled: false}\n" + solid + "bodies: {b: {material: m, shape: " + sheet +
             "}, c: {material: m, shape: {sphere: {radius: 0.05}, translate: [0, 0, 1]}}}\n",
         "late.yaml:5:", "body 'b': most of the shape"},
        {solid + "bodies: {b: {material: m, shape: {box: {size: [100, 100, 100]}}}}\n", "late.yaml:4:", "too many"},
        {"materials: {m: {}}\nemitters: {e: {material: m, source: surface, shape: " + vast + "}}\n",
         "late.yaml:4:", "emitter 'e': tessellation cell"},
        {"materials: {m: {}}\nemitters: {e: {material: m, source: surface, shape: " + nothing + "}}\n",
         "late.yaml:4:", "emitter 'e': no surface found"},
        {"materials: {m: {}}\n" + ball + "world: {boundaries: {w: {shape: " + vast + "}}}\n",
         "late.yaml:5:", "boundary 'w' cannot be drawn: tessellation cell"},
        {"materials: {m: {}}\n" + ball + "world: {boundaries: {w: {shape: " + nothing + "}}}\n",
         "late.yaml:5:", "boundary 'w' cannot be drawn: no surface found"}};
    for (const Case& c : cases) {
        const auto start = std::chrono::steady_clock::now();
        const std::string said = refusal_of(c.blocks);
        const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
        EXPECT_TRUE(said.starts_with(c.place)) << said;
        EXPECT_NE(said.find(c.said), std::string::npos) << said;
        EXPECT_LT(took.count(), 3) << said;  // seconds, as for every scene
    }
    // What has no skin and meets no other body may be as thin.
    EXPECT_EQ(refusal_of("surface: {enabled: false}\n" + solid + "bodies: {b: {material: m, shape: " + sheet + "}}\n"),
              "");
    EXPECT_EQ(refusal_of(solid + "bodies: {b: {material: m, shape: {box: {size: [0.2, 0.2, 0.001]}}}}\n"), "");
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

TEST(Shortfalls, ARodOneParticleThickThatOnlyTurnsIsNotCrushed) {
    // Its particles have no neighbours across it.
    Simulation s = simulation_of(
        "materials: {jelly: {youngs_modulus: 1.0e4}}\nsolver: {spacing: 0.1}\nworld: {gravity: [0, 0, 0]}\n"
        "bodies: {rod: {material: jelly, shape: {capsule: {from: [0, 0, -1], to: [0, 0, 1], radius: 0.065}}}}\n");
    Elements& e = s.solids.elements;
    ASSERT_GT(e.bonds.flat.size(), e.size() / 2);
    const auto shorten_and_turn = [&](Real length, double degrees) {
        const Mat3 turn = Eigen::AngleAxis<Real>(static_cast<Real>(degrees * kPi / 180), Vec3::UnitY()).matrix();
        const Vec3 along(1, 1, length);
        for (Index i = 0; i < e.size(); ++i) {
            const Vec3 m = xyz(e.rest[i]);
            e.displacement[i] = quad(Vec3(turn * along.cwiseProduct(m) - m));
        }
        evaluate(s);
        write_particles(s.solids, s.particles);
    };
    for (const double degrees : {0.0, 50.0, 90.0, 150.0}) {
        shorten_and_turn(1, degrees);
        EXPECT_TRUE(find_shortfalls(s).empty()) << degrees;
        for (const Real density : s.particles.density) EXPECT_NEAR(density, 1000, 1) << degrees;
        shorten_and_turn(Real(0.4), degrees);
        const std::vector<Shortfall> list = find_shortfalls(s);
        ASSERT_NE(find(list, Lack::crushed), nullptr) << degrees;
        EXPECT_EQ(find(list, Lack::crushed)->count, static_cast<std::int64_t>(e.size())) << degrees;
    }
}

Simulation with_surface(const std::string& blocks, int frames) {
    Simulation s =
        make_simulation(scene::parse_scene("frames: {first: 0, last: 8, fps: 32}\n" + blocks, "shortfalls.yaml"));
    refresh_surface(s);
    evaluate(s);
    for (int k = 0; k < frames; ++k) advance_frame(s);
    return s;
}

TEST(Shortfalls, TellOfAFilmOnAWallThatIsInSingleParticles) {
    const std::string strewn =
        "materials: {water: {}}\nsolver: {spacing: 0.01}\n"
        "bodies: {drops: {material: water, shape: {repeat: {count: 24, step: [0.03, 0, 0], shapes: [{repeat: {count: "
        "24, "
        "step: [0, 0.03, 0], shapes: [{sphere: {radius: 0.006}, translate: [0, 0, 0.006]}]}}]}}}}\n";
    const Simulation film = with_surface(strewn + "world: {boundaries: {floor: {shape: {plane: {}}}}}\n", 0);
    const std::vector<Shortfall> list = find_shortfalls(film);
    ASSERT_NE(find(list, Lack::runaway), nullptr);
    EXPECT_EQ(find(list, Lack::runaway)->of, static_cast<std::int64_t>(film.particles.size()));
    // The same is a spray in the air.
    const Simulation spray =
        with_surface(strewn + "world: {boundaries: {floor: {shape: {plane: {offset: -0.1}}}}}\n", 0);
    EXPECT_EQ(find(find_shortfalls(spray), Lack::runaway), nullptr);
}

TEST(Shortfalls, ThinJetsAndBodiesOfManySurfelsThatMeltAreNoFilms) {
    const Simulation jet = with_surface(kTap + "world: {boundaries: {floor: {shape: {plane: {offset: -0.3}}}}}\n", 5);
    ASSERT_GT(jet.surface.size(), 10 * jet.particles.size());  // two or three particles wide
    EXPECT_EQ(find(find_shortfalls(jet), Lack::runaway), nullptr);
    Simulation cube = with_surface(
        "world: {boundaries: {plate: {shape: {plane: {}}, no_slip: true}}}\n"
        "materials: {wax: {youngs_modulus: 1.0e5, viscosity: 100, conductivity: 1, melting: {from: 50, to: 90, liquid: "
        "{viscosity: 100}}}}\nsolver: {spacing: 0.03, expected_speed: 2}\n"
        "bodies: {cube: {material: wax, surfels: 6000, shape: {box: {size: [0.15, 0.15, 0.15]}, translate: [0, 0, "
        "0.075]}}}\n",
        0);
    std::size_t melted = 0;
    for (std::size_t i = 0; i < cube.particles.size(); ++i)
        if (cube.particles.position[i].z() < Real(0.03)) {
            cube.particles.temperature[i] = 100;
            ++melted;
        }
    advance_frame(cube);
    ASSERT_GT(melted, 0u);
    ASSERT_GT(cube.mixed_surface.animated.size(), 10 * melted);
    EXPECT_EQ(find(find_shortfalls(cube), Lack::runaway), nullptr);
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
