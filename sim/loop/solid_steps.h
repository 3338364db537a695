// The step of solids: sub-steps of leapfrog, or implicit ones.
#pragma once

#include <functional>

#include "sim/loop/problem.h"
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
    bool stuck = false;  // stable sub-steps are so short that the step would not end
    double dt = 0;       // how far the solids went: all of the step, or up to where it was ended [s]
};

/// Scratch of the sub-steps. It is kept, so that a steady simulation allocates little.
struct SolidScratch {
    StressScratch stress, flow_stress;
    ImplicitScratch implicit;
};

/// The step of the animation loop that the solids follow. `ends` is asked after every few sub-steps of leapfrog, and the
/// step ends there where it returns true. It may be empty.
struct SolidStep {
    const Problem& problem;
    double time, dt;  // [s]
    std::function<bool()> ends{};
};

/// Advances the solids from t to t + dt. Sub-steps of leapfrog are as long as explicit integration permits. Implicit
/// ones last as long as contact is foreseen. Walls, handles and accelerations from outside act, and matter flows
/// plastically, in every sub-step. Then comes the fit of the rest shapes to the bodies. Walls are left at the end
/// of the step.
SolidReport advance_solids(const SolidStep& step, Walls& walls, Particles& particles, Solids& solids,
                           SolidScratch& scratch);

/// Writes place, velocity v(t), density rho0/|J| and pressure -tr(sigma)/3 of the particles of all solids.
void write_particles(Solids& solids, Particles& particles);

}  // namespace thixo
