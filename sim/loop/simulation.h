// Everything a simulation is made of: the problem, the state, and what a step computes on the way.
#pragma once

#include <vector>

#include "pipeline/geometry/neighbour_lists.h"
#include "pipeline/geometry/point_grid.h"
#include "sim/fracture/crack_step.h"
#include "sim/fracture/fragments.h"
#include "sim/liquid/pressure_solver.h"
#include "sim/liquid/viscosity_solver.h"
#include "sim/loop/coupling.h"
#include "sim/loop/passages.h"
#include "sim/loop/problem.h"
#include "sim/loop/solid_steps.h"
#include "sim/loop/step_stats.h"
#include "sim/space/sweep.h"
#include "sim/state/clock.h"
#include "sim/surface/mixed_surface.h"

namespace thixo {

struct Simulation {
    Problem problem;
    Walls walls;

    Clock clock{};
    Particles particles{};
    std::vector<EmitterState> emitters{};
    SurfaceState surface{};
    MixedSurface mixed_surface{};  // where not all is liquid; `surface` is then made from it
    Solids solids{};               // empty where no body is solid
    EmbeddedSurface embedded{};    // of the solids
    std::int64_t next_id = 0;      // of the next particle

    // Scratch of a step: nothing of it outlives the step.
    std::vector<Vec3> places{};  // of particles and ghosts; empty without periodic axes [m]
    PointGrid grid{};
    NeighbourLists neighbours{};
    Sweep sweep{};
    ElasticState elastic_state{};
    SolidScratch solid_scratch{};
    CrackScratch crack_scratch{};
    TensionScratch tension{};
    ViscosityScratch viscosity{};
    HeatScratch heat{};
    PressureSystem pressure_system{};
    SolveScratch solve_scratch{};
    ReorderScratch reorder_scratch{};
    std::vector<Index> embedded_source{};  // of each surfel the one of `embedded` it is, or is a part of
    Probes probes{};                       // nothing of it outlives a frame
    StepStats stats{};
};

/// The emitters of a simulation, and what they release into.
inline Sources sources_of(const Simulation& sim) {
    const Problem& p = sim.problem;
    return {p.scene.emitters, p.emitters, p.smoothing, sim.walls, p.outside.gravity, p.periodic, p.scene.solver.seed};
}

/// The tables of a simulation's solid matter, for what changes them in mid-run (sim/fracture).
inline Matter matter_of(Simulation& sim) {
    const scene::Scene& scene = sim.problem.scene;
    return {sim.particles,
            sim.solids,
            sim.embedded,
            sim.problem.smoothing,
            sim.next_id,
            scene.solver.seed,
            scene.surface.radius * scene.solver.spacing};
}

}  // namespace thixo
