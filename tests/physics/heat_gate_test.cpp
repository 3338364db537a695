// Heat conduction beside its analytic solutions.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/physics/gate.h"

namespace thixo {
namespace {

constexpr double kDiffusivity = 100.0 / (1000 * 1000);  // of the scenes' materials [m^2/s]

TEST(Heat, ASlabCoolsAsFourierSays) {
    // Carslaw & Jaeger, at the centre and in the mean:
    //     4/pi sum (-1)^n/(2n+1) exp(-(2n+1)^2 pi^2 Fo)
    //     8/pi^2 sum exp(-(2n+1)^2 pi^2 Fo)/(2n+1)^2
    Simulation s = make_simulation(gate::load("heat_slab"));
    const gate::Series series = gate::run(s);
    double centre = 0, mean = 0;
    const double fourier = kDiffusivity * series.time.back() / (0.1 * 0.1);
    for (int n = 0; n < 20; ++n) {
        const double odd = 2 * n + 1, decay = std::exp(-odd * odd * kPi * kPi * fourier);
        centre += 4 / kPi * (n % 2 ? -1 : 1) / odd * decay;
        mean += 8 / (kPi * kPi) / (odd * odd) * decay;
    }
    gate::expect({"heat conduction", "centre of a slab at Fo = 0.1", "degC", series.last("centre"), centre,
                  0.01 * centre, "Carslaw & Jaeger"});
    gate::expect({"heat conduction", "mean of a slab at Fo = 0.1", "degC", series.last("mean"), mean, 0.01 * mean,
                  "Carslaw & Jaeger"});
}

TEST(Heat, AMeltingFrontFollowsStefan) {
    // The wall is at T_w above the melting point T_m, the latent heat L is such that
    //     c (T_w - T_m)/L = 1
    // The front x_f then follows from
    //     x_f = 2 lambda sqrt(a t)  [m],  sqrt(pi) lambda exp(lambda^2) erf(lambda) = 1
    // Half of the melting range of 0.02 degrees belongs to the front.
    Simulation s = make_simulation(gate::load("melting_front"));
    gate::run(s);
    const double front = 2 * 0.6201 * std::sqrt(kDiffusivity * s.clock.time);
    // The place of the front comes from the molten parts of all particles: each fills its share of the length.
    double melted = 0;
    for (std::size_t i = 0; i < s.particles.size(); ++i)
        melted +=
            std::clamp(s.particles.temperature[i] / 0.02, 0.0, 1.0) * static_cast<double>(s.particles.rest_volume[i]);
    const double section =
        static_cast<double>(s.particles.size()) * static_cast<double>(s.particles.rest_volume[0]) / 0.2;
    gate::expect({"heat conduction", "melting front at Ste = 1 after 20 s", "m", melted / section, front, 0.03 * front,
                  "Stefan; Alexiades & Solomon 1993"});
}

}  // namespace
}  // namespace thixo
