// The render stage: cached frames to pictures.
#pragma once

#include "pipeline/contract/scene.h"
#include "pipeline/contract/stage_args.h"

namespace thixo::render {

/// The scene whose look is rendered, with the look file, the overrides and the draft applied: that of args.scene, else
/// the cache's.
scene::Scene resolve_scene(const RenderArgs& args, const std::string& cache_scene_text);

/// Renders the frames asked for that are not there yet, in order; with args.follow as the cache grows. Writes
/// args.out/frames[.<look file>]/beauty.NNNN.exr and .png. Throws InputError (pictures of another look are there),
/// CacheError (a frame is missing or damaged; those that are there are rendered first), ResourceError,
/// InterruptedError.
int run_stage(const RenderArgs& args);

}  // namespace thixo::render
