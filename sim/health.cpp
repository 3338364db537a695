#include "sim/health.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"

namespace thixo {
namespace {

constexpr double kAbsurd = 10;  // speeds of sound: beyond, no time step of ours is meant for it

double speed(const Quad& v) {
    return std::sqrt(square(static_cast<double>(v.x)) + square(static_cast<double>(v.y)) +
                     square(static_cast<double>(v.z)));
}

/// The first quantity of particle i that is wrong, in the order a step computes them; null where all is well.
const char* wrong_term(const Simulation& s, std::size_t i, double fastest) {
    const Particles& p = s.particles;
    if (!p.position[i].allFinite()) return "position";
    if (!(speed(s.sweep.motion[i]) <= fastest)) return "velocity";
    if (!std::isfinite(p.density[i])) return "density";
    if (!std::isfinite(p.pressure[i])) return "pressure";
    if (!p.acceleration[i].allFinite()) return "acceleration";
    return nullptr;
}

std::string likely_cause(const Simulation& s, const StepLimits& limits) {
    const double fixed = s.problem.scene.solver.time_step.fixed;
    if (fixed > limits.smallest())
        return fmt::format("solver.time_step.fixed of {:.3g} s is above the {} limit of {:.3g} s", fixed,
                           limits.cause(), limits.smallest());
    if (s.clock.step < 10) return "particles start too close to each other, or inside a wall";
    if (s.problem.scene.solver.pressure == scene::Pressure::dfsph)
        return "a moving wall squeezes the fluid, or the pressure solve ends at solver.iterations (cut_off in stats.jsonl)";
    if (s.problem.scene.solver.artificial_viscosity < 0.01)
        return "solver.artificial_viscosity is too small for an impact of this speed";
    return "a moving wall squeezes the fluid, or solver.expected_speed is too small: the fluid is too soft for this "
           "flow";
}

}  // namespace

void check_health(const Simulation& s, const StepLimits& limits) {
    double sound = 0;
    for (const MaterialParams& m : s.problem.materials) sound = std::max(sound, static_cast<double>(m.sound_speed));
    const double fastest = kAbsurd * std::max(sound, s.problem.expected_speed);
    const std::size_t n = s.particles.size();
    const std::size_t first = parallel_reduce(
        n, n, [&](std::size_t i) { return wrong_term(s, i, fastest) ? i : n; },
        [](std::size_t a, std::size_t b) { return std::min(a, b); });
    if (first == n) return;
    const scene::Scene& scene = s.problem.scene;
    const Vec3& x = s.particles.position[first];
    throw DivergedError(
        "the simulation diverged: {} of particle {} at ({:.4g}, {:.4g}, {:.4g}) m on the way to frame {}, step {} (dt "
        "{:.3g} s, limit {:.3g} s, "
        "speed {:.3g} m/s)\nlikely: {}\nreplay: thixo sim {} --frames {}-{}",
        wrong_term(s, first, fastest), s.particles.id[first], x.x(), x.y(), x.z(), s.clock.frame + 1, s.clock.step,
        s.clock.last_dt, limits.smallest(), speed(s.sweep.motion[first]), likely_cause(s, limits),
        s.problem.scene_path.empty() ? scene.name : s.problem.scene_path, scene.frames.first, s.clock.frame + 1);
}

}  // namespace thixo
