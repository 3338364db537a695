// What steps did, for stats.jsonl.
#pragma once

#include <cstdint>

#include "sim/surface/surface.h"

namespace thixo {

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
    double cracks_seconds = 0;
    int cracks_begun = 0, fragments = 0;                                // new cracks, new bodies
    int solid_newton = 0, solid_iterations = 0, solid_unconverged = 0;  // of implicit steps
    std::int64_t pairs = 0, particle_steps = 0;
    int surface_updates = 0;
    SurfaceReport surface;          // counts summed, the rest of the last update
    std::int64_t passed_walls = 0;  // particles that a step carried through a wall
    int long_steps = 0;             // fixed steps above the limit of the state
    double overstep = 0;            // the largest of them over its limit [1]
    const char* overstepped = "";   // that limit
};

}  // namespace thixo
