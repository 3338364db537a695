// Simulation and rendering side by side: frames are rendered as they are cached.
#pragma once

#include "pipeline/contract/stage_args.h"
#include "pipeline/driver/process.h"

namespace thixo {

struct Stages {
    SimArgs sim;
    RenderArgs render;
};

struct Display {
    bool terminal = false;  // stderr is one
    bool quiet = false;
};

/// The calls, as conduct starts them. `follow`: the simulation may still run.
ProgramCall sim_call(const Stages& stages);
ProgramCall render_call(const Stages& stages, bool follow);

/// Runs both and shows their progress as one. Rendering starts when the simulation has accepted the cache. Where the
/// simulation fails, what it cached is still rendered, and the exit code is the simulation's. Where rendering fails,
/// the simulation still goes to its end. Returns the exit code. Throws Error where a stage crashed, InterruptedError
/// after SIGINT or SIGTERM.
int conduct(const Stages& stages, Display display);

}  // namespace thixo
