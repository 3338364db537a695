#include "pipeline/geometry/surface_sampling.h"

#include <gtest/gtest.h>

#include <chrono>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/geometry/face_tree.h"
#include "pipeline/geometry/mesh_repair.h"
#include "pipeline/geometry/point_grid.h"
#include "tests/pipeline/geometry/exact_surfaces.h"

namespace thixo {
namespace {

class SampledBody : public testing::TestWithParam<int> {
  protected:
    exact::Body body = exact::bodies()[std::size_t(GetParam())];
};

TEST_P(SampledBody, HasASheetForEveryFaceAndTheCountAskedFor) {
    for (const std::size_t count : {1500u, 4000u}) {
        const SampledSurface s = sample_surface(body.shape, {.count = count});
        EXPECT_EQ(s.sheets, body.sheets);
        EXPECT_EQ(s.trim.has_value(), body.sheets > 1);
        // Guides, which no part of the surface needs but trimming does, come on top.
        EXPECT_GE(s.surfels.size(), count);
        EXPECT_LE(s.surfels.size(), count + count / 50);
        EXPECT_TRUE(std::is_sorted(s.sheet.begin(), s.sheet.end()));
    }
}

TEST_P(SampledBody, SurfelsLieOnTheirFacesWithTheirNormals) {
    const SampledSurface s = sample_surface(body.shape, {.count = 4000});
    FaceTree tree = without_differences(faces_of(body.shape));
    const std::vector<Shape> faces = number_faces(tree);
    std::vector<std::size_t> face_of;  // of a sheet: the face on which its first surfels lie
    for (std::size_t i = 0; i < s.surfels.size(); ++i) {
        const bool first = i == 0 || s.sheet[i] != s.sheet[i - 1];
        const auto fits = [&](const Shape& face) {
            return std::abs(face.distance(s.surfels.position[i])) + std::abs(face.distance(s.surfels.position[i + 1])) +
                           std::abs(face.distance(s.surfels.position[i + 2])) <
                       Real(3e-3 * s.spacing) &&
                   face.gradient(s.surfels.position[i], Real(0.05 * s.spacing)).dot(s.surfels.normal[i]) > 0.99;
        };
        if (first) face_of.push_back(std::size_t(std::find_if(faces.begin(), faces.end(), fits) - faces.begin()));
        ASSERT_LT(face_of.back(), faces.size());
        const Shape& face = faces[face_of.back()];
        // The tip of a cone has no normal.
        if (body.name == "cup" && s.surfels.position[i].head<2>().norm() < Real(0.3 * s.spacing)) continue;
        // A thousandth of the spacing: what a ray through the blend can tell.
        ASSERT_LT(std::abs(face.distance(s.surfels.position[i])), 1e-3 * s.spacing);
        ASSERT_NEAR(s.surfels.normal[i].norm(), 1, 1e-5);
        ASSERT_GT(s.surfels.normal[i].dot(face.gradient(s.surfels.position[i], Real(0.05 * s.spacing))), 0.9999);
        // Discs are round, in the tangent plane, right-handed.
        const Vec3 n = s.surfels.axis1[i].cross(s.surfels.axis2[i]);
        ASSERT_GT(n.normalized().dot(s.surfels.normal[i]), 0.9999);
    }
}

TEST_P(SampledBody, EveryPointOfTheSurfaceIsUnderADiscOfItsFace) {
    for (const std::size_t count : {1500u, 6000u}) {
        const SampledSurface s = sample_surface(body.shape, {.count = count});
        PointGrid grid;
        const Real cell = Real(2 * s.spacing);
        grid.build(s.surfels.position, cell);
        std::size_t tested = 0, bare = 0;
        for (std::size_t patch = 0; patch < body.patches.size(); ++patch)
            for (std::size_t i = 0; i < 20000 / body.patches.size(); ++i) {
                const exact::SurfacePoint p = exact::random_point(body, patch, i);
                if (!body.on_surface(p)) continue;
                ++tested;
                bool covered = false;
                grid.for_each_neighbour(p.position.cast<Real>(), cell, [&](Index j, Real r2) {
                    covered |= r2 < s.surfels.axis1[j].squaredNorm() &&
                               double(s.surfels.normal[j].cast<double>().dot(p.normal)) > 0.7;
                });
                bare += !covered;
            }
        EXPECT_GT(tested, 1000u);
        EXPECT_EQ(bare, 0u) << "of " << tested;
    }
}

TEST_P(SampledBody, SurfelsAreEvenlySpread) {
    // Distance to the nearest of the same sheet: the hexagonal lattice has 1.07 spacings, random points 0.5 on average.
    const SampledSurface s = sample_surface(body.shape, {.count = 4000});
    PointGrid grid;
    grid.build(s.surfels.position, Real(2 * s.spacing));
    double sum = 0, least = 1e9;
    for (std::size_t i = 0; i < s.surfels.size(); ++i) {
        Real best = Real(4 * s.spacing * s.spacing);
        grid.for_each_neighbour(s.surfels.position[i], Real(2 * s.spacing), [&](Index j, Real r2) {
            if (j != i && s.sheet[i] == s.sheet[j] && s.surfels.normal[i].dot(s.surfels.normal[j]) > 0)
                best = std::min(best, r2);
        });
        sum += std::sqrt(double(best)) / s.spacing;
        least = std::min(least, std::sqrt(double(best)) / s.spacing);
    }
    EXPECT_GT(sum / double(s.surfels.size()), 0.80);
    EXPECT_GT(least, 0.3);
}

TEST_P(SampledBody, TheTreeTellsTheSolid) {
    FaceTree tree = without_differences(faces_of(body.shape));
    const std::vector<Shape> faces = number_faces(tree);
    for (int k = 0; k < 20000; ++k) {
        const Vec3d x = 1.8 * (Vec3d(random_unit(5, k, 0, 0), random_unit(5, k, 0, 1), random_unit(5, k, 0, 2)) -
                               Vec3d::Constant(0.5));
        if (std::abs(body.solid(x)) < 1e-5) continue;
        const bool inside = evaluate(tree, [&](int f) { return faces[std::size_t(f)].distance(x.cast<Real>()) < 0; });
        ASSERT_EQ(inside, body.solid(x) < 0) << x.transpose();
    }
}

INSTANTIATE_TEST_SUITE_P(Bodies, SampledBody, testing::Range(0, int(exact::bodies().size())),
                         [](const auto& info) { return exact::bodies()[std::size_t(info.param)].name; });

/// A block 1 x 1 x 0.5 whose top goes on to x = 0.6, back to 0.4 and on again, as scanned meshes have it.
TriangleMesh folded_block() {
    TriangleMesh m;
    const float outline[6][2] = {{0, 0}, {1, 0}, {1, 0.5f}, {0.4f, 0.5f}, {0.6f, 0.5f}, {0, 0.5f}};
    for (const float y : {0.0f, 1.0f})
        for (const auto& [x, z] : outline) m.vertices.push_back({x, y, z});
    for (Index k = 0; k < 6; ++k) {
        const Index next = (k + 1) % 6;
        m.triangles.push_back({k, next, next + 6});
        m.triangles.push_back({k, next + 6, k + 6});
        if (k == 0 || k == 5) continue;
        m.triangles.push_back({0, next, k});
        m.triangles.push_back({6, k + 6, next + 6});
    }
    for (auto& t : m.triangles) std::swap(t[1], t[2]);
    return m;
}

TEST(SampleSurface, NormalsPointOutWhereAMeshIsFoldedOntoItself) {
    const TriangleMesh mesh = folded_block();
    ASSERT_TRUE(inspect_mesh(mesh).closed);
    ASSERT_NEAR(std::abs(inspect_mesh(mesh).volume), 0.5, 1e-6);
    const SampledSurface s = sample_surface(mesh_shape(mesh), {.count = 2000});
    std::size_t on_top = 0;
    for (std::size_t i = 0; i < s.surfels.size(); ++i) {
        const Vec3& x = s.surfels.position[i];
        if (x.z() < Real(0.499) || (x - Vec3(0.5f, 0.5f, 0.5f)).cwiseAbs().maxCoeff() > Real(0.45)) continue;
        ++on_top;
        EXPECT_GT(s.surfels.normal[i].z(), 0.9) << x.transpose();
    }
    EXPECT_GT(on_top, 300u);
}

TEST(SampleSurface, IsTheSameAtAnyThreadCountAndForEqualCalls) {
    const exact::Body body = exact::cut_cube();
    const SampledSurface a = sample_surface(body.shape, {.count = 2000});
    const SampledSurface b = sample_surface(body.shape, {.count = 2000});
    ASSERT_EQ(a.surfels.size(), b.surfels.size());
    for (std::size_t i = 0; i < a.surfels.size(); ++i) {
        ASSERT_EQ(a.surfels.position[i], b.surfels.position[i]);
        ASSERT_EQ(a.surfels.axis1[i], b.surfels.axis1[i]);
    }
}

TEST(SampleSurface, AreaIsThatOfTheBody) {
    // Random points: about one in the root of their number, 50 000, and a tenth of the curvature's square.
    EXPECT_NEAR(sample_surface(sphere(0.5), {.count = 5000}).area / kPi, 1, 0.01);
    EXPECT_NEAR(sample_surface(box({1, 2, 0.5}), {.count = 5000}).area / 7, 1, 0.01);
}

TEST(SampleSurface, SpacingGivesTheCount) {
    const SampledSurface s = sample_surface(sphere(0.5), {.spacing = 0.03});
    EXPECT_NEAR(double(s.surfels.size()) * 0.03 * 0.03 / kPi, 1, 0.02);
}

TEST(SampleSurface, RefusesAPlateThatIsTooThinForItsSurfelsAtOnce) {
    const auto seconds_of = [](auto&& f) {
        const auto start = std::chrono::steady_clock::now();
        f();
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    };
    const Shape plate = box({0.2, 0.2, 1e-5}), thick = roughened(box({0.2, 0.2, 0.01}), 1e-6, 0.1, 3);
    const double sampled = seconds_of([&] { sample_surface(thick, {.spacing = 0.005}); });
    const std::pair<const char*, Shape> thin[] = {
        {"plate", plate},
        {"large plate", box({2, 2, 1e-5})},  // its rims alone would have surfels
        {"disc", cylinder(0.1, 1e-5)},
        {"stack", repeated(plate, 5, {0, 0, 0.02}, 0)},
        {"hull", difference_of({box({0.2, 0.2, 0.2}), box({0.19999, 0.19999, 0.19999})})},
        {"rough plate", roughened(plate, 1e-6, 0.1, 3)}};
    for (const auto& [name, shape] : thin)
        for (const SurfaceSampling& sampling : {SurfaceSampling{.spacing = 0.005}, SurfaceSampling{.count = 2000}}) {
            const double took = seconds_of([&] {
                try {
                    sample_surface(shape, sampling);
                    ADD_FAILURE() << name << " has surfels";
                } catch (const InputError& error) {
                    EXPECT_NE(std::string(error.what()).find("too thin"), std::string::npos) << name << error.what();
                }
            });
            EXPECT_LT(took, 10 * sampled) << name;  // a thick one; it was eighty times as long for the rough plate
        }
    // Thicker plates, and what only seems thin: faces that coincide leave nothing between them.
    EXPECT_NO_THROW(sample_surface(box({0.2, 0.2, 0.001}), {.spacing = 0.005}));
    EXPECT_NO_THROW(sample_surface(box({0.2, 0.2, 0.001}), {.count = 2000}));
    EXPECT_NO_THROW(sample_surface(
        difference_of({box({0.2, 0.2, 0.2}), translated(box({0.2, 0.2, 0.18}), {0, 0, 0.01})}), {.spacing = 0.005}));
}

TEST(SampleSurface, RefusesWhatCannotBeSampled) {
    EXPECT_THROW(sample_surface(sphere(1), {}), InputError);
    EXPECT_THROW(sample_surface(sphere(1), {.count = 10, .spacing = 0.1}), InputError);
    EXPECT_THROW(sample_surface(plane({0, 0, 1}, 0), {.count = 10}), InputError);
    EXPECT_THROW(sample_surface(intersection_of({sphere(0.1), translated(sphere(0.1), {1, 0, 0})}), {.count = 100}),
                 InputError);
    EXPECT_THROW(sample_surface(sphere(1), {.spacing = 1e-9}), InputError);
}

}  // namespace
}  // namespace thixo
