// What is drawn of a body while it melts: a closed surface around its matter.
#include <gtest/gtest.h>

#include <algorithm>

#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"
#include "pipeline/geometry/point_grid.h"
#include "sim/setup.h"
#include "sim/step.h"
#include "sim/surface/volume.h"
#include "tests/physics/gate.h"
#include "tests/sim/surface/discs.h"

namespace thixo {
namespace {

/// Particles with no surfel nearer than a spacing.
std::vector<Vec3> deep_places(const Simulation& s) {
    const Real spacing = s.problem.smoothing.spacing;
    PointGrid grid;
    grid.build(s.surface.surfels.position, spacing);
    std::vector<Vec3> deep;
    for (const Vec3& x : s.particles.position) {
        bool near = false;
        grid.for_each_neighbour(x, spacing, [&](Index, Real) { near = true; });
        if (!near) deep.push_back(x);
    }
    return deep;
}

/// Share of rays from deep inside that leave unseen.
double holes(const Simulation& s, std::size_t rays) {
    const std::vector<Vec3> from = deep_places(s);
    if (from.empty()) return 0;
    const fixture::Discs discs(s.surface.surfels, fixture::widest(s.surface.surfels));
    const auto frame = static_cast<std::uint64_t>(s.clock.frame);
    return parallel_sum(rays,
                        [&](std::size_t k) {
                            const Vec3& x = from[random_bits(7, k, frame, 2) % from.size()];
                            return discs.hit(x, fixture::random_direction(k + frame * rays), 1) ? 0.0 : 1.0;
                        }) /
           static_cast<double>(rays);
}

/// Where the matter at a surfel was at first: a first-order least squares fit of the particles about it.
Vec3 matter_at(const Vec3& x, const Simulation& s, const std::vector<Vec3>& first, const PointGrid& grid) {
    const Poly6 w(grid.cell());
    double weight = 0;
    Vec3d mean(0, 0, 0), mean_first(0, 0, 0);
    Mat3d spread = Mat3d::Zero(), covariance = Mat3d::Zero();
    grid.for_each_neighbour(x, grid.cell(), [&](Index j, Real r2) {
        const auto a = static_cast<double>(w.value(r2));
        const Vec3d r = (s.particles.position[j] - x).cast<double>();
        const Vec3d m = first[static_cast<std::size_t>(s.particles.id[j])].cast<double>();
        weight += a;
        mean += a * r;
        mean_first += a * m;
        covariance += a * m * r.transpose();
        spread += a * r * r.transpose();
    });
    mean /= weight;
    mean_first /= weight;
    covariance = covariance / weight - mean_first * mean.transpose();
    spread = spread / weight - mean * mean.transpose() + 1e-3 * square(double(grid.cell())) * Mat3d::Identity();
    return (mean_first - covariance * spread.inverse() * mean).cast<Real>();
}

/// Distance of what is painted on the surfels from the matter it was painted on, the median [m].
double texture_error(const Simulation& s, const std::vector<Vec3>& first) {
    PointGrid grid;
    grid.build(s.particles.position, Real(1.25) * s.problem.smoothing.support);
    std::vector<double> errors;
    for (std::size_t i = 0; i < s.surface.size(); ++i)
        errors.push_back(
            static_cast<double>((s.surface.rest[i] - matter_at(s.surface.surfels.position[i], s, first, grid)).norm()));
    std::ranges::sort(errors);
    return errors[errors.size() / 2];
}

struct Drawn {
    double volume_error = 0, holes = 0;
};
Drawn melt(const std::string& scene) {
    Simulation s = make_simulation(gate::load(scene));
    refresh_surface(s);
    const Real radius = static_cast<Real>(s.problem.scene.surface.radius) * s.problem.smoothing.spacing;
    double matter = 0;
    for (const Real v : s.particles.rest_volume) matter += static_cast<double>(v);
    std::vector<Vec3> first(s.particles.size());
    for (std::size_t i = 0; i < s.particles.size(); ++i)
        first[static_cast<std::size_t>(s.particles.id[i])] = s.particles.position[i];
    Drawn drawn;
    int frames = 0;
    while (s.clock.frame < s.problem.scene.frames.last) {
        advance_frame(s);
        // Before, its sheets reach past the edges, and are trimmed when they are drawn.
        if (s.mixed_surface.animated.size() == 0) continue;
        const double volume = surface_volume(s.surface, s.particles, s.walls, radius);
        drawn.volume_error = std::max(drawn.volume_error, std::abs(volume / matter - 1));
        drawn.holes += holes(s, 5000);
        ++frames;
    }
    drawn.holes /= frames;
    double liquid = 0;
    for (const Real b : s.particles.melt) liquid += b >= 1;
    gate::report(scene, "melted", "%", 100 * liquid / static_cast<double>(s.particles.size()));
    gate::report(scene, "median distance of the texture from its matter", "m", texture_error(s, first));
    gate::report(scene, "largest error of the surface's volume", "%", 100 * drawn.volume_error);
    gate::report(scene, "rays from within that leave by a hole", "per million", 1e6 * drawn.holes);
    return drawn;
}

TEST(MeltingSurface, OfABallIsClosedAndHoldsItsVolume) {
    const Drawn drawn = melt("melting_ball");
    EXPECT_LT(drawn.volume_error, 0.025);
    EXPECT_LT(drawn.holes, 5e-5);
}

// Where faces meet in an edge discs are cut short; what is left open there is smaller than a disc.
TEST(MeltingSurface, OfABoxIsClosedAndHoldsItsVolume) {
    const Drawn drawn = melt("melting_box");
    EXPECT_LT(drawn.volume_error, 0.03);
    EXPECT_LT(drawn.holes, 2e-4);
}

}  // namespace
}  // namespace thixo
