#include "sim/loop/plan.h"

#include <algorithm>

#include "sim/loop/coupling.h"

namespace thixo {

Plan plan_step(const Simulation& s) {
    Plan plan;
    plan.liquid = s.solids.empty() || any_liquid(s.particles);
    plan.neighbours = plan.liquid || (s.problem.heat.any() && s.particles.size() > 0) || s.solids.softening.freezes;
    plan.pressure_solve = plan.liquid && s.problem.strategy.incompressible;
    plan.viscosity_solve = plan.liquid && std::ranges::any_of(s.problem.materials, [](const MaterialParams& m) {
                               return m.implicit_viscosity > 0;
                           });
    plan.solids = !s.solids.empty() && s.solids.softening.moves;
    return plan;
}

}  // namespace thixo
