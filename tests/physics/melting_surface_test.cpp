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

/// Points of the matter at a body's surface, far more than surfels, that go with the particles step by step.
struct Tracers {
    std::vector<Vec3> first, place;
    std::vector<Vec3> before;  // of the particles, by id
    int calls = 0;

    explicit Tracers(const Simulation& s) {
        const SurfelCloud& cloud = s.surface.surfels;
        for (std::size_t i = 0; i < cloud.size(); ++i)
            for (int k = 0; k < 7; ++k) {
                const Real r = k == 0 ? Real(0) : Real(0.5), angle = static_cast<Real>(2 * kPi * k / 6);
                first.push_back(cloud.position[i] +
                                r * (std::cos(angle) * cloud.axis1[i] + std::sin(angle) * cloud.axis2[i]));
            }
        place = first;
        note(s);
    }
    void note(const Simulation& s) {
        before.resize(s.particles.size());
        for (std::size_t j = 0; j < s.particles.size(); ++j)
            before[static_cast<std::size_t>(s.particles.id[j])] = s.particles.position[j];
    }
    /// By a first-order fit of the particles' displacement, four steps at a time: they move by a hundredth of a
    /// spacing.
    void follow(const Simulation& s) {
        if (calls++ % 4 != 0) return;
        std::vector<Vec3> from;
        for (std::size_t j = 0; j < s.particles.size(); ++j)
            from.push_back(before[static_cast<std::size_t>(s.particles.id[j])]);
        PointGrid grid;
        grid.build(from, s.problem.smoothing.support);
        const Poly6 w(grid.cell());
        parallel_for(place.size(), [&](std::size_t t) {
            Real weight = 0;
            Vec3 mean(0, 0, 0), mean_shift(0, 0, 0);
            Mat3 spread = Mat3::Zero(), covariance = Mat3::Zero();
            grid.for_each_neighbour(place[t], grid.cell(), [&](Index j, Real r2) {
                const Real a = w.value(r2) / w.value(0);
                const Vec3 x = (from[j] - place[t]) / grid.cell(), u = s.particles.position[j] - from[j];
                weight += a;
                mean += a * x;
                mean_shift += a * u;
                covariance += a * u * x.transpose();
                spread += a * x * x.transpose();
            });
            if (!(weight > 0)) return;
            mean /= weight;
            mean_shift /= weight;
            covariance = covariance / weight - mean_shift * mean.transpose();
            spread = spread / weight - mean * mean.transpose() + Real(5e-4) * Mat3::Identity();
            place[t] += mean_shift - covariance * spread.inverse() * mean;
        });
        note(s);
    }
};

/// Distance of what is painted on a surfel from the matter it was painted on, the median over surfels [m].
double texture_error(const Simulation& s, const Tracers& tracers) {
    PointGrid grid;
    const Real reach = s.problem.smoothing.spacing;
    grid.build(tracers.place, reach);
    std::vector<double> errors;
    std::vector<std::pair<Real, Index>> near;
    for (std::size_t i = 0; i < s.surface.size(); ++i) {
        grid.nearest(s.surface.surfels.position[i], 3, reach, near);
        if (near.size() < 3) continue;
        Vec3 mean(0, 0, 0);
        for (const auto& [r2, t] : near) mean += tracers.first[t] / 3;
        errors.push_back(static_cast<double>((s.surface.rest[i] - mean).norm()));
    }
    std::ranges::sort(errors);
    return errors[errors.size() / 2];
}

struct Drawn {
    double volume_error = 0, holes = 0, texture_error = 0;
};
Drawn melt(const std::string& scene) {
    Simulation s = make_simulation(gate::load(scene));
    refresh_surface(s);
    const Real radius = static_cast<Real>(s.problem.scene.surface.radius) * s.problem.smoothing.spacing;
    double matter = 0;
    for (const Real v : s.particles.rest_volume) matter += static_cast<double>(v);
    Tracers tracers(s);
    Drawn drawn;
    int frames = 0;
    while (s.clock.frame < s.problem.scene.frames.last) {
        advance_frame(s, [&] {
            tracers.follow(s);
            return false;
        });
        // Before, its sheets reach past the edges, and are trimmed when they are drawn.
        if (s.mixed_surface.animated.size() == 0) continue;
        const double volume = surface_volume(s.surface, s.particles, s.walls, radius);
        drawn.volume_error = std::max(drawn.volume_error, std::abs(volume / matter - 1));
        drawn.holes += holes(s, 40000);
        ++frames;
    }
    drawn.holes /= frames;
    double liquid = 0;
    for (const Real b : s.particles.melt) liquid += b >= 1;
    gate::report(scene, "melted", "%", 100 * liquid / static_cast<double>(s.particles.size()));
    drawn.texture_error = texture_error(s, tracers);
    gate::report(scene, "median distance of the texture from its matter", "m", drawn.texture_error);
    gate::report(scene, "largest error of the surface's volume", "%", 100 * drawn.volume_error);
    gate::report(scene, "rays from within that leave by a hole", "per million", 1e6 * drawn.holes);
    return drawn;
}

// Paint keeps within a fortieth of the body of tracers that nothing brings back to the surface; without zombies it is
// off by 4 % of the ball and 7.6 % of the box. In a known flow (zombies_test) it is under 1 %.
TEST(MeltingSurface, OfABallIsClosedAndHoldsItsVolume) {
    const Drawn drawn = melt("melting_ball");
    EXPECT_LT(drawn.volume_error, 0.02);
    EXPECT_LT(drawn.holes, 5e-5);
    EXPECT_LT(drawn.texture_error, 0.025 * 0.2);
}

// Where faces meet in an edge discs are cut short; what is left open there is smaller than a disc.
TEST(MeltingSurface, OfABoxIsClosedAndHoldsItsVolume) {
    const Drawn drawn = melt("melting_box");
    EXPECT_LT(drawn.volume_error, 0.02);
    EXPECT_LT(drawn.holes, 3e-5);
    EXPECT_LT(drawn.texture_error, 0.025 * 0.16);
}

}  // namespace
}  // namespace thixo
