#include "sim/stage/strategy.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/loop/time_step.h"

namespace thixo {

Strategy strategy_of(const scene::Solver& solver) {
    return {.incompressible = solver.pressure == scene::Pressure::dfsph,
            .implicit_solids = solver.solids == scene::SolidSteps::implicit_euler};
}

void calm_surfaces(const Strategy& strategy, const Smoothing& smoothing, Materials& materials) {
    constexpr Real kCalm = Real(0.03);
    if (!strategy.incompressible) return;
    for (ResolvedMaterial& m : materials)
        m.viscosity = std::max(m.viscosity, kCalm * std::sqrt(m.tension * m.density * smoothing.spacing));
}

void choose_viscosity_solver(const scene::Solver& solver, const Smoothing& smoothing, double expected_speed,
                             Materials& materials) {
    const double h = smoothing.support;
    double others = std::min(solver.time_step.maximum, 0.1 * h / expected_speed), viscous = others;
    if (solver.time_step.fixed > 0) others = viscous = solver.time_step.fixed;
    const bool compressible = !strategy_of(solver).incompressible;
    for (const ResolvedMaterial& m : materials) {
        if (compressible && solver.time_step.fixed <= 0)
            others = std::min(others, solver.time_step.cfl * h / (m.sound_speed + expected_speed));
        if (m.viscosity > 0)
            viscous = std::min(viscous, viscous_limit(h, static_cast<double>(m.viscosity / m.density), compressible));
    }
    const bool implicit = solver.viscosity == scene::Viscosity::implicit_solve ||
                          (solver.viscosity == scene::Viscosity::automatic && viscous < others);
    for (ResolvedMaterial& m : materials)
        if (implicit) m.implicit_viscosity = std::exchange(m.viscosity, Real(0));
}

}  // namespace thixo
