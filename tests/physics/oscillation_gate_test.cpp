// An elastic beam oscillates at its natural frequency and keeps its energy.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "pipeline/geometry/packing.h"
#include "pipeline/geometry/shapes.h"
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

// ---- a free beam ------------------------------------------------------------------------------------------------------

constexpr double kFreeFirst = 4.730041;  // k L of the first mode of a free beam: cos(k L) cosh(k L) = 1

/// That mode at x in [-L/2, L/2], 1 in its middle.
double free_mode(double x) {
    const double k = kFreeFirst, s = k * x / kLength;
    const auto shape = [&](double a) { return std::cos(a) * std::cosh(k / 2) + std::cosh(a) * std::cos(k / 2); };
    return shape(s) / shape(0);
}

/// Young's modulus by the first frequency f [1/s] of a free beam of square section, for Poisson's ratio nu. ASTM
/// E 1876 (9.1), a fit to Timoshenko's beam for any ratio of thickness to length.
double modulus_by_ringing(double f, double nu) {
    const double r2 = square(kHeight / kLength), mass = kDensity * kLength * square(kHeight);
    const double correction = 1 + 6.585 * (1 + 0.0752 * nu + 0.8109 * square(nu)) * r2 - 0.868 * square(r2) -
                              8.340 * (1 + 0.2023 * nu + 2.173 * square(nu)) * square(r2) /
                                  (1 + 6.338 * (1 + 0.1408 * nu + 1.536 * square(nu)) * r2);
    return 0.9465 * mass * square(f) / kHeight * cube(kLength / kHeight) * correction;
}

/// The first frequency of a free beam, turned by degrees about x, y, z [1/s]; 0: it does not ring.
double ringing(Simulation& s, const Vec3d& degrees) {
    Elements& e = s.solids.elements;
    const Quatd rotation = rotation_from_degrees(degrees);
    const Vec3d along = rotation * Vec3d::UnitX(), up = rotation * Vec3d::UnitZ();
    std::vector<double> weight(e.size());  // of an element's displacement in the mode's
    for (std::size_t i = 0; i < e.size(); ++i) {
        const Vec3d rest = xyz(e.rest[i]).cast<double>();
        const double phi = free_mode(along.dot(rest));
        weight[i] = static_cast<double>(e.mass[i]) * phi;
        e.velocity[i] = quad((0.05 * phi * up).cast<Real>());
    }
    const auto deflection = [&] {
        double sum = 0;
        for (std::size_t i = 0; i < e.size(); ++i) sum += weight[i] * up.dot(xyz(e.displacement[i]).cast<double>());
        return sum;
    };
    std::vector<double> zeros;
    double last = 0, since = 0;
    while (s.clock.frame < s.problem.scene.frames.last) {
        advance_frame(s);
        const double now = deflection(), time = s.clock.time;
        if (last * now < 0) zeros.push_back(since + (time - since) * last / (last - now));
        last = now;
        since = time;
    }
    return zeros.size() < 3 ? 0 : 1 / (zeros[2] - zeros[0]);
}

/// Modulus over the material's by how a beam of a spacing [m] rings, turned by degrees about x, y, z.
double stiffness_in_bending(double spacing, const Vec3d& degrees) {
    const auto turn =
        std::to_string(degrees.x()) + "," + std::to_string(degrees.y()) + "," + std::to_string(degrees.z());
    Simulation s = make_simulation(gate::load(
        "free_beam", {"solver.spacing=" + std::to_string(spacing), "bodies.beam.shape.rotate=[" + turn + "]"}));
    return modulus_by_ringing(ringing(s, degrees), 0.3) / kModulus;
}

TEST(FreeStrip, IsAsStiffInBendingAsPlaneStrainHasIt) {
    // A plane beam of E/(1 - nu^2) and nu/(1 - nu), at two numbers of layers.
    for (const std::string spacing : {"0.004", "0.003"}) {
        Simulation s = make_simulation(gate::load("free_strip", {"solver.spacing=" + spacing}));
        const double stiffness = modulus_by_ringing(ringing(s, {0, 0, 0}), 0.3 / 0.7) / (kModulus / (1 - square(0.3)));
        gate::expect({"free strip in plane strain, spacing " + spacing + " m", "stiffness in bending over the law's",
                      "1", stiffness, 1, 0.03, "ASTM E 1876, plane strain"});
    }
}

TEST(FreeBeam, IsAsStiffInBendingAtAnySpacing) {
    // Four to nine layers, at spacings chosen at random; three beams lie across the axes besides.
    std::mt19937 random(1876);
    std::uniform_real_distribution<double> layers(3.6, 9.4), angle(0, 90);
    for (int k = 0; k < 13; ++k) {
        const double spacing = kHeight / layers(random) / static_cast<double>(packing_layer(1));
        const bool across = k >= 10;
        const Vec3d turn = across ? Vec3d(angle(random), angle(random), angle(random)) : Vec3d(0, 0, 0);
        const std::string law = "free beam, spacing " + std::to_string(1000 * spacing).substr(0, 5) + " mm";
        gate::expect({across ? law + ", across the axes" : law, "stiffness in bending over the law's", "1",
                      stiffness_in_bending(spacing, turn), 1, 0.03, "ASTM E 1876"});
    }
}

}  // namespace
}  // namespace thixo
