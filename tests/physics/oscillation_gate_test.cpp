// An elastic beam oscillates at its natural frequency and keeps its energy.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/physics/gate.h"

namespace thixo {
namespace {

constexpr double kLength = 0.2, kHeight = 0.02, kModulus = 2e6, kDensity = 1000;
constexpr double kFirst = 1.875104;  // k L of the first mode: cos(k L) cosh(k L) = -1

/// The first mode of a beam that is clamped at 0. It is 1 at the free end.
double mode(double x) {
    const double k = kFirst, s = k * x / kLength, ratio = (std::cos(k) + std::cosh(k)) / (std::sin(k) + std::sinh(k));
    const auto shape = [&](double a) { return std::cosh(a) - std::cos(a) - ratio * (std::sinh(a) - std::sin(a)); };
    return shape(s) / shape(k);
}

/// Times where the series rises through zero.
std::vector<double> risings(const gate::Series& series, const std::vector<double>& z) {
    std::vector<double> out;
    for (std::size_t f = 1; f < z.size(); ++f)
        if (z[f - 1] < 0 && z[f] >= 0)
            out.push_back(series.time[f] - (series.time[f] - series.time[f - 1]) * z[f] / (z[f] - z[f - 1]));
    return out;
}

/// The largest |z| in [from, to), from the parabola through the largest value and its neighbours.
double amplitude(const gate::Series& series, const std::vector<double>& z, double from, double to) {
    double largest = 0;
    for (std::size_t f = 1; f + 1 < z.size(); ++f) {
        if (series.time[f] < from || series.time[f] >= to) continue;
        const double a = std::abs(z[f - 1]), b = std::abs(z[f]), c = std::abs(z[f + 1]);
        if (b >= a && b >= c) largest = std::max(largest, b - square(c - a) / (8 * std::min(a + c - 2 * b, -1e-12)));
    }
    return largest;
}

TEST(OscillatingPlate, SwingsInItsPeriodAndKeepsItsEnergy) {
    Simulation s = make_simulation(gate::load("oscillating_plate"));
    Elements& e = s.solids.elements;
    const SolidBody& body = s.solids.bodies.front();
    for (std::size_t i = 0; i < e.size(); ++i) {
        const double x = static_cast<double>(e.rest[i].x) + body.place.x();
        if (x > 0) e.velocity[i].z = static_cast<Real>(0.15 * mode(x));
    }
    const gate::Series series = gate::run(s);
    const std::vector<double> z = series.of("tip"), zeros = risings(series, z);
    ASSERT_GE(zeros.size(), 3u);
    const double omega = square(kFirst / kLength) * std::sqrt(kModulus * square(kHeight) / 12 / kDensity);
    const double period = (zeros.back() - zeros.front()) / static_cast<double>(zeros.size() - 1);
    const double theory = 2 * std::numbers::pi / omega;
    gate::expect({"oscillating plate", "period over theory", "1", period / theory, 1, 0.1, "Euler & Bernoulli"});
    const double first = amplitude(series, z, 0, period),
                 last = amplitude(series, z, zeros.back() - period, zeros.back());
    gate::expect({"oscillating plate", "energy lost a period", "1",
                  (1 - square(last / first)) * period / (zeros.back() - period), 0, 0.005, "5 % in ten periods"});
}

}  // namespace
}  // namespace thixo
