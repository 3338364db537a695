// Solids and liquids together, and matter that is both. Momenta and heat are conserved, and each end of a material acts
// exactly as it does alone.
#include "sim/phase/phases.h"

#include <gtest/gtest.h>

#include <functional>
#include <map>

#include "sim/bonds/members.h"
#include "sim/bonds/weights.h"
#include "sim/loop/coupling.h"
#include "sim/stage/solid_setup.h"
#include "tests/sim/heat/heat_of.h"
#include "tests/sim/phase/wax.h"

namespace thixo {
namespace {

using namespace fixture::melting;

/// Position and velocity of every particle, by id.
std::map<std::int64_t, std::pair<Vec3, Vec3>> places(const Simulation& s) {
    std::map<std::int64_t, std::pair<Vec3, Vec3>> out;
    for (std::size_t i = 0; i < s.particles.size(); ++i)
        out[s.particles.id[i]] = {s.particles.position[i], s.particles.velocity[i]};
    return out;
}

TEST(SolidsAndLiquids, KeepTheirMomentumTogether) {
    // A block of rubber flies through a ball of water in free space. Velocities are rounded to 6e-8 of themselves at
    // every step and sub-step, and the frame of the body turns: 1e-5 of sum m|v|.
    scene::Scene scene = fixture::empty_space();
    scene.materials.push_back(rubber());
    scene.materials[1].density = 600;
    scene.bodies = {fixture::body("drop", fixture::shape_at({0, 0, 0}, scene::Sphere{0.05})),
                    of(fixture::body("block", box({0.09, 0.01, 0}, {0.06, 0.05, 0.06}), {-1, 0, 0}), "rubber")};
    for (const auto viscosity : {scene::Viscosity::explicit_force, scene::Viscosity::implicit_solve}) {
        scene.materials[0].viscosity = 2;
        scene.solver.viscosity = viscosity;
        Simulation s = make_simulation(scene);
        const Vec3d before = fixture::momentum(s.particles);
        const double motion = fixture::motion(s.particles);
        Vec3d block(0, 0, 0);
        for (int k = 0; k < 4; ++k) advance_frame(s);
        for (std::size_t i = 0; i < s.particles.size(); ++i)
            if (is_elastic(s.particles.phase[i]))
                block += static_cast<double>(s.particles.mass[i]) * s.particles.velocity[i].cast<double>();
        EXPECT_GT(block.x(), 0.8 * before.x());  // it was slowed down
        EXPECT_LT((fixture::momentum(s.particles) - before).norm(), 1e-5 * motion);
    }
}

TEST(Melting, ColdMatterIsExactlyASolid) {
    scene::Scene scene = fixture::empty_space();
    scene.world.gravity = {0, 0, -9.81};
    scene.world.boundaries = {fixture::floor_at(0)};
    scene.materials = {wax()};
    scene.bodies = {of(fixture::body("block", box({0, 0, 0.05}, {0.06, 0.05, 0.06}), {0.3, 0, -1}), "wax")};
    scene.bodies[0].angular_velocity = {3, 8, 1};
    Simulation melting = make_simulation(scene);
    scene.materials[0].melting = {};
    Simulation plain = make_simulation(scene);
    // A solid that does not melt has other particles. Here it has those of the one that melts.
    plain.particles = melting.particles;
    plain.solids = make_solids(plain.problem.scene, plain.problem.smoothing, plain.problem.periodic, plain.particles);
    plain.solids.elements.quadrature = plain.solids.elements.volume;
    locate_particles(plain.particles, plain.solids);
    ASSERT_TRUE(melting.solids.softening.any && !plain.solids.softening.any);
    for (int k = 0; k < 4; ++k) advance_frame(melting), advance_frame(plain);
    EXPECT_EQ(places(melting), places(plain));
    EXPECT_EQ(melting.particles.density, plain.particles.density);
}

TEST(Melting, MoltenMatterIsExactlyALiquid) {
    scene::Scene scene = fixture::empty_space();
    scene.world.gravity = {0, 0, -9.81};
    scene.world.boundaries = {fixture::floor_at(0)};
    scene.materials = {wax()};
    scene.bodies = {of(fixture::body("block", box({0, 0, 0.05}, {0.06, 0.05, 0.06}), {0.3, 0, -1}), "wax", 80)};
    Simulation melting = make_simulation(scene);
    scene.materials[0].viscosity = scene.materials[0].melting.liquid.viscosity;
    scene.materials[0].elastic = {};
    scene.materials[0].melting = {};
    Simulation plain = make_simulation(scene);
    ASSERT_TRUE(melting.solids.softening.any && plain.solids.empty());
    for (int k = 0; k < 4; ++k) advance_frame(melting), advance_frame(plain);
    EXPECT_EQ(places(melting), places(plain));
    EXPECT_EQ(melting.particles.pressure, plain.particles.pressure);
}

double height(const Simulation& s) {
    double mass = 0, sum = 0;
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        mass += static_cast<double>(s.particles.mass[i]);
        sum += static_cast<double>(s.particles.mass[i] * s.particles.position[i].z());
    }
    return sum / mass;
}

TEST(Melting, ABlockMeltedAndFrozenAgainBounces) {
    // The molten block spreads on the floor. Frozen again it keeps the shape it has by then. Thrown up, it comes down
    // and bounces as a whole: it rises by more than its spacing, and keeps its shape.
    scene::Scene scene = fixture::empty_space();
    scene.world.gravity = {0, 0, -9.81};
    scene.world.boundaries = {fixture::floor_at(0)};
    scene.materials = {wax()};
    scene.materials[0].viscosity = 1;
    scene.materials[0].elastic.contact_damping = 0.1;
    scene.materials[0].melting.liquid.viscosity = 40;
    scene.bodies = {of(fixture::body("block", box({0, 0, 0.041}, {0.06, 0.06, 0.08})), "wax", 80)};
    Simulation s = make_simulation(scene);
    const double at_first = height(s);
    for (int k = 0; k < 4; ++k) advance_frame(s);
    const double spread = height(s);
    EXPECT_LT(spread, 0.8 * at_first);
    set_temperature(s, [](const Vec3&) { return 20; });
    for (int k = 0; k < 8; ++k) advance_frame(s);
    for (const Phase phase : s.particles.phase) ASSERT_EQ(phase, Phase::solid);
    const auto shape = places(s);
    for (auto& v : s.solids.elements.velocity)
        v = quad(s.solids.bodies[0].turn.cast<Real>().transpose() * Vec3(0, 0, 1.2f));
    double highest = 0, after = 0;
    for (int k = 0; k < 12; ++k) {
        advance_frame(s);
        if (k < 5) highest = std::max(highest, height(s));
        if (k > 6) after = std::max(after, height(s));
    }
    EXPECT_GT(highest, spread + 0.05);
    EXPECT_GT(after, spread + 0.01);
    // The shape: distances of particles to their centre.
    Vec3 before(0, 0, 0), now(0, 0, 0);
    for (const auto& [id, x] : shape) before += x.first / static_cast<Real>(shape.size());
    const auto end = places(s);
    for (const auto& [id, x] : end) now += x.first / static_cast<Real>(end.size());
    double change = 0;
    for (const auto& [id, x] : end)
        change = std::max(change,
                          static_cast<double>(std::abs((x.first - now).norm() - (shape.at(id).first - before).norm())));
    EXPECT_LT(change, 0.005);  // half a spacing
}

TEST(Melting, TheSurfaceOfWhatHasFrozenAgainIsASolids) {
    // A block melts half way on a floor, freezes, and then flies up spinning. Its surface turns with it as that of a
    // solid does, and keeps every disc.
    scene::Scene scene = fixture::empty_space();
    scene.world.gravity = {0, 0, -9.81};
    scene.world.boundaries = {fixture::floor_at(0)};
    scene.surface.enabled = true;
    scene.materials = {wax()};
    scene.materials[0].viscosity = 5;
    scene.materials[0].elastic.youngs_modulus = 1e6;
    scene.materials[0].melting.liquid.viscosity = 40;
    scene.bodies = {of(fixture::body("block", box({0, 0, 0.031}, {0.06, 0.06, 0.06})), "wax", 30)};
    Simulation s = make_simulation(scene);
    advance_frame(s);
    set_temperature(s, [](const Vec3& x) { return x.z() < 0.04f ? 70.0 : 30.0; });
    for (int k = 0; k < 3; ++k) advance_frame(s);
    EXPECT_GT(s.mixed_surface.zombies.size(), 0u);
    set_temperature(s, [](const Vec3&) { return 20; });
    for (int k = 0; k < 8; ++k) advance_frame(s);
    ASSERT_TRUE(s.solids.bodies[0].refrozen);
    EXPECT_EQ(s.mixed_surface.refrozen.size(), s.surface.size());
    EXPECT_EQ(s.mixed_surface.zombies.size(), 0u);
    const auto shape = [&] {
        std::map<std::int64_t, std::pair<Vec3, Vec3>> out;  // place, m0
        const Mat3 back = s.solids.bodies[0].turn.cast<Real>().transpose();
        for (std::size_t i = 0; i < s.surface.size(); ++i)
            out[s.surface.id[i]] = {back * (s.surface.surfels.position[i] - s.solids.bodies[0].place.cast<Real>()),
                                    s.surface.rest[i]};
        return out;
    };
    // The body is free, and its vibration ends first. A rest shape that was taken on the floor would carry its weight.
    scene.world.gravity = {0, 0, 0};
    s.problem.outside.gravity = Vec3::Zero();
    s.problem.scene.world.gravity = {0, 0, 0};
    for (auto& v : s.solids.elements.velocity)
        v = quad(s.solids.bodies[0].turn.cast<Real>().transpose() * Vec3(0, 0, 0.5f));
    for (int k = 0; k < 6; ++k) advance_frame(s);
    const auto before = shape();
    const Vec3 centre = s.solids.bodies[0].place.cast<Real>();
    const Mat3 back = s.solids.bodies[0].turn.cast<Real>().transpose();
    for (std::size_t k = 0; k < s.particles.size(); ++k) {
        const Index i = s.solids.element(s.particles.id[k]);
        const Vec3 v = Vec3(0, 0, 0.5f) + Vec3(3, 2, 8).cross(s.particles.position[k] - centre);
        s.solids.elements.velocity[i] = quad(back * v);
    }
    double turned = 0;
    const Mat3d first = s.solids.bodies[0].turn;
    for (int k = 0; k < 12; ++k) {
        advance_frame(s);
        turned = std::max(turned, Eigen::AngleAxisd(first.transpose() * s.solids.bodies[0].turn).angle());
    }
    EXPECT_GT(turned, 2);
    const auto after = shape();
    ASSERT_EQ(after.size(), before.size());
    double moved = 0;
    for (const auto& [id, at] : after) {
        ASSERT_TRUE(before.contains(id));
        EXPECT_EQ(at.second, before.at(id).second);
        moved = std::max(moved, static_cast<double>((at.first - before.at(id).first).norm()));
    }
    // A centrifugal stress of 20 Pa is negligible beside 1 MPa, but the body still vibrates. The tolerance is a
    // hundredth of a spacing. Moved by the particles' mean motion, the surface would be off by a spacing.
    EXPECT_LT(moved, 1e-4);
}

TEST(Melting, TheColdHalfOfARodSpringsBackWhenTheHotHalfHasFlowedOff) {
    // In free space the hot half is pulled away. The cold half remembers its own rest shape alone, and returns to it to
    // 1 % of its length.
    scene::Scene scene = fixture::empty_space();
    scene.materials = {wax()};
    scene.materials[0].viscosity = 60;
    scene.bodies = {of(fixture::body("rod", box({0, 0, 0}, {0.16, 0.04, 0.04})), "wax")};
    scene::Handle left, right;
    left.name = "left";
    left.body = right.body = "rod";
    left.region = box({-0.08, 0, 0}, {0.02, 1, 1});
    right.name = "right";
    right.region = box({-0.02, 0, 0}, {0.022, 1, 1});
    right.motion = {{.time = 0}, {.time = 0.1, .position = {0.012, 0, 0}}};
    left.stop = right.stop = 0.2;
    scene.handles = {left, right};
    Simulation s = make_simulation(scene);
    std::map<std::int64_t, Vec3> rest;
    for (std::size_t i = 0; i < s.particles.size(); ++i) rest[s.particles.id[i]] = s.particles.position[i];
    set_temperature(s, [](const Vec3& x) { return x.x() > 0.01f ? 80.0 : 20.0; });
    const auto length = [&](bool now) {
        double right_sum = 0, left_sum = 0;
        int right_count = 0, left_count = 0;
        for (std::size_t i = 0; i < s.particles.size(); ++i) {
            const Vec3 m = rest[s.particles.id[i]];
            const double x = static_cast<double>(now ? s.particles.position[i].x() : m.x());
            if (m.x() < -0.07f) left_sum += x, ++left_count;
            if (m.x() > -0.02f && m.x() < 0.0f) right_sum += x, ++right_count;
        }
        return right_sum / right_count - left_sum / left_count;
    };
    // The hot matter flies off to the right.
    for (std::size_t i = 0; i < s.particles.size(); ++i)
        if (s.particles.temperature[i] > 60) s.particles.velocity[i].x() = 0.5f;
    double stretched = 0;
    for (int k = 0; k < 20; ++k) {
        advance_frame(s);
        stretched = std::max(stretched, length(true) / length(false));
    }
    EXPECT_GT(stretched, 1.1);
    EXPECT_NEAR(length(true) / length(false), 1, 0.01);
    double farthest = 0;
    for (const Vec3& x : s.particles.position) farthest = std::max(farthest, static_cast<double>(x.x()));
    EXPECT_GT(farthest, 0.2);  // the hot half has gone
}

TEST(Melting, HeatBetweenSolidsAndLiquidsIsConserved) {
    // 1e-6 of sum C |T - mean|: the rounding of single-precision sums.
    scene::Scene scene = busy();
    scene.world.boundaries[0].isothermal = false;
    scene.emitters.clear();
    Simulation s = make_simulation(scene);
    set_temperature(s, [](const Vec3& x) { return 20 + 800 * static_cast<double>(x.z()); });
    double mean = 0, mass = 0, spread = 0;
    const auto weight = [&](std::size_t i) {
        return static_cast<double>(s.particles.mass[i]) *
               s.problem.materials[static_cast<std::size_t>(s.particles.material[i])].thermal.heat_capacity;
    };
    for (std::size_t i = 0; i < s.particles.size(); ++i)
        mean += weight(i) * s.particles.temperature[i], mass += weight(i);
    for (std::size_t i = 0; i < s.particles.size(); ++i)
        spread += weight(i) * std::abs(s.particles.temperature[i] - mean / mass);
    const double before = fixture::heat_of(s);
    for (int k = 0; k < 8; ++k) advance_frame(s);
    EXPECT_LT(std::abs(fixture::heat_of(s) - before), 1e-6 * spread);
    bool melted = false, cold = false;
    for (const Real b : s.particles.melt) melted = melted || b == 1, cold = cold || b == 0;
    EXPECT_TRUE(melted && cold);
}

TEST(Melting, WhatIsSolidStillMeetsWhatIsSolid) {
    // Two cubes of wax meet at 1 m/s in free space, as two bodies and as two parts of one. A far corner of each is
    // liquid. With contact for solid bodies alone they would go through each other.
    for (const bool one_body : {false, true}) {
        scene::Scene scene = fixture::empty_space();
        scene.materials = {wax()};
        scene.frames.fps = 200;
        const scene::Shape left = box({-0.036, 0, 0}, {0.06, 0.06, 0.06}),
                           right = box({0.036, 0, 0}, {0.06, 0.06, 0.06});
        scene::Union both;
        both.shapes = {left, right};
        if (one_body)
            scene.bodies = {of(fixture::body("both", fixture::shape_at({0, 0, 0}, both)), "wax")};
        else
            scene.bodies = {of(fixture::body("left", left), "wax"), of(fixture::body("right", right), "wax")};
        Simulation s = make_simulation(scene);
        std::map<std::int64_t, bool> is_left;
        Elements& e = s.solids.elements;
        for (std::size_t i = 0; i < s.particles.size(); ++i) {
            const bool side = is_left[s.particles.id[i]] = s.particles.position[i].x() < 0;
            s.particles.velocity[i].x() = side ? 0.5f : -0.5f;
            e.velocity[s.solids.element(s.particles.id[i])].x = side ? 0.5f : -0.5f;
        }
        set_temperature(s, [](const Vec3& x) { return std::abs(x.x()) > 0.055f && x.z() > 0.02f ? 80.0 : 20.0; });
        const Real width = std::cbrt(s.particles.rest_volume[0]);
        Real nearest = 1;
        for (int k = 0; k < 16; ++k) {
            advance_frame(s);
            for (std::size_t i = 0; i < s.particles.size(); ++i)
                for (std::size_t j = 0; j < i; ++j)
                    if (is_left[s.particles.id[i]] != is_left[s.particles.id[j]])
                        nearest = std::min(nearest, (s.particles.position[i] - s.particles.position[j]).norm());
        }
        EXPECT_LT(nearest, width);  // they met
        EXPECT_GT(nearest, Real(0.5) * width);
        Real gone = 0;
        for (std::size_t i = 0; i < s.particles.size(); ++i)
            if (s.particles.melt[i] == 0)
                gone += is_left[s.particles.id[i]] ? -s.particles.velocity[i].x() : s.particles.velocity[i].x();
        EXPECT_GT(gone, 0);  // and fly apart
        EXPECT_LT(fixture::momentum(s.particles).norm(), 1e-5 * fixture::motion(s.particles));
    }
}

TEST(Melting, KeepsMomentum) {
    // A block melts from the middle on while it spins apart in free space; elastic, viscous and pressure forces all
    // act.
    scene::Scene scene = fixture::empty_space();
    scene.materials = {wax()};
    scene.materials[0].thermal.conductivity = 400;
    scene.bodies = {of(fixture::body("block", box({0, 0, 0}, {0.08, 0.05, 0.05}), {0.5, 0.2, 0}), "wax")};
    scene.bodies[0].angular_velocity = {0, 0, 30};
    Simulation s = make_simulation(scene);
    set_temperature(
        s, [](const Vec3& x) { return 20 + 100 * std::exp(-static_cast<double>(x.squaredNorm()) / square(0.03)); });
    const Vec3d before = fixture::momentum(s.particles);
    const double motion = fixture::motion(s.particles);
    for (int k = 0; k < 4; ++k) advance_frame(s);
    EXPECT_LT((fixture::momentum(s.particles) - before).norm(), 1e-5 * motion);
}

TEST(Flowing, AViscoelasticJetHangsTogetherAndKeepsMomentum) {
    // Matter from an emitter whose material has a stiffness is bound to its current neighbours.
    scene::Scene scene = fixture::empty_space();
    scene.materials = {rubber()};
    scene.materials[0].viscosity = 5;
    scene::Emitter spout;
    spout.name = "spout";
    spout.material = "rubber";
    spout.radius = 0.025;
    spout.stop = 0.1;
    scene.emitters = {spout};
    Simulation s = make_simulation(scene);
    for (int k = 0; k < 3; ++k) advance_frame(s);
    ASSERT_GT(s.particles.size(), 100u);
    const Vec3d before = fixture::momentum(s.particles);
    for (int k = 0; k < 6; ++k) advance_frame(s);
    EXPECT_LT((fixture::momentum(s.particles) - before).norm(), 1e-5 * fixture::motion(s.particles));
    for (const Phase phase : s.particles.phase) EXPECT_EQ(phase, Phase::viscoelastic);
}

TEST(Refrozen, BondsThatPersistKeepTheirVisibility) {
    // A cracked block of rubber beside one of wax. When the wax has frozen in another shape, the neighbours of all
    // bodies are found anew: the crack stays.
    scene::Scene scene = fixture::empty_space();
    scene.materials = {wax(), rubber()};
    scene.bodies = {of(fixture::body("cracked", box({0, 0, 0}, {0.06, 0.05, 0.05})), "rubber"),
                    of(fixture::body("frozen", box({0.2, 0, 0}, {0.05, 0.05, 0.05})), "wax")};
    Simulation s = make_simulation(scene);
    Elements& e = s.solids.elements;
    const auto across = [&](Index i, Index j) {
        return e.owner[i] == 0 && e.owner[j] == 0 && (e.rest[i].x < 0) != (e.rest[j].x < 0);
    };
    set_visibility(e, [&](Index i, Index j) { return across(i, j) ? Real(0.25) : Real(1); });
    const std::vector<Real> weight = e.bonds.weight;
    SolidBody& frozen = s.solids.bodies[1];
    frozen.refrozen = true;
    frozen.shape.reset();
    // Its first and last element are close in the new shape: they have a new bond.
    const Index first = frozen.elements.front(), last = frozen.elements.back();
    e.rest[last] = quad(xyz(e.rest[first]) + Vec3(Real(0.005), 0, 0));
    find_refrozen_neighbours(s.solids);

    ASSERT_EQ(e.bonds.visibility.size(), e.bonds.neighbour.size());
    std::size_t hidden = 0, made = 0;
    for (Index i = 0; i < e.size(); ++i)
        for (std::size_t k = e.bonds.begin[i]; k < e.bonds.begin[i + 1]; ++k) {
            const Index j = e.bonds.neighbour[k];
            if (j == i) continue;
            const Real expected = across(i, j) ? Real(0.25) : Real(1);
            EXPECT_EQ(e.bonds.visibility[k], expected);
            EXPECT_EQ(e.bonds.weight[k], expected * e.bonds.base[k]);
            hidden += expected < 1 ? 1 : 0;
            made += i == first && j == last ? 1 : 0;
            if (e.owner[i] == 0) EXPECT_EQ(e.bonds.weight[k], weight[k]) << "a body that has not changed";
        }
    EXPECT_GT(hidden, 100u);
    EXPECT_EQ(made, 1u);
}

}  // namespace
}  // namespace thixo
