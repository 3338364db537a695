// Elastic and plastic bodies beside their laws.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "tests/physics/gate.h"

namespace thixo {
namespace {

/// Mean over [0, end) of a vibration about its rest, by Hann's window. Incomplete periods of a mode leave an error of
///     1/(number of periods)^3
double mean_of_vibration(const std::vector<double>& time, const std::vector<double>& value) {
    double sum = 0, weights = 0;
    for (std::size_t k = 0; k < time.size(); ++k) {
        const double w = 1 - std::cos(2 * std::numbers::pi * time[k] / time.back());
        sum += w * value[k];
        weights += w;
    }
    return sum / weights;
}

/// The stretch along an axis: the slope of places over places at rest, of particles that rest within `reach` of the
/// middle.
class Slope {
  public:
    Slope(const Particles& p, int axis, double reach) : axis_(axis) {
        for (std::size_t i = 0; i < p.size(); ++i)
            if (std::abs(static_cast<double>(p.position[i].z())) < reach)
                rest_[p.id[i]] = static_cast<double>(p.position[i][axis]);
    }
    double of(const Particles& p) const {
        double across = 0, square = 0;
        for (std::size_t i = 0; i < p.size(); ++i)
            if (const auto at = rest_.find(p.id[i]); at != rest_.end()) {
                across += at->second * static_cast<double>(p.position[i][axis_]);
                square += at->second * at->second;
            }
        return across / square;
    }

  private:
    int axis_;
    std::map<std::int64_t, double> rest_;
};

struct Pulled {
    double strain, lateral;  // along z, along x [1]
};
Pulled pulled(const std::vector<std::string>& set, const std::string& scene = "pulled_bar") {
    Simulation s = make_simulation(gate::load(scene, set));
    evaluate(s);
    const Slope along(s.particles, 2, 0.1), across(s.particles, 0, 0.05);
    std::vector<double> time{0}, length{0}, width{0};
    while (s.clock.frame < s.problem.scene.frames.last) {
        advance_frame(s);
        time.push_back(s.clock.time);
        length.push_back(along.of(s.particles) - 1);
        width.push_back(across.of(s.particles) - 1);
    }
    return {mean_of_vibration(time, length), mean_of_vibration(time, width)};
}

TEST(PulledBar, GetsLongerByForceOverStiffnessAndNarrowsByPoisson) {
    // Ten particles across. At 1 % strain St. Venant's law is 1.5 % stiffer than Hooke's. The rest of the 3 % is for
    // the sampling of the free faces.
    const auto [strain, lateral] = pulled({});
    gate::expect({"pulled bar", "strain F/(E A)", "%", 100 * strain, 1, 0.03, "Hooke"});
    gate::expect({"pulled bar", "lateral contraction", "1", -lateral / strain, 0.3, 0.009, "Poisson"});
}

TEST(PulledBar, OfFibresGetsLongerByTheModulusOfTheDirectionItIsPulledIn) {
    // Axis 1 is four times as stiff as the others and is rotated to z.
    const std::string fibres = "materials.rubber.orthotropic.";
    const auto [strain, lateral] =
        pulled({fibres + "youngs_modulus=[1e5,2.5e4,2.5e4]", fibres + "shear_modulus=[2e4,1e4,2e4]",
                fibres + "poisson_ratio=[0.2,0.3,0.05]", fibres + "rotate=[0,-90,0]"});
    gate::expect({"pulled bar of fibres, along them", "strain F/(E1 A)", "%", 100 * strain, 1, 0.03, "Hooke"});
    gate::expect(
        {"pulled bar of fibres, along them", "lateral contraction", "1", -lateral / strain, 0.2, 0.01, "Poisson"});
}

TEST(PulledBar, SampledByOtherLatticesGetsLongerTheSame) {
    for (const std::string lattice : {"uniform", "octree"}) {
        const auto [strain, lateral] = pulled({"bodies.bar.sampling.lattice=" + lattice});
        gate::expect({"pulled bar, " + lattice, "strain F/(E A)", "%", 100 * strain, 1, 0.03, "Hooke"});
        gate::expect({"pulled bar, " + lattice, "lateral contraction", "1", -lateral / strain, 0.3, 0.009, "Poisson"});
    }
}

TEST(PulledStrip, InPlaneStrainGetsLongerByForceOverItsStiffness) {
    // Of E/(1 - nu^2), and narrows by nu/(1 - nu): along the periodic axis it cannot. Tolerances as of the bar.
    for (const std::string spacing : {"0.01", "0.007"}) {
        const std::string law = "pulled strip in plane strain, spacing " + spacing + " m";
        const auto [strain, lateral] = pulled({"solver.spacing=" + spacing}, "plane_strain");
        gate::expect({law, "strain F (1 - nu^2)/(E A)", "%", 100 * strain, 1, 0.03, "Hooke"});
        gate::expect({law, "lateral contraction", "1", -lateral / strain, 0.3 / 0.7, 0.013, "Poisson"});
    }
    const auto [strain, lateral] = pulled({"solver.time_step.maximum=1e-4"}, "plane_strain");
    gate::expect({"pulled strip in plane strain, steps of 0.1 ms", "strain F (1 - nu^2)/(E A)", "%", 100 * strain, 1,
                  0.03, "Hooke"});
}

/// Deflection over that of Timoshenko's beam.
double deflection(const std::vector<std::string>& set) {
    Simulation s = make_simulation(gate::load("cantilever", set));
    const gate::Series series = gate::run(s);
    const std::vector<double> z = series.of("tip");
    const double tip = mean_of_vibration(series.time, z) - z.front();
    const double force = 0.02, modulus = 1e5, height = 0.06, length = series.of("reach").front() + 0.18;
    const double bending = force * std::pow(length, 3) / (3 * modulus * std::pow(height, 4) / 12);
    const double shear = force * length * 2.6 / (5.0 / 6 * modulus * square(height));
    return -tip / (bending + shear);
}

TEST(Cantilever, BendsAsTheoryOfBeamsHasIt) {
    gate::expect({"cantilever", "deflection over theory", "1", deflection({}), 1, 0.05, "Timoshenko"});
}

TEST(Cantilever, BendsTheSameInImplicitSteps) {
    // Both have the same forces. The phase and the damping of the vibration under the mean differ.
    const double implicit = deflection({"solver.solids=implicit"});
    gate::expect({"cantilever, implicit", "deflection over theory", "1", implicit, 1, 0.05, "Timoshenko"});
    gate::expect({"cantilever, implicit", "deflection over the explicit one", "1", implicit / deflection({}), 1, 0.01,
                  "the same forces"});
}

TEST(BlockOnASlope, SlidesAndSticksInImplicitStepsToo) {
    Simulation slides = make_simulation(gate::load("slope", {"solver.solids=implicit"}));
    const double law = 4.905 - 0.3 * 8.4957;
    gate::expect({"block on a slope, implicit", "acceleration", "m/s^2", gate::run(slides).rate("speed", 4), law,
                  0.03 * law, "Coulomb"});
    // A sticking contact creeps by 1/kHold of the fall within a step. One layer of four bears 4.9 m/s^2 in steps of
    // 4.6 ms. For a quarter of a second that makes 2e-5 m, and up to twice as much where the layer is loaded unevenly.
    Simulation sticks =
        make_simulation(gate::load("slope", {"solver.solids=implicit", "materials.rubber.friction=0.65"}));
    const auto way = gate::run(sticks).of("way");
    gate::expect({"block on a slope, implicit, steeper friction", "creep from frame 6 on", "m", way.back() - way[6], 0,
                  5e-5, "Coulomb"});
}

TEST(FloatingBall, LiesInTheLiquidToItsMiddle) {
    // The level of the surface is the volume of the liquid and of half the ball over the tank's ground. The tolerance
    // is a quarter of the spacing.
    Simulation s = make_simulation(gate::load("floating_ball"));
    const gate::Series series = gate::run(s);
    const std::vector<double> z = series.of("centre");
    double mean = 0;
    for (std::size_t k = 25; k < z.size(); ++k) mean += z[k] / static_cast<double>(z.size() - 25);
    const double ball = 4 / 3.0 * std::numbers::pi * cube(0.05);
    const double level = (series.last("mass") / 1000 + ball / 2) / square(0.24);
    gate::expect({"floating ball of half the density", "height of its centre", "mm", 1000 * mean, 1000 * level, 2.5,
                  "Archimedes"});
}

struct Stretched {
    double stretch, volume;  // of the middle, over those at rest [1]
};
std::vector<Stretched> stretched(const std::vector<std::string>& set) {
    Simulation s = make_simulation(gate::load("stretched_bar", set));
    const gate::Series series = gate::run(s);
    const auto upper = series.of("upper"), lower = series.of("lower"), density = series.of("density");
    std::vector<Stretched> out;
    for (std::size_t k = 1; k < upper.size(); ++k)
        out.push_back({(upper[k] - lower[k]) / (upper[0] - lower[0]), 1000 / density[k]});
    return out;
}
/// |J| of a bar under tension alone by the law sigma = C eps, where
///     eps_lateral = -nu eps
double volume_by_law(double stretch, double nu) { return stretch * (1 - nu * (stretch * stretch - 1)); }

TEST(StretchedBar, KeepsToItsLawAtAnyStretch) {
    for (const double nu : {0.0, 0.49}) {
        double worst = 0, farthest = 0;
        for (const Stretched& at : stretched({"materials.rubber.poisson_ratio=" + std::to_string(nu)})) {
            worst = std::max(worst, std::abs(at.volume / volume_by_law(at.stretch, nu) - 1));
            farthest = std::max(farthest, at.stretch);
        }
        EXPECT_GT(farthest, 1.49);
        gate::expect({"stretched bar, nu " + std::to_string(nu).substr(0, 4), "largest error of its volume", "%",
                      100 * worst, 0, 3, "St. Venant and Kirchhoff"});
    }
}

TEST(StretchedBar, KeepsItsVolumeWithTheVolumeTerm) {
    // At half as much again the law itself would lose volume (J = 0.58). k_v = 350 E balances that with 1 % of volume.
    const std::vector<Stretched> all = stretched({"materials.rubber.volume_stiffness=3.5e7"});
    double worst = 0;
    for (const Stretched& at : all)
        if (at.stretch <= 1.5) worst = std::max(worst, std::abs(at.volume - 1));
    gate::expect({"stretched bar, volume term", "largest loss of volume", "%", 100 * worst, 0, 1, "design"});
}

TEST(BlockOnASlope, SlidesWithWhatFrictionLeaves) {
    Simulation s = make_simulation(gate::load("slope"));
    const gate::Series series = gate::run(s);
    const double measured = series.rate("speed", 4);  // after it has settled under its own weight
    const double law = 4.905 - 0.3 * 8.4957;
    gate::expect({"block on a slope", "acceleration", "m/s^2", measured, law, 0.03 * law, "Coulomb"});
}

TEST(BlockOnASlope, SticksBelowTheAngleOfFriction) {
    // tan 30 degrees = 0.577 < 0.65. The block yields elastically by less than a hundredth of a spacing, and no more.
    Simulation s = make_simulation(gate::load("slope", {"materials.rubber.friction=0.65"}));
    const gate::Series series = gate::run(s);
    const auto way = series.of("way");
    gate::expect(
        {"block on a slope, steeper friction", "creep from frame 6 on", "m", way.back() - way[6], 0, 2e-5, "Coulomb"});
}

void land(const std::string& what, const std::vector<std::string>& set) {
    Simulation s = make_simulation(gate::load("landing", set));
    const gate::Series series = gate::run(s);
    const auto height = series.of("height"), energy = series.of("energy");
    const double most = *std::max_element(energy.begin(), energy.end());
    double lowest = 1, bounce = 0;
    for (const double h : height) {
        lowest = std::min(lowest, h);
        if (lowest < 0.055) bounce = std::max(bounce, h);
    }
    EXPECT_GT(bounce, 0.06);
    gate::expect({what, "kinetic energy at the end over its largest", "1", energy.back() / most, 0, 1e-4, "rest"});
    // The mean height falls by its compression under its weight, and by the compression of the floor's spring:
    //     rho g H/(3 E),  rho g H V^(1/3)/(lambda + 2 mu)  [m]
    const double settled = 0.05 - 9810 * 0.01 / 3e5 - 9810 * 0.1 * 0.01 / 1.346e5;
    gate::expect({what, "height at the end", "m", height.back(), settled, 2e-4, "its weight; a fiftieth of a spacing"});
}

TEST(FallingCube, BouncesAndComesToRestWhereItsWeightHoldsIt) { land("falling cube", {}); }
TEST(FallingCube, SampledByAnOctreeComesToRestThereToo) {
    land("falling cube, octree", {"bodies.cube.sampling.lattice=octree"});
}

struct Squash {
    double lowest, highest;  // centre of mass on the way down, and afterwards [m]
};
Squash squash(const std::string& lattice) {
    Simulation s = make_simulation(gate::load("squash", {"bodies.ball.sampling.lattice=" + lattice}));
    const std::vector<double> height = gate::run(s).of("height");
    const auto lowest = std::min_element(height.begin(), height.end());
    return {*lowest, *std::max_element(lowest, height.end())};
}

TEST(SquashedBall, OfAnOctreeGivesWayAndReboundsAsOneOfAPacking) {
    // It is squashed to a quarter of its height: strains are of order one where cells of different size meet.
    const Squash octree = squash("octree"), packing = squash("hexagonal");
    EXPECT_LT(packing.lowest, 0.06);  // of 0.17 m at rest
    gate::expect({"squashed ball, octree", "lowest centre over that of a packing", "1", octree.lowest / packing.lowest,
                  1, 0.08, "the same ball"});
    gate::expect({"squashed ball, octree", "rebound over that of a packing", "1", octree.highest / packing.highest, 1,
                  0.03, "the same ball"});
}

}  // namespace
}  // namespace thixo
