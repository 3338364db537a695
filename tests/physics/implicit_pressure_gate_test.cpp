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
    const double iterations =
        static_cast<double>(s.stats.divergence.iterations + s.stats.density.iterations) / s.stats.steps;
    gate::expect({"tank at rest", "slope of pressure over depth", "rho g", slope / 9810, 1, 0.01, "hydrostatics"});
    gate::expect({"tank at rest", "surface, as twice the mean height", "m", 2 * mean("height"), depth, 0.0025,
                  "volume/area, half a spacing"});
    gate::expect({"tank at rest", "drift of the height, 2 to 12 s", "1", series.last("height") / at_two - 1, 0, 1e-3,
                  "incompressibility"});
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

/// The mean speed between two times.
double speed(const gate::Series& series, const std::vector<double>& front, double from, double to) {
    return (at(series, front, to) - at(series, front, from)) / (to - from);
}

TEST(DamFront, RunsAsFastAsMeasured) {
    // Speeds, not places: without friction at the floor and without a gate that takes time to open, the front is 0.05 s ahead
    // of both experiments from the start, at spacings of 4 and of 2 cm alike (0.2 m; told by the first two figures).
    Simulation s = make_simulation(gate::load("dam_front"));
    const gate::Series series = gate::run(s);
    std::vector<double> front = series.of("front");
    for (double& x : front) x += 0.02;  // half a spacing beyond the particles' centres
    const double koshizuka_oka[][2] = {{.092, 1.128}, {.191, 1.244}, {.266, 1.464}, {.322, 1.695}, {.368, 1.903},
                                       {.414, 2.123}, {.447, 2.365}, {.496, 2.584}, {.522, 2.804}, {.565, 3.034},
                                       {.594, 3.219}, {.637, 3.462}, {.669, 3.704}, {.702, 3.900}};
    double squares = 0;
    for (const auto& [t, x] : koshizuka_oka) squares += std::pow(at(series, front, t) - x, 2);
    gate::report("dam front", "rms distance to Koshizuka & Oka 1996", "m", std::sqrt(squares / std::size(koshizuka_oka)));
    const double unit = std::sqrt(2 * 9.81);  // of time, for a column 1 m wide
    const double martin_moyce[][2] = {{.832, 1.217}, {1.219, 1.474}, {1.997, 2.292},
                                      {2.547, 2.995}, {3.345, 4.134}, {4.034, 4.944}};
    double worst = 0;
    for (const auto& [t, z] : martin_moyce) worst = std::max(worst, std::abs(at(series, front, t / unit) / z - 1));
    gate::report("dam front", "largest error against Martin & Moyce 1952 up to z/a = 5", "1", worst);
    const double measured = (3.900 - 2.123) / (.702 - .414), early = (4.134 - 2.292) / (3.345 - 1.997) * unit;
    gate::expect({"dam front", "speed from x = 2.1 to 3.9 m", "m/s", speed(series, front, .414, .702), measured,
                  0.05 * measured, "Koshizuka & Oka 1996"});
    gate::expect({"dam front", "speed from z/a = 2.3 to 4.1", "m/s", speed(series, front, 1.997 / unit, 3.345 / unit), early,
                  0.08 * early, "Martin & Moyce 1952, n^2 = 2"});
    const double lost = 9.81 * s.particles.size() * cube(0.04) * 1000 * (series.of("height").front() - series.last("height"));
    gate::report("dam front", "kinetic energy over potential energy lost at 1 s", "1", series.last("energy") / lost);
}

}  // namespace
}  // namespace thixo
