#include "sim/loop/time_step.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "pipeline/base/parallel.h"

namespace thixo {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

double over(double a, double b) { return b > 0 ? a / b : kNone; }

struct Extremes {
    double speed2 = 0, acceleration2 = 0;  // [m^2/s^2], [m^2/s^4]
};

std::array<std::pair<double, const char*>, 5> named(const StepLimits& l) {
    return {{{l.signal, "signal"},
             {l.motion, "motion"},
             {l.viscosity, "viscosity"},
             {l.force, "force"},
             {l.maximum, "maximum"}}};
}

}  // namespace

double StepLimits::smallest() const { return std::min({signal, motion, viscosity, force, maximum}); }

const char* StepLimits::cause() const {
    for (const auto& [value, name] : named(*this))
        if (value == smallest()) return name;
    return "none";
}

StepLimits step_limits(const Particles& particles, const Sweep& sweep, const Materials& materials,
                       const Smoothing& smoothing, const scene::TimeStep& params, double wall_speed) {
    const Extremes e = parallel_reduce(
        particles.size(), Extremes{},
        [&](std::size_t i) {
            const Quad& v = sweep.motion[i];
            return Extremes{square(v.x) + square(v.y) + square(v.z), particles.acceleration[i].squaredNorm()};
        },
        [](const Extremes& a, const Extremes& b) {
            return Extremes{std::max(a.speed2, b.speed2), std::max(a.acceleration2, b.acceleration2)};
        });
    double sound = 0, thickness = 0;  // [m/s], [m^2/s]
    for (const ResolvedMaterial& m : materials) {
        sound = std::max(sound, static_cast<double>(m.sound_speed));
        thickness = std::max(thickness, static_cast<double>(m.viscosity / m.density));
    }
    const double h = smoothing.support;
    StepLimits limits;
    limits.fastest = std::max(std::sqrt(e.speed2), wall_speed);
    limits.signal = over(params.cfl * h, sound + limits.fastest);
    limits.motion = over((sound > 0 ? 0.1 : params.cfl / 2) * h, limits.fastest);
    limits.viscosity = viscous_limit(h, thickness, sound > 0);
    limits.force = 0.25 * std::sqrt(over(h, std::sqrt(e.acceleration2)));
    limits.maximum = params.maximum;
    return limits;
}

double divide_evenly(double remaining, double limit) {
    // The margin is for rounding: a step that fits n times must not become n + 1 steps.
    const double n = std::max(1.0, std::ceil(remaining / limit * (1 - 1e-9)));
    return remaining / n;
}

}  // namespace thixo
