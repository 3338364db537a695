#include "sim/loop/plan.h"

#include <algorithm>

#include "sim/loop/coupling.h"

namespace thixo {

Plan plan_step(const Simulation& sim) {
    Plan plan;
    plan.liquid = sim.solids.empty() || any_liquid(sim.particles);
    plan.neighbours =
        plan.liquid || (sim.problem.heat.any() && sim.particles.size() > 0) || sim.solids.softening.freezes;
    plan.pressure_solve = plan.liquid && sim.problem.strategy.incompressible;
    plan.viscosity_solve = plan.liquid && std::ranges::any_of(sim.problem.materials, [](const ResolvedMaterial& m) {
                               return m.implicit_viscosity > 0;
                           });
    plan.solids = !sim.solids.empty() && sim.solids.softening.moves;
    return plan;
}

}  // namespace thixo
