// Emitters where people put them: flush with walls, on floors, below the surface, in pipes and in obstacles.
#include <gtest/gtest.h>

#include "pipeline/base/error.h"
#include "pipeline/contract/scene_io.h"
#include "pipeline/geometry/packing.h"
#include "sim/loop/step.h"
#include "sim/stage/setup.h"

namespace thixo {
namespace {

constexpr double kRadius = 0.03, kSpeed = 1, kSpacing = 0.015, kSeconds = 0.25;

/// A scene of an emitter `tap`: radius 0.03 m, 1 m/s, spacing 0.015 m.
Simulation prepared(const std::string& place, const std::string& blocks, const std::string& pressure = "eos",
                    const std::string& viscosity = "0.01") {
    return make_simulation(scene::parse_scene(
        "frames: {first: 0, last: 8, fps: 32}\nmaterials: {water: {viscosity: " + viscosity +
            "}}\nsurface: {enabled: false}\n"
            "solver: {spacing: 0.015, pressure: " +
            pressure + "}\nemitters: {tap: {material: water, radius: 0.03, speed: 1, " + place + "}}\n" + blocks,
        "emitter.yaml"));
}

/// Runs it for 0.25 s.
Simulation run(const std::string& place, const std::string& blocks) {
    Simulation s = prepared(place, blocks);
    for (int frame = 0; frame < 8; ++frame) advance_frame(s);
    return s;
}

std::size_t emitted(const Simulation& s) {
    const int tap = static_cast<int>(s.problem.scene.bodies.size());
    return static_cast<std::size_t>(std::ranges::count(s.particles.body, tap));
}

/// The rate is density area speed, in whole layers. What holds it up, in layers of the packing:
/// - a layer is whole: one more or less at either end;
/// - layers leave at steps, and no step is longer than half a layer takes;
/// - room is made once: fluid at the opening has to go 0.8 spacings before the first layer fits. From then on there is
///   room for every layer, for the fluid flows as fast as they come.
/// So all that is missing after a time is missing after half of it, too: the second half has the full rate.
void expect_full_rate(Simulation s) {
    const double sites = kPi * square(kRadius) * static_cast<double>(packing_layer(Real(kSpacing))) / cube(kSpacing);
    const double rate = kPi * square(kRadius) * kSpeed / cube(kSpacing) / sites;  // layers a second
    const double room = 0.8 * kSpacing / static_cast<double>(packing_layer(Real(kSpacing)));
    constexpr double kWhole = 1, kStep = 0.5;
    const auto layers = [&] { return static_cast<double>(emitted(s)) / sites; };
    for (int frame = 0; frame < 4; ++frame) advance_frame(s);
    const double half = layers();
    for (int frame = 0; frame < 4; ++frame) advance_frame(s);
    EXPECT_NEAR(layers() - half, rate * kSeconds / 2, kWhole + kStep);
    EXPECT_LE(layers(), rate * kSeconds + kWhole);
    EXPECT_GE(layers(), rate * kSeconds - kWhole - kStep - room);
    EXPECT_EQ(s.emitters[0].blocked, 0);
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        ASSERT_TRUE(s.particles.position[i].allFinite());
        ASSERT_LT(s.particles.velocity[i].norm(), 10 * kSpeed);  // nothing is shot off
    }
}

const std::string kTank = "world: {boundaries: {tank: {inside: true, shape: {box: {size: [0.3, 0.3, 0.3]}}}}}\n";
const std::string kPool = kTank +
                          "bodies: {pool: {material: water, shape: {box: {size: [0.3, 0.3, 0.15]}, "
                          "translate: [0, 0, -0.075]}}}\n";

TEST(AnEmitter, FlushWithAWallEmitsItsFullRate) {
    expect_full_rate(prepared("position: [-0.15, 0, 0], direction: [1, 0, 0]", kTank));
}

TEST(AnEmitter, OnAFloorIsAFountain) {
    expect_full_rate(prepared("position: [0, 0, 0], direction: [0, 0, 1]",
                              "world: {boundaries: {floor: {shape: {plane: {offset: 0}}}}}\n"));
}

TEST(AnEmitter, BelowTheSurfaceEmitsItsFullRate) {
    expect_full_rate(prepared("position: [-0.05, 0, -0.08], direction: [1, 0, 0]", kPool));
}

TEST(AnEmitter, AtTheBottomOfAPoolEmitsItsFullRate) {
    expect_full_rate(prepared("position: [0, 0, -0.15], direction: [0, 0, 1]", kPool));
}

TEST(AnEmitter, AsWideAsAPipeEmitsItsFullRate) {
    expect_full_rate(prepared(
        "position: [0, 0, 0.05]",
        "world: {gravity: [0, 0, 0], boundaries: {pipe: {shape: {difference: {shapes: [{cylinder: {radius: 0.05, "
        "height: 0.4}}, {cylinder: {radius: 0.03, height: 0.5}}]}}}}}\n"));
}

TEST(AnEmitter, OfAnIncompressibleLiquidEmitsItsFullRateToo) {
    expect_full_rate(prepared("position: [-0.15, 0, 0], direction: [1, 0, 0]", kTank, "dfsph"));
    expect_full_rate(prepared("position: [-0.05, 0, -0.08], direction: [1, 0, 0]", kPool, "dfsph"));
    // What lies beside an opening on the floor would flow in before the next layer comes, however thick it is.
    for (const char* viscosity : {"0.001", "0.0099", "0.01", "0.03"})
        expect_full_rate(prepared("position: [0, 0, -0.15], direction: [0, 0, 1]", kPool, "dfsph", viscosity));
}

TEST(AnEmitter, InsideAnObstacleIsBlockedAndSaysSo) {
    const Simulation s =
        run("position: [0, 0, 0]", "world: {boundaries: {block: {shape: {box: {size: [0.2, 0.2, 0.2]}}}}}\n");
    EXPECT_EQ(emitted(s), 0u);
    EXPECT_GT(s.emitters[0].due, 100);
    EXPECT_EQ(s.emitters[0].blocked, s.emitters[0].due);
}

TEST(AnEmitter, HalfInAnObstacleEmitsTheOtherHalf) {
    const Simulation s = run("position: [0.1, 0, 0]",
                             "world: {gravity: [0, 0, 0], boundaries: {block: {shape: {box: {size: [0.2, 1, 1]}}}}}\n");
    EXPECT_NEAR(static_cast<double>(s.emitters[0].blocked) / static_cast<double>(s.emitters[0].due), 0.5, 0.2);
    EXPECT_EQ(static_cast<std::int64_t>(emitted(s)), s.emitters[0].due - s.emitters[0].blocked);
}

/// Runs a source in empty space for 0.25 s.
Simulation run_source(const std::string& source, const std::string& world = "{}") {
    Simulation s = make_simulation(scene::parse_scene(
        "frames: {first: 0, last: 8, fps: 32}\nmaterials: {water: {viscosity: 0.01}}\nsurface: {enabled: false}\n"
        "solver: {spacing: 0.015}\nworld: " +
            world + "\nemitters: {spring: {material: water, position: [0, 0, 1], " + source + "}}\n",
        "source.yaml"));
    for (int frame = 0; frame < 8; ++frame) advance_frame(s);
    return s;
}
const std::string kBall = "shape: {sphere: {radius: 0.06}, translate: [0, 0, 1]}";

TEST(ASource, ThatIsAVolumeFillsByItsRate) {
    // Single particles at equal intervals: the count is exact to one. They fall out of the ball as they come.
    const double rate = 0.0005;
    const Simulation s = run_source("source: volume, rate: 0.0005, " + kBall);
    EXPECT_NEAR(static_cast<double>(s.particles.size()), rate * kSeconds / cube(kSpacing), 1.5);
    EXPECT_EQ(s.emitters[0].blocked, 0);
}

TEST(ASource, ThatIsAVolumeStartsWithItsSpeed) {
    const Simulation s =
        run_source("source: volume, rate: 0.0001, speed: 2, direction: [1, 0, 0], " + kBall, "{gravity: [0, 0, 0]}");
    EXPECT_NEAR(static_cast<double>(s.particles.size()), 0.0001 * kSeconds / cube(kSpacing), 1.5);
    double along = 0;
    for (const Vec3& v : s.particles.velocity) along += static_cast<double>(v.x());
    EXPECT_NEAR(along / static_cast<double>(s.particles.size()), 2, 0.02);  // pressure between them adds up to nothing
}

TEST(ASource, ThatIsFullWaitsAndSaysWhatIsBlocked) {
    // Some 430 particles have room in the cavity, and 740 are due.
    const Simulation s = run_source(
        "source: volume, rate: 0.01, " + kBall,
        "{gravity: [0, 0, 0], boundaries: {cavity: {inside: true, shape: {sphere: {radius: 0.07}, translate: "
        "[0, 0, 1]}}}}");
    EXPECT_LT(s.particles.size(), 550u);
    EXPECT_GT(s.emitters[0].blocked, 0);
    EXPECT_EQ(s.emitters[0].due - s.emitters[0].blocked, static_cast<std::int64_t>(s.particles.size()));
}

/// Matter that leaves a ball of 0.06 m flies along the radius; its rate is that of the area.
void expect_radial(const Simulation& s, double speed) {
    const double due = 4 * kPi * square(0.06) * speed * kSeconds / cube(kSpacing);
    // The area of the samples is good to about a percent.
    EXPECT_NEAR(static_cast<double>(s.particles.size()), due, 0.02 * due + 1);
    EXPECT_EQ(s.emitters[0].blocked, 0);
    Vec3d momentum(0, 0, 0);
    double radial = 0, all = 0;
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        const Vec3d v = s.particles.velocity[i].cast<double>(),
                    out = s.particles.position[i].cast<double>() - Vec3d(0, 0, 1);
        EXPECT_GT(out.norm(), 0.06);
        radial += v.dot(out.normalized());
        all += v.norm();
        momentum += v;
    }
    EXPECT_GT(radial, 0.95 * all);
    EXPECT_LT(momentum.norm(), 0.05 * all);  // to all sides alike
}

TEST(ASource, ThatIsACurvedFaceFlowsAlongItsNormals) {
    expect_radial(run_source("source: surface, speed: 0.5, " + kBall, "{gravity: [0, 0, 0]}"), 0.5);
}

TEST(ASource, ThatIsTheFaceOfAnObstacleEmitsItsFullRate) {
    expect_radial(run_source("source: surface, speed: 0.5, " + kBall,
                             "{gravity: [0, 0, 0], boundaries: {ball: {" + kBall + "}}}"),
                  0.5);
}

TEST(ASource, ThatIsASurfaceTakesARate) {
    const double rate = 4 * kPi * square(0.06) * 0.5;
    expect_radial(run_source("source: surface, rate: " + std::to_string(rate) + ", " + kBall, "{gravity: [0, 0, 0]}"),
                  0.5);
}

TEST(ASource, InsideAnObstacleIsBlockedAndSaysSo) {
    const Simulation s = run_source("source: volume, rate: 0.0005, " + kBall,
                                    "{boundaries: {rock: {shape: {sphere: {radius: 0.2}, translate: [0, 0, 1]}}}}");
    EXPECT_EQ(s.particles.size(), 0u);
    EXPECT_GT(s.emitters[0].blocked, 0);
    const OpeningRoom room = room_at_opening(sources_of(s), 0, 0);
    EXPECT_GT(room.sites, 0);
    EXPECT_EQ(room.sites, room.blocked);
}

TEST(ASource, ThatCannotBeIsRefused) {
    EXPECT_THROW(run_source("source: volume, speed: 1, " + kBall), InputError);  // no rate
    EXPECT_THROW(run_source("source: surface, speed: 1"), InputError);           // no shape
    EXPECT_THROW(run_source("source: volume, rate: 1, shape: {sphere: {radius: 0.001}}"), InputError);
}

}  // namespace
}  // namespace thixo
