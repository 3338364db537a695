#include "pipeline/geometry/volume_sampling.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "pipeline/base/error.h"
#include "pipeline/geometry/point_grid.h"
#include "pipeline/geometry/shapes.h"

namespace thixo {
namespace {

double sum_of(const SampledVolume& v) {
    return std::accumulate(v.volume.begin(), v.volume.end(), 0.0, [](double a, Real b) { return a + double(b); });
}

TEST(SampleVolume, VolumesAddUpToTheBody) {
    // Partly filled cells are second order: at 12 cells across about 1e-3.
    for (const Lattice lattice : {Lattice::octree, Lattice::hexagonal, Lattice::uniform}) {
        const SampledVolume ball = sample_volume(sphere(0.5), {.lattice = lattice, .spacing = 0.04});
        EXPECT_NEAR(ball.total / (kPi / 6), 1, 2e-3);
        EXPECT_NEAR(sum_of(ball) / ball.total, 1, 1e-5);
        const SampledVolume ring = sample_volume(torus(0.5, 0.2), {.lattice = lattice, .spacing = 0.03});
        EXPECT_NEAR(ring.total / (2 * kPi * kPi * 0.5 * 0.04), 1, 2e-3);
        EXPECT_NEAR(sum_of(ring) / ring.total, 1, 1e-5);
    }
}

TEST(SampleVolume, ABoxOfWholeCellsIsTheLattice) {
    const SampledVolume v = sample_volume(box({1, 0.5, 0.3}), {.lattice = Lattice::uniform, .spacing = 0.1});
    ASSERT_EQ(v.position.size(), 150u);
    for (std::size_t i = 0; i < 150; ++i) {
        EXPECT_NEAR(v.volume[i], 1e-3, 1e-6);
        for (int a = 0; a < 3; ++a) {
            const double half = a == 0 ? 0.5 : a == 1 ? 0.25 : 0.15, cell = (v.position[i][a] + half) / 0.1 - 0.5;
            EXPECT_NEAR(cell, std::round(cell), 1e-4);
        }
    }
}

TEST(SampleVolume, ParticlesAreInside) {
    const Shape ring = difference_of({torus(0.5, 0.2), box({0.5, 2, 0.1})});
    for (const Lattice lattice : {Lattice::octree, Lattice::hexagonal, Lattice::uniform})
        for (const Vec3& x : sample_volume(ring, {.lattice = lattice, .spacing = 0.03}).position)
            ASSERT_LT(ring.distance(x), 0);
}

/// Cells of the octree as boxes: each contains its centre.
TEST(SampleVolume, OctreeIsFinestAtTheSurfaceAndBalanced) {
    const Shape ball = sphere(0.5);
    const SampledVolume v = sample_volume(ball, {.spacing = 0.02, .levels = 3});
    PointGrid grid;
    grid.build(v.position, Real(0.25));
    std::size_t wide = 0;
    for (std::size_t i = 0; i < v.position.size(); ++i) {
        const double edge = v.spacing[i], level = std::log2(edge / 0.02);
        EXPECT_NEAR(level, std::round(level), 1e-4);
        wide += level > 1.5;
        // A cell that the surface passes is of the finest.
        if (std::abs(double(ball.distance(v.position[i]))) < 0.5 * edge) {
            EXPECT_NEAR(edge, 0.02, 1e-6);
        }
        grid.for_each_neighbour(v.position[i], Real(0.25), [&](Index j, Real) {
            const Vec3 apart = (v.position[j] - v.position[i]).cwiseAbs();
            const double reach = 0.5 * (edge + double(v.spacing[j]));
            if (double(apart.maxCoeff()) > reach * 1.001) return;  // not side by side
            EXPECT_LT(std::max(edge, double(v.spacing[j])) / std::min(edge, double(v.spacing[j])), 2.01);
            // Leaves do not overlap.
            if (j != i) {
                EXPECT_GT(double(apart.maxCoeff()), reach * 0.999);
            }
        });
    }
    EXPECT_GT(wide, 50u);
    // Far fewer than the uniform lattice of the finest cells has.
    EXPECT_LT(v.position.size(), 0.5 * kPi / 6 / cube(0.02));
}

TEST(SampleVolume, CountIsMet) {
    for (const Lattice lattice : {Lattice::octree, Lattice::hexagonal, Lattice::uniform})
        for (const std::size_t count : {200u, 3000u}) {
            const SampledVolume v = sample_volume(ellipsoid({0.5, 0.4, 0.3}), {.lattice = lattice, .count = count});
            EXPECT_NEAR(double(v.position.size()) / double(count), 1, 0.1) << int(lattice) << " " << count;
        }
}

TEST(SampleVolume, RefusesWhatCannotBeSampled) {
    EXPECT_THROW(sample_volume(sphere(1), {}), InputError);
    EXPECT_THROW(sample_volume(sphere(1), {.spacing = 0.1, .count = 10}), InputError);
    EXPECT_THROW(sample_volume(plane({0, 0, 1}, 0), {.spacing = 0.1}), InputError);
    EXPECT_THROW(sample_volume(sphere(1), {.spacing = 1e-6}), InputError);
    EXPECT_THROW(sample_volume(intersection_of({sphere(0.1), translated(sphere(0.1), {1, 0, 0})}), {.spacing = 0.05}),
                 InputError);
}

}  // namespace
}  // namespace thixo
