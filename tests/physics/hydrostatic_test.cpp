#include <gtest/gtest.h>

#include "tests/physics/gate.h"
#include "tests/sim/fixture.h"

namespace thixo {
namespace {

struct Line {
    double slope, offset, correlation;
};
Line regression(const std::vector<double>& x, const std::vector<double>& y) {
    const double n = static_cast<double>(x.size());
    double sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        sx += x[i];
        sy += y[i];
        sxx += x[i] * x[i];
        sxy += x[i] * y[i];
        syy += y[i] * y[i];
    }
    const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
    return {slope, (sy - slope * sx) / n, (n * sxy - sx * sy) / std::sqrt((n * sxx - sx * sx) * (n * syy - sy * sy))};
}

// A closed box of water that has come to rest, 10 cm deep, 20 particles high.
class RestingWater : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        scene::Scene scene = fixture::tank({0.05, 0.05, 0.15}, 0.1, 0.005);
        scene.materials[0].viscosity = 0.05;
        scene.solver.artificial_viscosity = 0.3;  // to come to rest within the simulated time
        simulation_ = std::make_unique<Simulation>(make_simulation(scene));
        for (int f = 0; f < 16; ++f) advance_frame(*simulation_);
    }
    static void TearDownTestSuite() { simulation_.reset(); }
    static inline std::unique_ptr<Simulation> simulation_;
};

TEST_F(RestingWater, PressureIsLinearInDepth) {
    // Means of ten frames in layers of one spacing. The pressure of single particles scatters with the packing around
    // them (weak compressibility). The slope is rho g to 5 %.
    Simulation& s = *simulation_;
    constexpr int kLayers = 16;
    std::vector<double> sum(kLayers, 0), count(kLayers, 0);
    for (int f = 0; f < 10; ++f) {
        advance_frame(s);
        for (std::size_t i = 0; i < s.particles.size(); ++i) {
            const Vec3& x = s.particles.position[i];
            const int layer = static_cast<int>(x.z() / 0.005);
            if (layer < 2 || layer >= kLayers || std::max(std::abs(x.x()), std::abs(x.y())) > 0.015) continue;
            sum[static_cast<std::size_t>(layer)] += static_cast<double>(s.particles.pressure[i]);
            ++count[static_cast<std::size_t>(layer)];
        }
    }
    std::vector<double> z, p;
    for (std::size_t k = 2; k < kLayers; ++k) {
        ASSERT_GT(count[k], 0);
        z.push_back((static_cast<double>(k) + 0.5) * 0.005);
        p.push_back(sum[k] / count[k]);
    }
    const Line line = regression(z, p);
    gate::expect(
        {"water at rest, eos", "slope of pressure over depth", "rho g", -line.slope / 9810, 1, 0.05, "hydrostatics"});
    EXPECT_LT(line.correlation, -0.99);
}

TEST_F(RestingWater, KeepsItsVolume) {
    // The mean height of the water's mass is half its depth, and depth = mass/(rho area). The tolerance is 3 %, of
    // which half a layer at the surface makes 2.5 %.
    const Particles& p = simulation_->particles;
    double mass = 0, moment = 0;
    for (std::size_t i = 0; i < p.size(); ++i) {
        mass += static_cast<double>(p.mass[i]);
        moment += static_cast<double>(p.mass[i] * p.position[i].z());
    }
    const double depth = mass / (1000 * 0.05 * 0.05);
    gate::expect({"water at rest, eos", "twice the mean height over volume/area", "1", 2 * moment / mass / depth, 1,
                  0.03, "incompressibility"});
}

TEST_F(RestingWater, IsAtRest) {
    // Free fall over one spacing would give 0.3 m/s, and over the depth 1.4 m/s. A hundredth of that counts as rest.
    const Particles& p = simulation_->particles;
    double sum = 0;
    for (const Vec3& v : p.velocity) sum += static_cast<double>(v.squaredNorm());
    EXPECT_LT(std::sqrt(sum / static_cast<double>(p.size())), 0.014);
}

TEST_F(RestingWater, StandsOffTheWallsByAboutHalfASpacing) {
    const Simulation& s = *simulation_;
    double nearest = 1;
    for (const Vec3& x : s.particles.position)
        nearest = std::min(nearest, static_cast<double>(wall_distance(s.walls, x)));
    EXPECT_GT(nearest, 0.35 * 0.005);
    EXPECT_LT(nearest, 0.6 * 0.005);
}

}  // namespace
}  // namespace thixo
