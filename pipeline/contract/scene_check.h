// What no single key can tell: references, and keys that must fit together.
#pragma once

#include "pipeline/contract/scene_reader.h"

namespace thixo::scene {

/// Notes every problem of a scene whose keys have been read.
void check_scene(const Scene& scene, ReadContext& context);
void check_look(const Look& look, ReadContext& context);

/// Notes meshes, and pictures of cracks, that are missing or not the ones `content` means; fills their `content`.
void read_file_hashes(Scene& scene, ReadContext& context);

/// Notes image files of a look that are missing, cannot be used, or are not the ones `content` means; fills `content`.
/// Files that a cache's scene or the look below an overlay name are not looked at: they may be gone.
void read_image_hashes(Look& look, ReadContext& context);

}  // namespace thixo::scene
