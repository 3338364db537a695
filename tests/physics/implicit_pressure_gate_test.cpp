// What the implicit pressure solver is measured against.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/physics/gate.h"

namespace thixo {
namespace {

double mean_after(const gate::Series& series, const std::string& name, double from) {
    const std::vector<double> all = series.of(name);
    double sum = 0, count = 0;
    for (std::size_t f = 0; f < all.size(); ++f)
        if (series.time[f] >= from) sum += all[f], ++count;
    return sum / count;
}

TEST(TankAtRest, IsHydrostaticAndStill) {
    Simulation s = make_simulation(gate::load("tank_at_rest"));
    const gate::Series series = gate::run(s);
    const auto mean = [&](const std::string& name) { return mean_after(series, name, 2); };
    const double slope = (mean("low_pressure") - mean("high_pressure")) / (mean("high_height") - mean("low_height"));
    const double depth = series.last("mass") / (1000 * 0.05 * 0.05), at_two = series.of("height")[48];
    const double iterations = static_cast<double>(s.stats.divergence.iterations + s.stats.density.iterations) / s.stats.steps;
    gate::expect({"tank at rest", "slope of pressure over depth", "rho g", slope / 9810, 1, 0.01, "hydrostatics"});
    gate::expect({"tank at rest", "surface, as twice the mean height", "m", 2 * mean("height"), depth, 0.0025, "volume/area, half a spacing"});
    gate::expect({"tank at rest", "drift of the height, 2 to 12 s", "1", series.last("height") / at_two - 1, 0, 1e-3, "incompressibility"});
    gate::expect({"tank at rest", "rms speed, 2 to 12 s", "m/s", std::sqrt(2 * mean("energy")), 0, 2e-3, "rest"});
    gate::expect({"tank at rest", "iterations a step", "1", iterations, 0, 20, "aim"});
}

/// The series' value at a time, linear between frames.
double at(const gate::Series& series, const std::vector<double>& values, double time) {
    std::size_t f = 1;
    while (f + 1 < series.time.size() && series.time[f] < time) ++f;
    const double part = (time - series.time[f - 1]) / (series.time[f] - series.time[f - 1]);
    return values[f - 1] + part * (values[f] - values[f - 1]);
}

TEST(DamFront, IsWhereItWasMeasured) {
    Simulation s = make_simulation(gate::load("dam_front"));
    const gate::Series series = gate::run(s);
    std::vector<double> front = series.of("front");
    for (double& x : front) x += 0.02;  // half a spacing beyond the particles' centres
    const double koshizuka_oka[][2] = {{.092, 1.128}, {.191, 1.244}, {.266, 1.464}, {.322, 1.695}, {.368, 1.903}, {.414, 2.123}, {.447, 2.365}, {.496, 2.584}, {.522, 2.804}, {.565, 3.034}, {.594, 3.219}, {.637, 3.462}, {.669, 3.704}, {.702, 3.900}};
    double squares = 0;
    for (const auto& [t, x] : koshizuka_oka) squares += std::pow(at(series, front, t) - x, 2);
    gate::expect({"dam front", "rms distance to the measured front", "m", std::sqrt(squares / std::size(koshizuka_oka)), 0, 0.06, "Koshizuka & Oka 1996"});
    const double martin_moyce[][2] = {{.832, 1.217}, {1.219, 1.474}, {1.997, 2.292}, {2.547, 2.995}, {3.345, 4.134}, {4.034, 4.944}};
    double worst = 0;
    for (const auto& [t, z] : martin_moyce) worst = std::max(worst, std::abs(at(series, front, t / std::sqrt(2 * 9.81)) / z - 1));
    gate::expect({"dam front", "largest error of the front up to z/a = 5", "1", worst, 0, 0.08, "Martin & Moyce 1952, n^2 = 2"});
}

}  // namespace
}  // namespace thixo
