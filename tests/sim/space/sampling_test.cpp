#include "sim/space/sampling.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "pipeline/base/error.h"
#include "pipeline/geometry/match_moments.h"
#include "pipeline/geometry/mesh_io.h"
#include "pipeline/geometry/mesh_repair.h"
#include "pipeline/geometry/shapes.h"
#include "pipeline/geometry/tessellate.h"
#include "sim/space/scene_shapes.h"
#include "tests/sim/fixture.h"

namespace thixo {
namespace {

const auto anywhere = [](const Vec3&) { return true; };

TEST(Sampling, PackingHoldsOneParticlePerSpacingCubed) {
    // The sites of a packing are counted in a ball of 20 spacings. A surface layer of one spacing bounds the error:
    // 3/20 of the volume in the worst case. Its sign varies along the surface, so that 1 % is generous.
    const double count = static_cast<double>(pack_shape(sphere(20), 1, anywhere).size());
    EXPECT_NEAR(count, 4.0 / 3.0 * kPi * 8000, 0.01 * 4.0 / 3.0 * kPi * 8000);
}

TEST(Sampling, NearestNeighboursStandTwelveAtOneDistance) {
    const std::vector<Vec3> sites = pack_shape(sphere(4), 1, anywhere);
    const Vec3 centre =
        *std::min_element(sites.begin(), sites.end(), [](const Vec3& a, const Vec3& b) { return a.norm() < b.norm(); });
    int touching = 0;
    for (const Vec3& x : sites) {
        const Real r = (x - centre).norm();
        EXPECT_TRUE(r == 0 || r > packing_distance(1) * Real(0.999)) << r;
        if (r > 0 && r < packing_distance(1) * Real(1.001)) ++touching;
    }
    EXPECT_EQ(touching, 12);
}

TEST(Sampling, PackedInteriorHasTheRestDensity) {
    // The kernel is calibrated on the packing. The volume of the block is summed over cells, to 1e-4.
    for (const double support : {1.6, 2.0, 2.7}) {
        scene::Scene scene = fixture::empty_space();
        scene.solver.support = support;
        const Vec3d size = 16 * packing_steps(Real(0.01));  // of whole rows: the packing is not stretched
        scene.bodies = {fixture::body("block", fixture::shape_at({0, 0, 0}, scene::BoxShape{size, 0}))};
        Simulation s = make_simulation(scene);
        evaluate(s);
        const Shape inner = box(size - Vec3d::Constant(2 * (support + 0.1) * 0.01));
        double sum = 0, count = 0;
        for (std::size_t i = 0; i < s.particles.size(); ++i)
            if (inner.distance(s.particles.position[i]) < 0) {
                sum += s.particles.density[i];
                ++count;
            }
        ASSERT_GT(count, 100);
        EXPECT_NEAR(sum / count, 1000, 0.1) << support;
    }
}

TEST(Sampling, KernelsGiveAPackingItsGradientAndLaplacian) {
    // A linear and a quadratic field in x are summed as forces are, over all neighbours of a site within the packing.
    // The tolerance of 1e-5 is rounding of float.
    const Smoothing smoothing(1, 2);
    Vec3d gradient(0, 0, 0);
    double laplacian = 0;
    for (const Vec3& x : pack_shape(sphere(4), 1, anywhere)) {
        // Sites of pack_shape are centred about a box, not a site: shift to the one nearest the centre.
        static const Vec3 centre = [] {
            const auto sites = pack_shape(sphere(4), 1, anywhere);
            return *std::min_element(sites.begin(), sites.end(),
                                     [](const Vec3& a, const Vec3& b) { return a.norm() < b.norm(); });
        }();
        const Vec3 r = centre - x;  // x_i - x_j
        const Real length = r.norm();
        if (length == 0) continue;
        gradient += (3 * r.z() * -1 * smoothing.pressure.derivative(length) / length * r)
                        .cast<double>();                                                          // A_j = 3 (z_j - z_i)
        laplacian += static_cast<double>(square(r.x()) * smoothing.viscosity.laplacian(length));  // A_j = (x_j - x_i)^2
    }
    // The mean over directions is exact. Along z alone the packing differs by the pair of sites two layers off, a
    // hundredth of the sum.
    EXPECT_LT((gradient - Vec3d(0, 0, 3)).norm(), 0.02 * 3);
    EXPECT_NEAR(laplacian, 2, 0.02 * 2);
}

/// Shapes whose lattice does not fit: a ball, a slab, a bar across the axes, a hollow.
std::vector<scene::Shape> shapes_of_all_kinds() {
    scene::Shape bar = fixture::shape_at({0, 0, 0}, scene::BoxShape{{0.3, 0.07, 0.05}, 0});
    bar.rotate = {20, 30, 50};
    scene::Shape hollow = fixture::shape_at({0, 0, 0}, scene::Sphere{0.1});
    hollow.shell = 0.035;
    return {fixture::shape_at({0.3, 0, 0}, scene::Sphere{0.1}),
            fixture::shape_at({0, 0, 0}, scene::BoxShape{{0.3, 0.2, 0.046}, 0}),
            fixture::shape_at({0, 0.1, 0}, scene::Cylinder{0.08, 0.113, 0}), bar, hollow};
}

TEST(Sampling, ABodyHasTheMassOfItsShape) {
    for (const scene::Shape& shape : shapes_of_all_kinds())
        for (const double spacing : {0.01, 0.0083, 0.0071}) {
            scene::Scene scene = fixture::empty_space();
            scene.solver.spacing = spacing;
            scene.bodies = {fixture::body("body", shape)};
            const double right = 1000 * volume(make_shape(scene, shape), 0.001);
            double mass = 0;
            for (const Real m : make_simulation(scene).particles.mass) mass += static_cast<double>(m);
            EXPECT_NEAR(mass / right, 1, 2e-3) << spacing;
        }
}

TEST(Sampling, ASolidHasTheMassAndInertiaOfItsShape) {
    for (const scene::Shape& shape : shapes_of_all_kinds())
        for (const scene::Lattice lattice : {scene::Lattice::hexagonal, scene::Lattice::octree}) {
            scene::Scene scene = fixture::empty_space();
            scene.solver.spacing = 0.0083;
            scene.materials[0].elastic.youngs_modulus = 1e5;
            scene.bodies = {fixture::body("body", shape)};
            scene.bodies[0].sampling.lattice = lattice;
            const ShapeMoments whole = moments(make_shape(scene, shape), 0.001);
            const Vec3d centre = whole.first / whole.volume;
            const ShapeMoments right = moments_about(centre, whole);
            const Simulation s = make_simulation(scene);
            ShapeMoments sum;
            for (std::size_t i = 0; i < s.particles.size(); ++i) {
                const Vec3d x = s.particles.position[i].cast<double>() - centre;
                const double m = static_cast<double>(s.particles.mass[i]);
                sum += {m, m * x, m * x * x.transpose()};
            }
            EXPECT_NEAR(sum.volume / (1000 * right.volume), 1, 2e-3);
            EXPECT_LT(sum.first.norm(), 1e-4 * sum.volume * 0.0083);
            EXPECT_LT((sum.second - 1000 * right.second).norm(), 5e-3 * 1000 * right.second.norm());
        }
}

TEST(Sampling, ASolidIsSampledAlikeHoweverItIsTurned) {
    const auto places = [](const Vec3d& turn) {
        scene::Scene scene = fixture::empty_space();
        scene.materials[0].elastic.youngs_modulus = 1e5;
        scene::Shape bar = fixture::shape_at({0.1, 0, 0}, scene::BoxShape{{0.3, 0.04, 0.07}, 0});
        bar.rotate = turn;
        scene.bodies = {fixture::body("bar", bar)};
        std::vector<double> out;
        for (const Vec3& x : make_simulation(scene).particles.position)
            out.push_back(static_cast<double>((x - Vec3(Real(0.1), 0, 0)).norm()));
        std::ranges::sort(out);
        return out;
    };
    const auto straight = places({0, 0, 0}), turned = places({20, 30, 50});
    ASSERT_EQ(straight.size(), turned.size());
    for (std::size_t k = 0; k < straight.size(); ++k) EXPECT_NEAR(straight[k], turned[k], 1e-6);
}

TEST(Sampling, ASolidOfOneLayerHasItInTheMiddle) {
    for (const int thin : {0, 1, 2}) {
        scene::Scene scene = fixture::empty_space();
        scene.materials[0].elastic.youngs_modulus = 1e5;
        Vec3d size(0.1, 0.1, 0.1);
        size[thin] = 0.01;
        scene.bodies = {fixture::body("plate", fixture::shape_at({0, 0, 0}, scene::BoxShape{size, 0}))};
        const Simulation s = make_simulation(scene);
        EXPECT_GT(s.particles.size(), 80u);
        for (const Vec3& x : s.particles.position) EXPECT_NEAR(x[thin], 0, 1e-6);
    }
}

TEST(Sampling, RefusesAShapeWithoutBounds) { EXPECT_THROW(pack_shape(plane({0, 0, 1}, 0), 1, anywhere), InputError); }

TEST(Sampling, BodiesDoNotOverlap) {
    scene::Scene scene = fixture::empty_space();
    scene.bodies = {fixture::body("first", fixture::shape_at({0, 0, 0}, scene::Sphere{0.05})),
                    fixture::body("second", fixture::shape_at({0.04, 0, 0}, scene::Sphere{0.05}))};
    const Simulation s = make_simulation(scene);
    const auto& x = s.particles.position;
    for (std::size_t i = 0; i < x.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) ASSERT_GT((x[i] - x[j]).norm(), 0.0069);  // 0.7 spacings
}

TEST(SceneShapes, APlacedMeshStandsAtTheOriginWithItsHeight) {
    TriangleMesh mesh = tessellate(box({2, 4, 8}), 0.1);
    transform_mesh(mesh, 1, Quatd::Identity(), {10, 20, 30});
    const std::string file = testing::TempDir() + "placed.ply";
    std::ofstream(file, std::ios::binary) << write_ply(mesh);
    const auto bounds = [&](scene::Place place) {
        scene::MeshFile kind;
        kind.file = file;
        kind.height = 0.5;
        kind.place = place;
        scene::Shape shape;
        shape.kind = kind;
        return *make_shape({}, shape).bounds();
    };
    const auto near = [](const Vec3& a, const Vec3d& b) { return (a.cast<double>() - b).norm() < 1e-5; };
    EXPECT_TRUE(near(bounds(scene::Place::base).lower, {-0.0625, -0.125, 0}));
    EXPECT_TRUE(near(bounds(scene::Place::base).upper, {0.0625, 0.125, 0.5}));
    EXPECT_TRUE(near(bounds(scene::Place::centre).upper, {0.0625, 0.125, 0.25}));
    EXPECT_TRUE(near(bounds(scene::Place::file).lower, {9.0 / 16, 18.0 / 16, 26.0 / 16}));
}

TEST(SceneShapes, AFileOfPointsWithNormalsIsAShape) {
    TriangleMesh points;
    for (int i = 0; i < 2000; ++i) {  // even on the unit sphere (Fibonacci)
        const double z = 1 - (2.0 * i + 1) / 2000, phi = i * kPi * (3 - std::sqrt(5.0)), r = std::sqrt(1 - z * z);
        points.vertices.push_back(Vec3d(r * std::cos(phi), r * std::sin(phi), z).cast<float>());
    }
    points.normals = points.vertices;
    const std::string file = testing::TempDir() + "points.ply";
    std::ofstream(file, std::ios::binary) << write_ply(points);
    scene::MeshFile kind;
    kind.file = file;
    kind.scale = 0.5;
    scene::Shape shape;
    shape.kind = kind;
    EXPECT_NEAR(make_shape({}, shape).distance(Vec3(0, 0, Real(0.1))), -0.4, 0.01);
    points.normals.clear();
    std::ofstream(file, std::ios::binary) << write_ply(points);
    EXPECT_THROW(make_shape({}, shape), InputError);
}

}  // namespace
}  // namespace thixo
