// The stage: from a scene to a cache, frame by frame, from where the last run stopped.
#pragma once

#include "pipeline/contract/stage_args.h"

namespace thixo {

/// Runs as the arguments say, and returns the exit code. Frames first..last are cached (--frames limits the last). Each
/// frame's files are written before the manifest, the manifest before a checkpoint. A cache of the same simulation is
/// continued, with the bytes of an uninterrupted run. A cache of another one is an InputError that names the keys that
/// differ. On SIGINT or SIGTERM the state of the last frame is saved and InterruptedError thrown. Throws the types of
/// pipeline/base/error.h.
int run_simulation(const SimArgs& args);

}  // namespace thixo
