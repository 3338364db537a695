// Solids that roll, rebound and stand on walls.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/physics/gate.h"

namespace thixo {
namespace {

const std::string kCylinder =
    "bodies.roller.shape={cylinder: {radius: 0.05, height: 0.05}, rotate: [90, 0, 0], "
    "translate: [0, 0, 0.05]}";
constexpr double kDownhill = 1.70349;  // g sin 10 degrees [m/s^2]

/// The acceleration after the body has settled under its weight [m/s^2].
double acceleration(const std::vector<std::string>& set) {
    Simulation s = make_simulation(gate::load("rolling", set));
    return gate::run(s).rate("speed", 6);
}

/// Acceleration over that of a body of `inertia` over m R^2. Friction is so large that nothing slides.
double rolls(double inertia, const std::vector<std::string>& set) {
    return acceleration(set) / (kDownhill / (1 + inertia));
}

constexpr const char* kLaw = "acceleration over g sin/(1 + I/(m R^2))";

/// Contact without damping has no resistance to rolling.
double expect_rolling(const std::string& what, double inertia, const std::vector<std::string>& set) {
    const double rolled = rolls(inertia, set);
    gate::expect({what, kLaw, "1", rolled, 1, 0.02, "rigid bodies"});
    return rolled;
}

TEST(Rolling, ABallHasFiveSeventhsOfTheSlopesPullAndDampingOfTheContactResistsIt) {
    const double free = expect_rolling("ball on a slope, 8 spacings", 0.4, {});
    expect_rolling("ball on a slope, 8 spacings, steps of 0.1 ms", 0.4, {"solver.time_step.maximum=1e-4"});
    const double damped = rolls(0.4, {"materials.rubber.contact_damping=0.5"});
    EXPECT_LT(damped, free);
    gate::report("ball on a slope, 8 spacings, contact damped", kLaw, "1", damped);
}

TEST(Rolling, ACylinderHasTwoThirdsOfTheSlopesPull) {
    expect_rolling("cylinder on a slope, 8 spacings", 0.5, {kCylinder});
    expect_rolling("cylinder on a slope, 10 spacings", 0.5, {kCylinder, "solver.spacing=0.005"});
}

TEST(Rolling, WithoutFrictionNothingStartsToSpin) {
    // A ball that rolls has 0.4 of its motion's energy in its spin. Vibrations count here too.
    Simulation s = make_simulation(gate::load("rolling", {"materials.rubber.friction=0"}));
    const gate::Series series = gate::run(s);
    const double speed = series.last("speed"), motion = speed * speed / 2;
    gate::expect({"ball on a slope without friction", "energy beside that of its motion", "1",
                  series.last("energy") / motion - 1, 0, 0.01, "no torque"});
    gate::expect({"ball on a slope without friction", "acceleration over g sin", "1",
                  series.rate("speed", 6) / kDownhill, 1, 0.01, "Newton"});
}

/// Lets a ball fall and bounce once, without damping. The energy is that of all its matter, above its place of rest.
void expect_energy_kept(const std::string& what, const std::vector<std::string>& set) {
    Simulation s = make_simulation(gate::load("rebound", set));
    const gate::Series series = gate::run(s);
    const auto height = series.of("height"), kinetic = series.of("kinetic"), elastic = series.of("elastic");
    const auto energy = [&](std::size_t k) { return kinetic[k] + elastic[k] + 9.81 * (height[k] - 0.05); };
    const std::size_t end = height.size() - 1;
    const auto lowest = std::min_element(height.begin(), height.end());
    EXPECT_LT(*lowest, 0.05);
    gate::expect({what, "energy after over that before", "1", energy(end) / energy(0), 1, 0.05, "conservation"});
    gate::report(what, "height of the rebound over that of the fall", "1",
                 (*std::max_element(lowest, height.end()) - 0.05) / 0.2);
}

TEST(Rebound, KeepsTheEnergyAtAnyStiffness) {
    for (const std::string stiffness : {"1e5", "1e6"})
        for (const std::string spacing : {"0.01", "0.00625"})
            expect_energy_kept("rebound, E = " + stiffness + " Pa, spacing " + spacing + " m",
                               {"materials.rubber.youngs_modulus=" + stiffness, "solver.spacing=" + spacing});
    expect_energy_kept("rebound, E = 1e5 Pa, steps of 0.1 ms", {"solver.time_step.maximum=1e-4"});
}

void expect_carried(const std::string& what, const std::vector<std::string>& set) {
    Simulation s = make_simulation(gate::load("turntable", set));
    const gate::Series series = gate::run(s);
    const double off = std::hypot(series.last("x"), series.last("y") - 0.15);
    gate::expect({what, "way from its place on the table", "m", off, 0, 2e-4, "it sticks; a fiftieth of a spacing"});
}

TEST(BlockOnATurntable, GoesWithIt) {
    expect_carried("block on a turntable", {});
    expect_carried("block on a turntable, implicit", {"solver.solids=implicit"});
}

}  // namespace
}  // namespace thixo
