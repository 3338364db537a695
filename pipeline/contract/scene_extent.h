// About how large a scene is, from its text alone.
#pragma once

#include <functional>
#include <optional>

#include "pipeline/contract/scene.h"

namespace thixo::scene {

struct Extent {
    Vec3d lower{0, 0, 0}, upper{0, 0, 0};  // [m]
};

/// A box that holds all bodies at the start and all emitters; nothing where there are none. It also holds visible
/// boundaries that are at most four times as large. Of planes it holds the point below the middle, if that is near. It
/// may be larger than needed: turned shapes are held by turned boxes. A mesh without `height` has the size that its
/// file says, which is not read here: the answer is then nothing, too.
std::optional<Extent> extent_of(const Scene& scene);

/// The turn of a shape's or a motion's `rotate` [degrees].
Mat3d rotation(const Vec3d& degrees);

/// A plane where it stands in the world.
struct PlacedPlane {
    Vec3d on{0, 0, 0};      // a point of it [m]
    Vec3d normal{0, 0, 1};  // unit, away from the solid half-space
};
/// Nothing where the shape is no plane.
std::optional<PlacedPlane> placed_plane(const Shape& shape);

/// The box of a mesh file's places, in the units of the file.
using MeshExtent = std::function<Extent(const MeshFile&)>;

/// The same of bodies and emitters alone. Meshes that stand where their file places them are asked for.
std::optional<Extent> extent_of_matter(const Scene& scene, const MeshExtent& mesh_extent);

}  // namespace thixo::scene
