// How solids go from one step to the next: sub-steps of leapfrog, or implicit ones.
#pragma once

#include "pipeline/contract/scene.h"
#include "sim/external/outside.h"
#include "sim/solid/implicit.h"
#include "sim/space/walls.h"
#include "sim/state/particles.h"
#include "sim/state/solids.h"

namespace thixo {

/// What sub-steps did, for stats.jsonl.
struct SolidReport {
    int sub_steps = 0;
    int newton = 0, iterations = 0, unconverged = 0;  // of implicit steps
    double smallest_dt = 1e30;                        // [s]
    double contact_seconds = 0;
};

/// Room of the sub-steps, kept so that a steady simulation allocates little.
struct SolidScratch {
    StressScratch stress, flow_stress;
    ImplicitScratch implicit;
};

/// One step of everything else.
struct SolidStep {
    const scene::Scene& scene;
    const Outside& outside;
    double time, dt;  // [s]
    bool implicit = false;
};

/// From t to t + dt: sub-steps of leapfrog within what explicit integration bears, or implicit ones as long as contact
/// is foreseen. Walls, handles and what comes from outside act. Then come plastic flow, and the rest shapes follow the bodies. Walls
/// are left at t + dt.
SolidReport advance_solids(const SolidStep& step, Walls& walls, Particles& particles, Solids& solids,
                           SolidScratch& scratch);

/// Writes place, velocity v(t), density rho0/|J| and pressure -tr(sigma)/3 of every solid's particle.
void write_particles(Solids& solids, Particles& particles);

}  // namespace thixo
