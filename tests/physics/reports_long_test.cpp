// What is measured without a verdict: it misses its law, and docs/gates.md says by how much.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/physics/gate.h"
#include "tests/physics/pendant_drop.h"

namespace thixo {
namespace {

/// Times where a series passes through a value, either way.
std::vector<double> crossings(const gate::Series& series, const std::vector<double>& x, double value) {
    std::vector<double> out;
    for (std::size_t f = 1; f < x.size(); ++f) {
        const double a = x[f - 1] - value, b = x[f] - value;
        if (a * b < 0) out.push_back(series.time[f - 1] + (series.time[f] - series.time[f - 1]) * a / (a - b));
    }
    return out;
}

double farthest(const gate::Series& series, const std::vector<double>& x, double value, double from, double to) {
    double most = 0;
    for (std::size_t f = 0; f < x.size(); ++f)
        if (series.time[f] >= from && series.time[f] <= to) most = std::max(most, std::abs(x[f] - value));
    return most;
}

void report_wave(const std::string& support) {
    constexpr double kDepth = 1, kAmplitude = 0.05;  // [m]; the tank is a metre long
    const double k = kPi, omega = std::sqrt(9.81 * k * std::tanh(k * kDepth));
    Simulation s = make_simulation(gate::load("standing_wave", {"solver.support=" + support}));
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        const Vec3d x = s.particles.position[i].cast<double>();
        const double size = kAmplitude * omega / std::sinh(k * kDepth);
        s.particles.velocity[i] = Vec3d(-size * std::cosh(k * x.z()) * std::sin(k * x.x()), 0,
                                        size * std::sinh(k * x.z()) * std::cos(k * x.x()))
                                      .cast<Real>();
    }
    const gate::Series series = gate::run(s);
    const std::vector<double> x = series.of("middle"), zeros = crossings(series, x, x[0]);
    ASSERT_GE(zeros.size(), 10u);
    const double periods = static_cast<double>(zeros.size() - 1) / 2;
    const double first = farthest(series, x, x[0], 0, zeros[0]),
                 last = farthest(series, x, x[0], zeros[zeros.size() - 2], zeros.back());
    const std::string law = "standing wave, support of " + support + " spacings";
    gate::report(law, "period over the linear wave's", "1", (zeros.back() - zeros[0]) / periods / (2 * kPi / omega));
    gate::report(law, "height left after four and a half periods", "1", std::pow(last / first, 4.5 / periods));
}

TEST(StandingWave, IsReported) {
    report_wave("2");
    report_wave("2.5");
}

TEST(Slot, IsReported) {
    for (const std::string pressure : {"dfsph", "eos"}) {
        Simulation s = make_simulation(gate::load("slot", {"solver.pressure=" + pressure}));
        const gate::Series series = gate::run(s);
        const std::vector<double> held = series.of("held"), energy = series.of("energy");
        double head = 0, jet = 0, count = 0;
        for (std::size_t f = 0; f < held.size(); ++f) {
            if (series.time[f] < 0.5) continue;
            head += held[f] / (2 * 0.1) + 0.2;
            jet += energy[f];
            ++count;
        }
        ASSERT_GT(count, 20);
        gate::report("slot, " + pressure, "speed of the jet over Torricelli's", "1", std::sqrt(jet / (9.81 * head)));
        const double rate = (held[25] - held[50]) / (series.time[50] - series.time[25]);
        gate::report("slot, " + pressure, "contraction of the jet", "1",
                     rate / (0.1 * 0.2 * std::sqrt(2 * 9.81 * (head / count - 0.2))));
    }
}

/// Frequency of waves that swell a sheet of thickness 2 H, over that of the law (Lamb, Hydrodynamics, 266):
///     w^2 = gamma k^3/rho tanh(k H)      [1/s^2]
/// The sheet settles for half a second first. `amplitude` is in wave lengths.
double frequency_of_sheet(double amplitude, const std::vector<std::string>& set) {
    constexpr double kLength = 0.16, kHalf = 0.08, kTension = 1, kDensity = 1000;
    const double k = 2 * kPi / kLength, omega = std::sqrt(kTension * cube(k) / kDensity * std::tanh(k * kHalf));
    Simulation s = make_simulation(gate::load("capillary_wave", set));
    for (int f = 0; f < 20; ++f) advance_frame(s);
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        const Vec3d x = s.particles.position[i].cast<double>();
        const double size = amplitude * kLength * omega / std::sinh(k * kHalf);
        s.particles.velocity[i] += Vec3d(-size * std::cosh(k * x.z()) * std::sin(k * x.x()), 0,
                                         size * std::sinh(k * x.z()) * std::cos(k * x.x()))
                                       .cast<Real>();
    }
    std::vector<double> zeros;
    double last = 0, since = 0;
    while (s.clock.frame < s.problem.scene.frames.last) {
        advance_frame(s);
        double swelling = 0;
        for (const Vec3& x : s.particles.position)
            swelling += square(static_cast<double>(x.z())) * std::cos(k * static_cast<double>(x.x()));
        if (last * swelling < 0) zeros.push_back(since + (s.clock.time - since) * last / (last - swelling));
        last = swelling;
        since = s.clock.time;
    }
    EXPECT_GE(zeros.size(), 3u) << "it does not swing";
    if (zeros.size() < 3) return 0;
    return kPi * static_cast<double>(zeros.size() - 1) / (zeros.back() - zeros.front()) / omega;
}

TEST(CapillaryWave, IsReported) {
    const auto report = [](const std::string& what, double amplitude, const std::vector<std::string>& set) {
        gate::report("capillary wave, " + what, "frequency over the law's", "1", frequency_of_sheet(amplitude, set));
    };
    report("32 spacings long", 0.015, {});
    report("32 spacings long, higher", 0.05, {});
    report("32 spacings long, of a thicker liquid", 0.015, {"materials.water.viscosity=0.2"});
    report("40 spacings long", 0.015, {"solver.spacing=0.004"});
}

TEST(Rolling, OfABallOfTenSpacingsIsReported) {
    // It is 2.1 % slow: which lattice fills the ball changes this by 0.4 %.
    Simulation s = make_simulation(gate::load("rolling", {"solver.spacing=0.005"}));
    gate::report("ball on a slope, 10 spacings", "acceleration over g sin/(1 + I/(m R^2))", "1",
                 gate::run(s).rate("speed", 6) / (1.70349 / 1.4));
}

TEST(PendantDrop, OfFewSpacingsAndUnderEosHasMoreTension) {
    const auto report = [](const std::string& law, const std::vector<std::string>& set) {
        gate::report(law, "tension by its shape over the scene's", "1", pendant::hang(set).tension);
    };
    report("pendant drop, spacing 16 mm", {"solver.spacing=0.016"});
    // Under eos a film creeps over a disc that it wets wholly, and the drop falls off it.
    report("pendant drop, eos, spacing 12.5 mm",
           {"solver.pressure=eos", "world.gravity=[0,0,-5]", "world.boundaries.disc.contact_angle=75"});
}

}  // namespace
}  // namespace thixo
