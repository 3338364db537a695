// Scenes far from the world's origin, in places that count from an origin near their matter. docs/precision.md has the
// rule.
#pragma once

#include "pipeline/contract/scene.h"
#include "pipeline/contract/scene_extent.h"

namespace thixo::scene {

/// The origin that a scene's places are kept relative to [m]: 0 where its matter is near enough to the world's origin
/// for single precision. Else the middle of the matter's box, rounded to a power of ten of 100 to 1000 spacings.
Vec3d origin_for(const Scene& scene, const MeshExtent& mesh_extent);

/// The scene with its places relative to `by` [m] more: shapes, emitters, probes, periodic faces and the look. All sums
/// are of double precision. Motions keep their keys, which turn about the world's origin (`RigidMotion::seen_from`).
Scene relative_to(Scene scene, const Vec3d& by);

/// The look with camera, lamps and the corners of images relative to `by` [m].
Look relative_to(Look look, const Vec3d& by);

}  // namespace thixo::scene
