// Surface tension measured by the pressure in a drop.
#include <fmt/core.h>
#include <gtest/gtest.h>

#include "tests/physics/gate.h"
#include "tests/sim/fixture.h"

namespace thixo {
namespace {

// Mean pressure in the inner half of a drop about the origin, of all its pair forces (virial) [Pa]:
//   1/(6 V) sum_i sum_j r_ij.f_ij
// Pressure and cohesion are each some twenty times as large as their difference.
double inner_pressure(const Simulation& s, double radius) {
    const CohesionKernel cohesion(s.problem.smoothing.support);
    const Spiky& spiky = s.problem.smoothing.pressure;
    const auto& p = s.particles;
    double virial = 0, volume = 0;
    for (std::size_t i = 0; i < p.size(); ++i) {
        if (static_cast<double>(p.position[i].norm()) > 0.5 * radius) continue;
        const Real own = s.sweep.motion[i].w;
        volume += static_cast<double>(own);
        for (const Index j : s.neighbours[i]) {
            const Real r = (p.position[i] - p.position[j]).norm(), q = r * cohesion.h_inv;
            const Real push = -own * s.sweep.motion[j].w * (p.pressure[i] + p.pressure[j]) * spiky.derivative(r);
            const Real pull = s.problem.materials[0].attraction * p.mass[i] * p.mass[j] * cohesion.slope * r *
                              square(q) * cube(std::max(1 - q, Real(0)));
            virial += static_cast<double>(r * (push - pull));
        }
    }
    return virial / (6 * volume);
}

// Free of gravity and walls nothing may come or go: against the sums of the magnitudes.
void report_budgets(const Simulation& s, double radius) {
    Vec3d momentum(0, 0, 0), angular(0, 0, 0);
    double momenta = 0, kinetic = 0;
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        const double m = s.particles.mass[i];
        const Vec3d v = s.particles.velocity[i].cast<double>(), x = s.particles.position[i].cast<double>();
        momentum += m * v;
        angular += m * x.cross(v);
        momenta += m * v.norm();
        kinetic += 0.5 * m * v.squaredNorm();
    }
    const auto of = [&](const char* what) { return fmt::format("{} at R = {:.1f} mm", what, 1e3 * radius); };
    gate::report("drop", of("momentum over that of its parts"), "1", momentum.norm() / momenta);
    gate::report("drop", of("angular momentum over R times that"), "1", angular.norm() / (radius * momenta));
    gate::report("drop", of("kinetic energy over that of its surface"), "1", kinetic / (4 * kPi * square(radius)));
}

TEST(Drop, PressureInsideIsThatOfItsSurfaceTension) {
    // 2 gamma/R at three radii of 5 to 9 spacings, free of gravity, mean of six instants. The tension is that of a
    // packing cut between two layers; a drop's surface is no such layer and its particles settle as they can: 25 %
    // for one drop, 15 % for the mean of three.
    constexpr double kTension = 1, kSpacing = 0.005;
    double mean = 0;
    for (const double wanted : {0.025, 0.035, 0.045}) {
        scene::Scene scene = fixture::empty_space();
        scene.solver.spacing = kSpacing;
        scene.bodies = {fixture::body("drop", fixture::shape_at({0, 0, 0}, scene::Sphere{wanted}))};
        scene.materials[0].surface_tension = kTension;
        scene.materials[0].viscosity = 0.5;
        Simulation s = make_simulation(scene);
        const double radius = std::cbrt(static_cast<double>(s.particles.size()) * cube(kSpacing) * 3 / (4 * kPi));
        double sum = 0;
        for (int f = 0; f < 12; ++f) {
            advance_frame(s);
            if (f >= 6) sum += inner_pressure(s, radius) / 6;
        }
        const double tension = sum * radius / 2;
        gate::expect({"drop", fmt::format("tension from the pressure at R = {:.1f} mm", 1e3 * radius), "N/m", tension, kTension,
                      0.25 * kTension, "Young & Laplace"});
        report_budgets(s, radius);
        mean += tension / 3;
    }
    gate::expect({"drop", "tension from the pressure, mean of three", "N/m", mean, kTension, 0.15 * kTension, "Young & Laplace"});
}

}  // namespace
}  // namespace thixo
