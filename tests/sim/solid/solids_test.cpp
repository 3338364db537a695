// Solids within a simulation: what is conserved, what holds, and that runs repeat.
#include "sim/state/solids.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/geometry/shapes.h"
#include "sim/bonds/gradients.h"
#include "sim/solid/laws.h"
#include "tests/sim/identity.h"
#include "tests/sim/solid/blocks.h"
#include "tests/sim/solid/rubber.h"

namespace thixo {
namespace {

scene::Handle handle(const scene::Shape& region, double start = 0, double stop = 1e9) {
    scene::Handle h;
    h.name = "hand";
    h.body = "block";
    h.region = region;
    h.start = start;
    h.stop = stop;
    return h;
}

/// A block that turns while it falls on a floor, is held by a handle for a while, dents, and has a surface.
scene::Scene busy() {
    scene::Scene s = fixture::rubber_scene();
    s.world.gravity = {0, 0, -9.81};
    s.world.boundaries = {fixture::floor_at(-0.045)};
    s.materials[0].elastic.creep = 20;
    s.materials[0].elastic.yield_strain = 0.02;
    s.materials.push_back(s.materials[0]);
    s.materials[1].name = "stiffer";
    s.materials[1].elastic.youngs_modulus = 2e5;
    s.materials[0].elastic.changes = {{.time = 0.06, .duration = 0.03, .material = "stiffer"}};
    s.bodies = {
        fixture::body("block", fixture::shape_at({0, 0, 0}, scene::BoxShape{{0.06, 0.06, 0.06}, 0}), {0.2, 0, -0.5})};
    s.bodies[0].angular_velocity = {3, 8, 1};
    s.bodies[0].surfels = 300;
    s.handles = {handle(fixture::shape_at({0, 0, 0.03}, scene::BoxShape{{1, 1, 0.02}, 0}), 0.05, 0.09)};
    s.surface.enabled = true;
    s.frames.fps = 30;
    return s;
}

TEST(Solids, ABodyThatSpinsAndTremblesKeepsItsMomenta) {
    // Velocities are rounded at random, by 6e-8 of their size, in each of a thousand sub-steps and in every turn of the
    // frame. That gives 1e-6 of sum m|v|, and of its arm.
    scene::Scene scene = fixture::rubber_scene();
    scene.bodies = {fixture::body("block", fixture::shape_at({0.5, 0.2, 0}, scene::BoxShape{{0.08, 0.05, 0.06}, 0}),
                                  {1, -0.5, 0.3})};
    scene.bodies[0].angular_velocity = {5, 20, 10};
    Simulation s = make_simulation(scene);
    for (std::size_t i = 0; i < s.solids.elements.size(); ++i)
        s.solids.elements.velocity[i].x += (i % 2 ? 0.3f : -0.3f);
    fixture::steps(s, 1, 1e-4);
    const Vec3d linear = fixture::momentum(s.particles), angular = fixture::angular_momentum(s.particles);
    const double motion = fixture::motion(s.particles);
    int sub_steps = 0;
    while (sub_steps < 1000) {
        fixture::steps(s, 1, 0.004);
        sub_steps = s.stats.solid_sub_steps;
    }
    EXPECT_LT((fixture::momentum(s.particles) - linear).norm(), 1e-6 * motion);
    // v(t) of a particle is extrapolated from half a sub-step before, with an unchanged force. The vibration changes
    // the angular momentum in that time.
    EXPECT_LT((fixture::angular_momentum(s.particles) - angular).norm(), 1e-4 * motion * 0.1);
}

TEST(Solids, ResumedRunEqualsTheUninterruptedOneBitForBit) {
    Simulation whole = make_simulation(busy());
    refresh_surface(whole);
    for (int k = 0; k < 2; ++k) advance_frame(whole);
    fixture::expect_resumes(whole, 2);
    EXPECT_EQ(whole.surface.size(), 300u);
    Real dent = 0;
    for (const Symmetric& p : whole.solids.elements.plastic) dent = std::max(dent, norm(p));
    EXPECT_GT(dent, 0.001);
}

TEST(Solids, StateIsTheSameAtAnyThreadCount) {
    fixture::expect_same_at_any_thread_count(busy(), [](Simulation& s) {
        refresh_surface(s);
        for (int k = 0; k < 3; ++k) advance_frame(s);
    });
}

TEST(Solids, ABodyHasTheVolumeAndMassOfItsShape) {
    scene::Scene scene = fixture::rubber_scene();
    scene.bodies = {fixture::body("block", fixture::shape_at({0, 0, 0}, scene::Sphere{0.053}))};
    const Simulation s = make_simulation(scene);
    double mass = 0;
    for (const Real m : s.particles.mass) mass += static_cast<double>(m);
    EXPECT_NEAR(mass, 1000 * 4 / 3.0 * kPi * cube(0.053), 1e-3 * mass);  // the volume of shapes is found to that
}

TEST(Solids, PartsOfABodyHangTogetherThroughMatterAlone) {
    // Two cubes 9 mm apart, closer than the support of 20 mm, and a bar that joins two more.
    scene::Scene scene = fixture::rubber_scene();
    const auto box = [](const Vec3d& at, const Vec3d& size) { return fixture::shape_at(at, scene::BoxShape{size, 0}); };
    scene::Union parts;
    parts.shapes = {box({-0.0345, 0, 0}, {0.06, 0.06, 0.06}), box({0.0345, 0, 0}, {0.06, 0.06, 0.06}),
                    box({0, 0, 0.1}, {0.13, 0.06, 0.06})};
    scene.bodies = {fixture::body("parts", fixture::shape_at({0, 0, 0}, parts))};
    const Simulation s = make_simulation(scene);
    const Elements& e = s.solids.elements;
    int across = 0, joined = 0, apart = 0;
    for (Index i = 0; i < e.size(); ++i)
        for (std::size_t k = e.bonds.begin[i]; k < e.bonds.begin[i + 1]; ++k) {
            const Index j = e.bonds.neighbour[k];
            const Vec3 a = xyz(e.rest[i]) + s.solids.bodies[0].place.cast<Real>(),
                       b = xyz(e.rest[j]) + s.solids.bodies[0].place.cast<Real>();
            const bool other_side = a.x() * b.x() < 0;
            if (a.z() > 0.05f || b.z() > 0.05f)
                joined += other_side;
            else
                across += other_side;
        }
    for (Index i = 0; i < e.size(); ++i)
        for (Index j = 0; j < i; ++j) {
            const Vec3 way = xyz(e.rest[i]) - xyz(e.rest[j]);
            apart +=
                way.norm() < e.support[i] && std::abs(way.x()) > 0.009f && xyz(e.rest[i]).x() * xyz(e.rest[j]).x() < 0;
        }
    EXPECT_EQ(across, 0);
    EXPECT_GT(joined, 0);
    EXPECT_GT(apart, 0);  // some are near enough
}

TEST(Solids, AHandleHoldsMovesAndLetsGo) {
    scene::Scene scene = fixture::rubber_scene();
    scene.bodies = {fixture::body("block", fixture::shape_at({0, 0, 0}, scene::BoxShape{{0.06, 0.06, 0.06}, 0}))};
    scene.handles = {handle(fixture::shape_at({0, 0, 0}, scene::BoxShape{{1, 1, 1}, 0}), 0, 0.2)};
    scene.handles[0].motion = {{.time = 0}, {.time = 0.1, .position = {0.1, 0, 0}, .rotate = {0, 0, 90}}};
    scene.frames.fps = 20;
    Simulation s = make_simulation(scene);
    std::map<std::int64_t, Vec3d> rest;
    for (std::size_t i = 0; i < s.particles.size(); ++i)
        rest[s.particles.id[i]] = s.particles.position[i].cast<double>();
    for (int k = 0; k < 3; ++k) advance_frame(s);
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        const Vec3d m = rest[s.particles.id[i]];
        EXPECT_LT((s.particles.position[i].cast<double>() - Vec3d(0.1 - m.y(), m.x(), m.z())).norm(), 1e-6);
        EXPECT_LT(s.particles.velocity[i].norm(), 1e-4);
    }
    // Released, it stays. It was moved without strain, so that no stress drives it back.
    for (int k = 0; k < 4; ++k) advance_frame(s);
    EXPECT_LT(fixture::motion(s.particles) / (1000 * cube(0.06)), 1e-4);
}

TEST(Solids, ElasticMatterSpringsBackAndPlasticMatterKeepsItsDent) {
    // The body is stretched by a fifth, held, and released, with enough damping to settle. An elastic one returns to
    // within a hundredth of the stretch.
    for (const double creep : {0.0, 30.0}) {
        scene::Scene scene = fixture::rubber_scene();
        scene.materials[0].viscosity = 100;
        scene.materials[0].elastic.creep = creep;
        scene.materials[0].elastic.yield_strain = 0.05;
        scene.bodies = {fixture::body("block", fixture::shape_at({0, 0, 0}, scene::BoxShape{{0.04, 0.04, 0.1}, 0}))};
        scene.handles = {handle(fixture::shape_at({0, 0, 0.05}, scene::BoxShape{{1, 1, 0.02}, 0}), 0, 0.4),
                         handle(fixture::shape_at({0, 0, -0.05}, scene::BoxShape{{1, 1, 0.02}, 0}), 0, 0.4)};
        scene.handles[1].name = "other";
        scene.handles[0].motion = {{.time = 0}, {.time = 0.2, .position = {0, 0, 0.02}}};
        Simulation s = make_simulation(scene);
        const auto length = [&] {
            Real top = -1, bottom = 1;
            for (const Vec3& x : s.particles.position) {
                top = std::max(top, x.z());
                bottom = std::min(bottom, x.z());
            }
            return static_cast<double>(top - bottom);
        };
        const double rest = length();
        for (int k = 0; k < 24; ++k) advance_frame(s);
        const double kept = (length() - rest) / 0.02;
        if (creep == 0)
            EXPECT_NEAR(kept, 0, 0.01);
        else
            EXPECT_GT(kept, 0.3);
    }
}

TEST(Solids, ASurfaceFollowsARigidMotionExactly) {
    scene::Scene scene = fixture::rubber_scene();
    scene.surface.enabled = true;
    scene.bodies = {fixture::body("block", fixture::shape_at({0.2, 0, 0}, scene::Sphere{0.04}))};
    scene.bodies[0].surfels = 500;
    scene.handles = {handle(fixture::shape_at({0, 0, 0}, scene::BoxShape{{1, 1, 1}, 0}))};
    scene.handles[0].motion = {{.time = 0}, {.time = 0.04, .position = {0, 0, 0.3}, .rotate = {0, 90, 0}}};
    Simulation s = make_simulation(scene);
    refresh_surface(s);
    const SurfelCloud before = s.surface.surfels;
    advance_frame(s);
    const auto turned = [](const Vec3& a) { return Vec3(a.z(), a.y(), -a.x()); };
    for (std::size_t i = 0; i < before.size(); ++i) {
        EXPECT_LT((s.surface.surfels.position[i] - turned(before.position[i]) - Vec3(0, 0, 0.3f)).norm(), 1e-6f);
        EXPECT_LT((s.surface.surfels.axis1[i] - turned(before.axis1[i])).norm(), 1e-7f);
        EXPECT_LT((s.surface.surfels.normal[i] - turned(before.normal[i])).norm(), 1e-4f);
    }
}

TEST(Solids, TheLastElementsOfAThinLimbTurnWithIt) {
    // A block that ends in a row of single particles: the last ones have neighbours along it alone.
    Elements e = fixture::block(4, 4, 4, 0.01f, 0.1f);
    for (int k = 0; k < 4; ++k) {
        const Elements one = fixture::block(1, 1, 1, 0.01f, 0);
        e.id.push_back(static_cast<std::int64_t>(e.size()));
        e.owner.push_back(0);
        e.rest.push_back({0.04f + 0.01f * static_cast<float>(k), 0.015f, 0.015f, 0});
        e.volume.push_back(one.volume[0]);
        e.quadrature.push_back(one.quadrature[0]);
        e.mass.push_back(one.mass[0]);
        e.support.push_back(one.support[0]);
        e.depth.push_back(one.depth[0]);
        e.displacement.push_back({0, 0, 0, 0});
        e.velocity.push_back({0, 0, 0, 0});
        e.acceleration.push_back(Vec3::Zero());
        e.plastic.push_back({});
    }
    StressLaw law;
    law.mu = 1e5;
    e = fixture::prepared(std::move(e), law);
    ASSERT_FALSE(e.bonds.moment.back().full);
    const Mat3 turn = Eigen::AngleAxis<Real>(Real(1.3), Vec3(0.3f, -0.8f, 0.52f).normalized()).toRotationMatrix();
    fixture::move(e, [&](const Vec3& m) { return Vec3(turn * m + Vec3(0.02f, 0, 0.01f)); });
    std::vector<Mat3> gradients;
    find_gradients(e, gradients);
    EXPECT_GT((gradients.back() + Mat3::Identity() - turn).norm(), 0.1f);  // they do not know of themselves
    complete_gradients(e, gradients);
    for (const Mat3& h : gradients) EXPECT_LT((h + Mat3::Identity() - turn).norm(), 2e-4f);
}

TEST(Solids, AnOrthotropicBodyPassesThePatchTest) {
    scene::Scene scene = fixture::rubber_scene();
    scene::Orthotropic& o = scene.materials[0].elastic.orthotropic;
    o.youngs_modulus = {4e5, 1e5, 2e5};
    o.shear_modulus = {8e4, 3e4, 5e4};
    o.poisson_ratio = {0.3, 0.2, 0.1};
    o.rotate = {20, 35, -50};
    scene.bodies = {fixture::body("block", fixture::shape_at({0.2, 0, 0}, scene::BoxShape{{0.12, 0.12, 0.12}, 0}))};
    Simulation s = make_simulation(scene);
    fixture::steps(s, 1, 1e-6);  // sets up the laws
    Elements& e = s.solids.elements;
    const Mat3 h = (Mat3() << 0.01f, 0.02f, -0.01f, 0.005f, -0.02f, 0.015f, 0.01f, -0.005f, 0.015f).finished();
    for (std::size_t i = 0; i < e.size(); ++i) {
        e.displacement[i] = quad(h * xyz(e.rest[i]));
        e.velocity[i] = quad(Vec3::Zero());
    }
    StressScratch scratch;
    std::vector<Vec3> force;
    find_stress_forces(s.solids.laws, e, scratch, force);
    // C of the strain by hand, in Voigt's order.
    const Mat3 strain = Real(0.5) * (h + h.transpose() + h.transpose() * h);
    const Mat3d axes = rotation_from_degrees(o.rotate).toRotationMatrix();
    Eigen::Matrix<Real, 6, 1> voigt;
    voigt << strain(0, 0), strain(1, 1), strain(2, 2), 2 * strain(0, 1), 2 * strain(1, 2), 2 * strain(2, 0);
    const Eigen::Matrix<Real, 6, 1> stress = orthotropic_stiffness(o, axes) * voigt;
    std::size_t within = 0;
    const Real size = stress.cwiseAbs().maxCoeff(), width = std::cbrt(e.volume[0]);
    for (std::size_t i = 0; i < e.size(); ++i) {
        const Symmetric found = total_stress(s.solids.laws[0], e, i, gradient_of(e, i));
        const Real all[6] = {found.xx, found.yy, found.zz, found.xy, found.yz, found.zx};
        for (int k = 0; k < 6; ++k) EXPECT_NEAR(all[k], stress[k], 1e-3f * size);  // a gradient's rounding over 1 %
        // Two supports below the surface a uniform stress gives no force.
        if (xyz(e.rest[i]).cwiseAbs().maxCoeff() > Real(0.06) - 2 * e.support[i]) continue;
        ++within;
        EXPECT_LT(force[i].norm(), 1e-3f * size * width * width);
    }
    EXPECT_GT(within, 7u);
}

/// u(m) of dissertation 5.28, over all elements of the one body.
Vec3d displacement_by_formula(const Simulation& s, const Vec3d& m, double support) {
    const Elements& e = s.solids.elements;
    double weight = 0;
    Vec3d sum(0, 0, 0);
    for (std::size_t j = 0; j < e.size(); ++j) {
        const Vec3d from = m - xyz(e.rest[j]).cast<double>();
        const double q = 1 - from.squaredNorm() / square(support), w = q > 0 ? q * q * q : 0;
        weight += w;
        sum += w * (xyz(e.displacement[j]).cast<double>() + gradient_of(e, j).cast<double>() * from);
    }
    return sum / weight;
}

TEST(Solids, ASurfaceIsDisplacedAsTheFormulaSays) {
    scene::Scene scene = fixture::rubber_scene();
    scene.surface.enabled = true;
    scene.bodies = {fixture::body("block", fixture::shape_at({0.2, 0, 0}, scene::BoxShape{{0.06, 0.06, 0.06}, 0}))};
    scene.bodies[0].surfels = 600;
    Simulation s = make_simulation(scene);
    const Elements& e = s.solids.elements;
    // The body is bent, and stretched so far at one end that some surfels split.
    for (std::size_t i = 0; i < e.size(); ++i) {
        const Vec3 m = xyz(e.rest[i]);
        const Real end = std::max(m.z(), Real(0));
        s.solids.elements.displacement[i] = quad(Vec3(8 * m.z() * m.z(), 5 * m.x() * m.y(), 25 * end * end));
    }
    refresh_surface(s);
    const SurfelCloud& rest = s.embedded.rest;
    std::size_t whole = 0;
    for (std::size_t i = 0; i < s.surface.size(); ++i) {
        const Index root = s.embedded_source[i];
        EXPECT_GE(root, s.embedded_source[i > 0 ? i - 1 : 0]);
        EXPECT_LT(
            (s.surface.surfels.axis1[i].cross(s.surface.surfels.axis2[i]).normalized() - s.surface.surfels.normal[i])
                .norm(),
            1e-5f);
        if (s.surface.id[i] != static_cast<std::int64_t>(root)) continue;
        ++whole;
        const auto u = [&](const Vec3& m) {
            return displacement_by_formula(s, m.cast<double>(), static_cast<double>(s.embedded.support[root]));
        };
        const Vec3 &m = rest.position[root], &a = rest.axis1[root], &b = rest.axis2[root];
        const Vec3d middle = u(m), place = m.cast<double>() + middle + s.solids.bodies[0].place;
        // Rounding: of places a metre off the origin, and of a hundred terms.
        EXPECT_LT((s.surface.surfels.position[i].cast<double>() - place).norm(), 2e-7);
        EXPECT_LT((s.surface.surfels.axis1[i].cast<double>() - a.cast<double>() - u(m + a) + middle).norm(), 1e-7);
        EXPECT_LT((s.surface.surfels.axis2[i].cast<double>() - b.cast<double>() - u(m + b) + middle).norm(), 1e-7);
    }
    EXPECT_GT(whole, 300u);
    EXPECT_LT(whole, s.embedded.size());
    EXPECT_GT(s.surface.size(), s.embedded.size());
}

TEST(Solids, ASurfaceSplitsWhereItIsStretchedAndIsRestoredOnRelease) {
    scene::Scene scene = fixture::rubber_scene();
    scene.surface.enabled = true;
    scene.bodies = {fixture::body("block", fixture::shape_at({0.2, 0, 0}, scene::BoxShape{{0.04, 0.04, 0.1}, 0}))};
    scene.bodies[0].surfels = 800;
    Simulation s = make_simulation(scene);
    refresh_surface(s);
    const SurfaceState rest = s.surface;
    ASSERT_EQ(rest.size(), 800u);
    auto& u = s.solids.elements.displacement;
    const auto stretch = [&](Real by) {
        for (std::size_t i = 0; i < u.size(); ++i) u[i] = {0, 0, by * s.solids.elements.rest[i].z, 0};
        refresh_surface(s);
    };
    stretch(2);
    EXPECT_GT(s.surface.size(), 1300u);  // on the four long sides; a disc three times as long becomes at least two
    std::set<std::int64_t> ids(s.surface.id.begin(), s.surface.id.end());
    EXPECT_EQ(ids.size(), s.surface.size());
    Real longest = 0;
    for (std::size_t i = 0; i < s.surface.size(); ++i)
        longest =
            std::max(longest, s.surface.surfels.axis1[i].norm() / rest.surfels.axis1[s.embedded_source[i]].norm());
    EXPECT_LT(square(longest), kSplitStretch * 1.0001f);
    stretch(0);
    EXPECT_EQ(s.surface.id, rest.id);
    EXPECT_EQ(s.surface.surfels.position, rest.surfels.position);
    EXPECT_EQ(s.surface.surfels.axis1, rest.surfels.axis1);
}

TEST(Solids, BadScenesAreRefusedWithAReason) {
    const auto message = [](const scene::Scene& scene) {
        try {
            make_simulation(scene);
        } catch (const InputError& e) {
            return std::string(e.what());
        }
        return std::string();
    };
    scene::Scene scene = busy();
    scene.handles[0].region = fixture::shape_at({0, 0, 5}, scene::Sphere{0.1});
    EXPECT_NE(message(scene).find("handle 'hand' holds no particle of body 'block'"), std::string::npos);
    scene = busy();
    scene.bodies[0].shape.translate.z() = -0.05;
    EXPECT_NE(message(scene).find("body 'block' starts inside a wall"), std::string::npos);
    scene = busy();
    scene.bodies[0].shape = fixture::shape_at({0, 0, 0}, scene::Sphere{0.001});
    EXPECT_NE(message(scene).find("holds no particle"), std::string::npos);
}

}  // namespace
}  // namespace thixo
