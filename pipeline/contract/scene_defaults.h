// Defaults that depend on the rest of the scene.
#pragma once

#include <string>

#include "pipeline/contract/scene_reader.h"

namespace thixo::scene {

/// Gives keys that are not in `where` the values that follow from others. For scenes whose keys have just been read:
/// - the speed of an emitter with a `rate` is 0;
/// - `volume_stiffness` of an isotropic solid is E;
/// - walls hold liquids of 1 Pa s or more (`no_slip`);
/// - the lights are a sky and a sun.
void settle_defaults(Scene& scene, const Where& where);

/// Whether a light is one that settle_defaults gives.
bool is_default_light(const Light& light);

/// Fills in what is meant by a name: the scene's, from its file's, and appearances. Where the camera has neither
/// position nor look_at, it sees the whole scene (extent_of). For scenes that are sound: check_scene found no problem.
void fill_in(Scene& scene, const std::string& source_name, const Where& where);

}  // namespace thixo::scene
