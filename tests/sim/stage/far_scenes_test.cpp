// Scenes far from the world's origin: the same as near it, but for rounding.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "pipeline/contract/scene_io.h"
#include "pipeline/contract/scene_origin.h"
#include "sim/space/scene_shapes.h"
#include "sim/stage/frame_output.h"
#include "sim/stage/probes.h"
#include "tests/sim/fixture.h"

namespace thixo {
namespace {

std::string place(const Vec3d& x) { return fmt::format("[{}, {}, {}]", x.x(), x.y(), x.z()); }

/// A jelly cube of 8 cm that rests in water of its own density, `away` [m] from the origin.
scene::Scene jelly_at(const Vec3d& away) {
    return scene::parse_scene(
        fmt::format("frames: {{first: 1, last: 2, fps: 1}}\n"
                    "world: {{boundaries: {{tank: {{inside: true, shape: {{box: {{size: [0.2, 0.2, 0.3]}}, translate: "
                    "{}}}}}}}}}\n"
                    "materials: {{water: {{viscosity: 0.1}}, jelly: {{youngs_modulus: 1e4, viscosity: 1}}}}\n"
                    "bodies:\n"
                    "  cube: {{material: jelly, shape: {{box: {{size: [0.08, 0.08, 0.08]}}, translate: {}}}}}\n"
                    "  pool: {{material: water, shape: {{box: {{size: [0.2, 0.2, 0.2]}}, translate: {}}}}}\n"
                    "solver: {{spacing: 0.02}}\nsurface: {{enabled: false}}\n",
                    place(away + Vec3d(0, 0, 0.15)), place(away + Vec3d(0, 0, 0.1)), place(away + Vec3d(0, 0, 0.1))),
        "jelly.yaml");
}

/// Places in the world, less `away`, by id.
std::map<std::int64_t, Vec3d> places_after_a_second(const Vec3d& away) {
    Simulation sim = make_simulation(jelly_at(away));
    evaluate(sim);
    EXPECT_TRUE(advance_frame(sim));
    EXPECT_EQ(sim.clock.time, 1);
    std::map<std::int64_t, Vec3d> places;
    for (std::size_t i = 0; i < sim.particles.size(); ++i)
        places[sim.particles.id[i]] = sim.particles.position[i].cast<double>() + (sim.problem.scene.origin - away);
    return places;
}

/// The largest distance of the same particle [m].
double farthest_apart(const std::map<std::int64_t, Vec3d>& a, const std::map<std::int64_t, Vec3d>& b) {
    EXPECT_EQ(a.size(), b.size());
    double worst = 0;
    for (const auto& [id, x] : a) worst = std::max(worst, (b.at(id) - x).norm());
    return worst;
}

TEST(FarScenes, AJellyCubeAtRestInWaterIsTheSameAtAnyDistance) {
    const auto near = places_after_a_second({0, 0, 0});
    for (const Vec3d& away : {Vec3d(1e3, 0, 0), Vec3d(-1e4, 1e4, 0), Vec3d(1e6, -1e6, 1e6)}) {
        const double worst = farthest_apart(near, places_after_a_second(away));
        EXPECT_LT(worst, 0.01 * 0.02) << place(away);  // the need: a hundredth of a spacing
        RecordProperty(fmt::format("worst_{:.0f}", away.norm()), fmt::format("{:.3g}", worst / 0.02));
    }
}

TEST(FarScenes, FramesFollowFromThePlaceRelativeToTheOriginAlone) {
    // Two scenes that stand alike about their origins, of which one is the world's.
    const Vec3d away(12345.678, 0.4, -9e5), origin = near_origin(jelly_at(away)).origin;
    EXPECT_EQ(origin, Vec3d(12350, 0, -9e5));
    EXPECT_TRUE(near_origin(jelly_at(away - origin)).origin.isZero());
    EXPECT_LT(farthest_apart(places_after_a_second(away - origin), places_after_a_second(away)), 0.01 * 0.02);
}

/// A body of every kind of shape, and of combinations whose parts stand far off themselves.
const std::map<std::string, std::string> kShapes{
    {"sphere", "{{sphere: {{radius: 0.1}}, translate: {0}}}"},
    {"turned box", "{{box: {{size: [0.1, 0.2, 0.3]}}, rotate: [20, 30, 40], scale: 2, translate: {0}}}"},
    {"torus", "{{torus: {{radius: 0.2, tube: 0.05}}, translate: {0}, offset: 0.01}}"},
    {"capsule", "{{capsule: {{from: {0}, to: {1}, radius: 0.1}}}}"},
    {"sweep", "{{sweep: {{points: [{{at: {0}, radius: 0.1}}, {{at: {1}, radius: 0.05}}]}}}}"},
    {"turned sweep",
     "{{sweep: {{points: [{{at: [0, 0, 0], radius: 0.1}}, {{at: [0.2, 0, 0], radius: 0.05}}]}}, rotate: [0, 0, 70], "
     "translate: {0}}}"},
    {"union",
     "{{union: {{shapes: [{{sphere: {{radius: 0.1}}, translate: {0}}}, {{box: {{size: [0.1, 0.1, 0.1]}}, translate: "
     "{1}}}]}}}}"},
    {"shell of a difference",
     "{{difference: {{shapes: [{{sphere: {{radius: 0.2}}, translate: {0}}}, {{plane: {{normal: [1, 1, 0]}}, translate: "
     "{0}}}]}}, shell: 0.05}}"},
    {"intersection with a plane",
     "{{intersection: {{shapes: [{{sphere: {{radius: 0.2}}, translate: {1}}}, {{plane: {{normal: [0, 1, 2]}}, rotate: "
     "[0, "
     "0, 90], translate: {1}}}]}}}}"},
    {"mirror", "{{mirror: {{shapes: [{{sphere: {{radius: 0.1}}, translate: [0.2, 0, 0]}}]}}, translate: {0}}}"},
    {"row", "{{repeat: {{shapes: [{{sphere: {{radius: 0.1}}, translate: {0}}}], count: 3, step: [0.1, 0.2, 0]}}}}"},
    {"ring",
     "{{repeat: {{shapes: [{{sphere: {{radius: 0.1}}, translate: [0.3, 0, 0]}}], count: 3, turn: 120}}, translate: "
     "{0}}}"},
    {"noise", "{{noise: {{shapes: [{{sphere: {{radius: 0.2}}}}], amplitude: 0.02, scale: 0.1}}, translate: {0}}}"},
    {"named", "{{named: blob}}"},
    {"turned named", "{{named: pin, rotate: [0, 0, 30], translate: {0}}}"},
};

scene::Scene shape_at(const std::string& shape, const Vec3d& away) {
    const std::string a = place(away), b = place(away + Vec3d(0.1, 0.05, 0.02));
    return scene::parse_scene(
        fmt::format(
            "shapes: {{blob: {{sphere: {{radius: 0.2}}, translate: {}}}, pin: {{capsule: {{from: [0, 0, 0], to: "
            "[0.1, 0, 0], radius: 0.05}}}}}}\nmaterials: {{m: {{}}}}\nbodies: {{b: {{material: m, shape: {}}}}}\n"
            "solver: {{spacing: 0.02}}\n",
            a, fmt::format(fmt::runtime(shape), a, b)),
        "shape.yaml");
}

TEST(FarScenes, ShapesOfEveryKindKeepTheirForm) {
    const Vec3d away(3e5, -4e6, 1e4);
    for (const auto& [name, text] : kShapes) {
        const scene::Scene near = shape_at(text, {0, 0, 0}), far = near_origin(shape_at(text, away));
        const Shape a = make_shape(near, near.bodies[0].shape), b = make_shape(far, far.bodies[0].shape);
        EXPECT_EQ(far.origin, away) << name;
        for (int k = 0; k < 200; ++k) {
            const Vec3d x = 0.4 * Vec3d(std::sin(k * 1.1), std::sin(k * 2.3 + 1), std::cos(k * 3.7));
            // Rounding of a world's place in double is 5e-10 m here, of a float of this size 3e-8 m.
            ASSERT_NEAR(a.distance(x.cast<Real>()), b.distance((x + away - far.origin).cast<Real>()), 1e-6) << name;
        }
    }
}

TEST(FarScenes, WhatIsNearAlreadyStaysWhereItIs) {
    for (const Vec3d& away : {Vec3d(0, 0, 0), Vec3d(20, 0, 0), Vec3d(5e3, -7e3, 1)}) {
        const scene::Scene once = near_origin(jelly_at(away)), twice = near_origin(once);
        EXPECT_EQ(once.origin, twice.origin);
        EXPECT_EQ(scene::print_scene(once), scene::print_scene(twice));
    }
    EXPECT_TRUE(near_origin(jelly_at({20, 0, 0})).origin.isZero());  // 1000 spacings
    EXPECT_EQ(near_origin(jelly_at({5e3, -7e3, 1})).origin, Vec3d(5e3, -7e3, 0));
}

TEST(FarScenes, LargeMatterThatReachesTheOriginStaysWhereItIs) {
    scene::Scene scene = jelly_at({0, 0, 0});
    scene.bodies[0].shape = fixture::shape_at({50, 0, 0}, scene::BoxShape{{100, 1, 1}, 0});
    EXPECT_TRUE(near_origin(scene).origin.isZero());
}

TEST(FarScenes, MotionsTurnAboutTheWorldsOrigin) {
    scene::Scene scene = jelly_at({0, 0, 0});
    const std::vector<scene::Key> keys{
        {0, {0, 0, 0}, {0, 0, 0}}, {1, {1, 2, 3}, {0, 0, 40}}, {2, {2, 2, 2}, {10, 0, 80}}};
    const RigidMotion world = motion_of(scene, keys);
    scene.origin = {1e4, -2e4, 50};
    const RigidMotion local = motion_of(scene, keys);
    const Vec3d x(1e4 + 0.3, -2e4, 51);
    for (const double t : {0.0, 0.3, 1.0, 1.7, 2.0, 3.0}) {
        EXPECT_LT((local.pose(t).apply(x - scene.origin) - (world.pose(t).apply(x) - scene.origin)).norm(), 1e-9) << t;
        const auto velocity = [&](const RigidMotion& m, const Vec3d& at) {
            return Vec3d(m.velocity(t).linear + m.velocity(t).angular.cross(at - m.pose(t).translation));
        };
        const Vec3d at = world.pose(t).apply(x);
        EXPECT_LT((velocity(local, at - scene.origin) - velocity(world, at)).norm(), 1e-7) << t;
    }
}

/// Water of 6 cm on a side that flies, and what is measured of it.
Simulation flying_at(const Vec3d& away) {
    scene::Scene scene = fixture::empty_space();
    scene.world.gravity = {0, 0, -10};
    scene.bodies = {
        fixture::body("cube", fixture::shape_at(away, scene::BoxShape{{0.06, 0.06, 0.06}, 0}), {0.5, 0, 0})};
    Simulation sim = make_simulation(scene);
    evaluate(sim);
    return sim;
}

TEST(FarScenes, ProbesAndTotalsAreThoseOfTheWorld) {
    const Vec3d away(2e5, 300, -5e4);
    Simulation sim = flying_at(away);
    EXPECT_EQ(sim.problem.scene.origin, away);
    scene::Probe mean, extent;
    mean.quantity = scene::Quantity::z;
    extent.measure = scene::Measure::extent;
    extent.direction = {2, 0, 0};
    sim.problem.scene.probes = {mean, extent};
    sim.probes = make_probes(sim.problem.scene, sim.particles);
    const auto values = measure(sim);
    EXPECT_NEAR(*values[0], -5e4, 1e-6);
    EXPECT_NEAR(*values[1], 2e5 + 0.025, 0.01);  // the outermost centres stand half a spacing within the face
    const FrameTotals t = make_frame(sim, {}).totals;
    EXPECT_NEAR(t.potential_energy, t.mass * 10 * -5e4, 1e-6 * t.mass * 10 * 5e4);
    EXPECT_NEAR(t.angular_momentum[1], t.mass * 0.5 * -5e4, 1e-6 * t.mass * 5e4);
    EXPECT_NEAR(t.angular_momentum[2], t.mass * 0.5 * -300, 1e-6 * t.mass * 300);
}

TEST(FarScenes, ObstaclesAndPointsOfAFrameStandInTheWorld) {
    const Vec3d away(1e4, 0, 700);
    Simulation sim = flying_at(away);
    const Frame frame = make_frame(sim, {{"wall", "wall", "", motion_of(sim.problem.scene, {})}});
    EXPECT_EQ(frame.particles.origin, away);
    for (const int k : {0, 1, 2}) EXPECT_EQ(frame.obstacles[0].transform[static_cast<std::size_t>(4 * k + 3)], away[k]);
    for (const Vec3f& x : frame.particles.get<Vec3f>("P")) EXPECT_LT(x.cwiseAbs().maxCoeff(), 0.03f);
}

TEST(FarScenes, MessagesNamePlacesOfTheWorld) {
    scene::Scene scene = jelly_at({0, 0, 0});
    EXPECT_EQ(place_text(scene, {Real(0.25), 1, Real(-1.0 / 3)}), "(0.25, 1, -0.3333)");
    scene.origin = {1e6, 0, -2e4};
    EXPECT_EQ(place_text(scene, {Real(0.25), 1, 0}), "(1000000.25, 1, -20000)");
}

}  // namespace
}  // namespace thixo
