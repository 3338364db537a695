// Everything a simulation is made of: the problem, the state, and what a step computes on the way.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/contract/scene.h"
#include "pipeline/geometry/neighbour_lists.h"
#include "pipeline/geometry/point_grid.h"
#include "sim/heat/heat.h"
#include "sim/liquid/pressure_solver.h"
#include "sim/liquid/tension.h"
#include "sim/liquid/viscosity_solver.h"
#include "sim/loop/coupling.h"
#include "sim/loop/passages.h"
#include "sim/external/outside.h"
#include "sim/fracture/fragments.h"
#include "sim/loop/solid_steps.h"
#include "sim/loop/time_step.h"
#include "sim/sources/emitter.h"
#include "sim/space/periodic.h"
#include "sim/space/smoothing.h"
#include "sim/space/sweep.h"
#include "sim/space/walls.h"
#include "sim/state/clock.h"
#include "sim/state/materials.h"
#include "sim/state/particles.h"
#include "sim/state/solids.h"
#include "sim/surface/embedded_surface.h"
#include "sim/surface/mixed_surface.h"
#include "sim/surface/surface.h"

namespace thixo {

/// What does not change during a run.
struct Problem {
    scene::Scene scene;
    Strategy strategy;
    std::string scene_path;  // as the user wrote it, for messages; may be empty
    Smoothing smoothing;
    TensionScale tension;
    std::vector<MaterialParams> materials;
    HeatParams heat;
    std::vector<Mould> moulds;
    Outside outside;
    Periodic periodic;
    double expected_speed = 0;            // U [m/s]
    std::vector<EmitterLayout> emitters;  // one per scene emitter
};

/// Pressure solves of one kind since they were last taken.
struct SolveStats {
    int solves = 0, most = 0, cut_off = 0;  // most: iterations of one solve; cut_off: ended by solver.iterations
    std::int64_t iterations = 0;
    double residual = 0;  // largest [1]
};

/// Sums since they were last taken, for stats.jsonl; never part of the state.
struct StepStats {
    int steps = 0;
    double smallest_dt = 1e30, largest_dt = 0;  // [s]
    const char* limit = "";                     // what set the smallest step
    double fastest = 0;                         // largest particle speed [m/s]
    SolveStats divergence, density;             // of `dfsph`
    double neighbours_seconds = 0, density_seconds = 0, forces_seconds = 0, viscosity_seconds = 0, pressure_seconds = 0,
           integration_seconds = 0, surface_seconds = 0;
    int viscosity_iterations = 0, viscosity_unconverged = 0;  // iterations, and solves that did not reach the tolerance
    double viscosity_residual = 0;                            // largest [1]
    double heat_seconds = 0;
    int heat_steps = 0;
    double solids_seconds = 0, contact_seconds = 0;  // the latter in the former
    int solid_sub_steps = 0;
    int solid_newton = 0, solid_iterations = 0, solid_unconverged = 0;  // of implicit steps
    std::int64_t pairs = 0, particle_steps = 0;
    int surface_updates = 0;
    SurfaceReport surface;  // counts summed, the rest of the last update
};

struct Simulation {
    Problem problem;
    Walls walls;

    Clock clock{};
    Particles particles{};
    std::vector<EmitterState> emitters{};
    SurfaceState surface{};
    MixedSurface mixed_surface{};  // where not all is liquid; `surface` is then made from it
    Solids solids{};               // empty where no body is solid
    EmbeddedSurface embedded{};    // theirs; does not change
    std::int64_t next_id = 0;

    // Scratch of a step, nothing of it outlives the step.
    std::vector<Vec3> places{};  // of particles and ghosts; empty without periodic axes [m]
    PointGrid grid{};
    NeighbourLists neighbours{};
    Sweep sweep{};
    ElasticState elastic_state{};
    SolidScratch solid_scratch{};
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

/// The tables of a simulation's solid matter, for what changes them in mid-run (sim/fracture).
inline Matter matter_of(Simulation& s) {
    const scene::Scene& scene = s.problem.scene;
    return {s.particles,       s.solids,          s.embedded, s.problem.smoothing,
            scene.solver.seed, scene.surface.radius * scene.solver.spacing};
}

}  // namespace thixo
