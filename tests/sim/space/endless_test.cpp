#include "sim/space/endless.h"

#include <gtest/gtest.h>

#include "pipeline/base/error.h"
#include "sim/solid/elasticity.h"
#include "sim/solid/laws.h"
#include "tests/sim/fixture.h"

namespace thixo {
namespace {

constexpr double kHalf = 0.04;  // of the period along y [m]

/// A bar of rubber without ends along y.
scene::Scene endless_bar(scene::Shape shape) {
    scene::Scene s = fixture::empty_space();
    s.world.periodic = {{scene::Axis::y, -kHalf, kHalf}};
    s.materials[0].elastic.youngs_modulus = 1e5;
    s.materials[0].elastic.poisson_ratio = 0.3;
    s.bodies = {fixture::body("bar", std::move(shape))};
    return s;
}
scene::Scene endless_box() {
    return endless_bar(fixture::shape_at({0, 0, 0}, scene::BoxShape{{0.06, 2 * kHalf, 0.05}, 0}));
}

/// One sub-step, so that laws are there.
Simulation prepared(const scene::Scene& scene) {
    Simulation s = make_simulation(scene);
    advance_frame(s);
    return s;
}

std::vector<Vec3> forces_of(Simulation& s) {
    StressScratch scratch;
    std::vector<Vec3> force;
    find_stress_forces(s.solids.laws, s.solids.elements, scratch, force);
    return force;
}

TEST(EndlessBody, HasNoEndsAtPeriodicFaces) {
    // Elements of one row along y see the same neighbourhoods. Rounding: 40 terms in single precision.
    const Simulation s = make_simulation(endless_box());
    const Elements& e = s.solids.elements;
    int compared = 0;
    for (std::size_t i = 0; i < e.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) {
            const Vec3 apart = xyz(e.rest[i]) - xyz(e.rest[j]);
            if (std::hypot(apart.x(), apart.z()) > 1e-6) continue;
            ++compared;
            EXPECT_NEAR(e.bonds.moment[i].trace, e.bonds.moment[j].trace, 1e-5 * e.bonds.moment[i].trace);
            EXPECT_NEAR(e.quadrature[i], e.quadrature[j], 1e-3 * e.quadrature[i]);
            EXPECT_NEAR(e.depth[i], e.depth[j], 1e-6);
        }
    EXPECT_GT(compared, 100);
}

TEST(EndlessBody, HasForcesWithoutSumAcrossFaces) {
    Simulation s = prepared(endless_box());
    Elements& e = s.solids.elements;
    for (std::size_t i = 0; i < e.size(); ++i) {
        const Vec3 m = xyz(e.rest[i]) / Real(0.04);
        e.displacement[i] =
            quad(Vec3(Real(1e-3) * Vec3(std::sin(3 * m.y() + m.z()), std::cos(2 * m.x()), m.z() * m.y())));
    }
    Vec3d sum(0, 0, 0);
    double size = 0;
    for (const Vec3& f : forces_of(s)) {
        sum += f.cast<double>();
        size += static_cast<double>(f.norm());
    }
    EXPECT_GT(size, 0.1);
    EXPECT_LT(sum.norm(), 1e-5 * size);
}

TEST(EndlessBody, InUniformShearAlongItsFacesHasNoForcesAtThem) {
    // u_y = 0.01 x and u_z = 0: the same at every y. Forces act at the free faces alone, the same all along.
    Simulation s = prepared(endless_box());
    Elements& e = s.solids.elements;
    for (std::size_t i = 0; i < e.size(); ++i) e.displacement[i] = quad(Vec3(0, Real(0.01) * e.rest[i].x, 0));
    const std::vector<Vec3> force = forces_of(s);
    double largest = 0;
    for (const Vec3& f : force) largest = std::max(largest, static_cast<double>(f.norm()));
    EXPECT_GT(largest, 0);
    for (std::size_t i = 0; i < e.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) {
            const Vec3 apart = xyz(e.rest[i]) - xyz(e.rest[j]);
            if (std::hypot(apart.x(), apart.z()) > 1e-6) continue;
            EXPECT_LT((force[i] - force[j]).norm(), 1e-3 * largest);
        }
}

TEST(EndlessBody, FallsThroughItsOwnFaces) {
    scene::Scene scene = endless_box();
    scene.world.gravity = {0, -10, 0};
    scene.frames = {0, 6, 24};  // 0.3 m: almost four periods
    Simulation s = make_simulation(scene);
    while (s.clock.frame < scene.frames.last) advance_frame(s);
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        EXPECT_NEAR(s.particles.velocity[i].y(), -10 * s.clock.time, 1e-3);
        EXPECT_GE(s.particles.position[i].y(), Real(-kHalf));
        EXPECT_LT(s.particles.position[i].y(), Real(kHalf));
    }
    for (const Quad& u : s.solids.elements.displacement) EXPECT_LT(xyz(u).norm(), 1e-6);
}

TEST(EndlessBody, LiesOnAFloorAlsoWhereItHasSlidAcrossAFace) {
    // The floor ends just beyond the faces. What has left through the one face lies on it at the other.
    scene::Scene scene = endless_box();
    scene.world.gravity = {0, 0, -10};
    scene::Boundary floor;
    floor.name = "floor";
    floor.shape = fixture::shape_at({0, 0, -0.075}, scene::BoxShape{{1, 2 * kHalf + 0.02, 0.1}, 0});
    scene.world.boundaries = {floor};
    scene.materials[0].viscosity = 20;
    scene.materials[0].elastic.friction = 0;
    scene.bodies[0].velocity = {0, 0.2, 0};
    scene.frames = {0, 24, 24};  // 0.2 m: two periods and a half
    Simulation s = make_simulation(scene);
    while (s.clock.frame < scene.frames.last) advance_frame(s);
    const Elements& e = s.solids.elements;
    for (std::size_t i = 0; i < e.size(); ++i) {
        EXPECT_NEAR(e.velocity[i].y, 0.2, 1e-4);
        EXPECT_LT(std::hypot(e.velocity[i].x, e.velocity[i].z), 1e-3);
        EXPECT_LT(std::abs(e.displacement[i].z), 1e-3);
    }
}

TEST(EndlessBody, HasTheMassOfItsPrismWhereItEndsJustBeforeTheFaces) {
    const auto mass = [](double length) {
        const Simulation s =
            make_simulation(endless_bar(fixture::shape_at({0, 0, 0}, scene::BoxShape{{0.06, length, 0.05}, 0})));
        double sum = 0;
        for (const Real m : s.particles.mass) sum += static_cast<double>(m);
        return sum;
    };
    EXPECT_NEAR(mass(2 * kHalf), 1000 * 0.06 * 0.05 * 2 * kHalf, 1e-4);
    EXPECT_NEAR(mass(2 * kHalf - 0.004), mass(2 * kHalf), 1e-4);
}

TEST(EndlessBody, MustGoOnFromFaceToFaceWithOneSection) {
    const auto refused = [](scene::Shape shape) {
        EXPECT_THROW(
            {
                try {
                    make_simulation(endless_bar(std::move(shape)));
                } catch (const InputError& error) {
                    EXPECT_NE(std::string(error.what()).find("does not go on from face to face"), std::string::npos);
                    throw;
                }
            },
            InputError);
    };
    refused(fixture::shape_at({0, 0, 0}, scene::Sphere{0.03}));
    refused(fixture::shape_at({0, 0, 0}, scene::BoxShape{{0.06, 0.06, 0.05}, 0}));  // ends before the faces
    scene::Shape slanted = fixture::shape_at({0, 0, 0}, scene::BoxShape{{0.03, 0.076, 0.05}, 0});
    slanted.rotate = {0, 0, 10};
    refused(slanted);
}

TEST(EndlessBody, FloatsAsItsDensityHasIt) {
    // A log of half the density of water, all along the tank. Its middle lies at the level, to a quarter of the spacing.
    scene::Scene scene = fixture::empty_space();
    scene.world.gravity = {0, 0, -9.81};
    scene.world.periodic = {{scene::Axis::y, -kHalf, kHalf}};
    scene::Boundary walls;
    walls.name = "tank";
    walls.inside = true;
    walls.shape = fixture::shape_at({0, 0, 0.1}, scene::BoxShape{{0.2, 1, 0.2}, 0});
    scene.world.boundaries = {walls};
    scene::Material wood;
    wood.name = "wood";
    wood.density = 500;
    wood.elastic.youngs_modulus = 1e5;
    wood.viscosity = 10;
    scene.materials.push_back(wood);
    scene.bodies = {fixture::body("log", fixture::shape_at({0, 0, 0.105}, scene::BoxShape{{0.08, 2 * kHalf, 0.05}, 0})),
                    fixture::body("pool", fixture::shape_at({0, 0, 0.04}, scene::BoxShape{{0.2, 2 * kHalf, 0.08}, 0}))};
    scene.bodies[0].material = "wood";
    scene.frames = {0, 36, 24};
    Simulation s = make_simulation(scene);
    double middle = 0;
    int frames = 0;
    while (s.clock.frame < scene.frames.last) {
        advance_frame(s);
        if (s.clock.frame < 18) continue;
        middle += s.solids.bodies[0].place.z();
        ++frames;
    }
    double water = 0;  // [kg]; along a periodic axis the packing is not scaled to the shape's volume
    for (std::size_t i = 0; i < s.particles.size(); ++i)
        if (s.particles.body[i] == 1) water += static_cast<double>(s.particles.mass[i]);
    const double log = 0.08 * 0.05 * 2 * kHalf, level = (water / 1000 + log / 2) / (0.2 * 2 * kHalf);
    EXPECT_NEAR(middle / frames, level, 0.0025);
}

}  // namespace
}  // namespace thixo
