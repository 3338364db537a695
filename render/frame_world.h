// From a cached frame and a look to everything a picture is made of.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "pipeline/contract/frame.h"
#include "pipeline/contract/scene.h"
#include "render/pictures.h"
#include "render/world.h"

namespace thixo::render {

/// Meshes of obstacles by asset hash, in asset space.
using AssetMeshes = std::map<std::string, TriangleMesh>;

/// The scene's materials and boundaries name the appearances of bodies and obstacles. What the scene does not know is
/// looked up under its own name, and under the obstacle's `look`. An appearance that is missing becomes a grey matt
/// one, and its name is added to `missing`. Surfels have the attributes P, t1, t2; `body` where there are several, and
/// sheet, rest, v, temperature, Cd where there are any. Places count from the origin of the surfels. Throws CacheError for missing attributes. Throws InputError for a look that
/// cannot be rendered: texture coordinates or temperatures that it needs are not there.
World make_world(const Frame& frame, const AssetMeshes& meshes, const Pictures& pictures, const scene::Scene& scene,
                 const scene::Look& look, std::vector<std::string>& missing);

}  // namespace thixo::render
