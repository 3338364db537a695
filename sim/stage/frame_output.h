// The frame of the cache, made from the simulation.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pipeline/contract/cache.h"
#include "pipeline/geometry/shape.h"
#include "sim/loop/simulation.h"

namespace thixo {

/// A boundary as it is drawn. Its mesh is in the cache once; a frame holds its pose.
struct DrawnBoundary {
    std::string name, look, asset;  // asset: hash of the mesh in the cache
    RigidMotion motion;
};

/// Tessellates every visible boundary and stores its mesh in the cache. A room's mesh shows its inner side. An
/// unbounded boundary that is not a plane cannot be drawn: a warning says so.
std::vector<DrawnBoundary> store_boundaries(const scene::Scene& scene, CacheWriter& cache);

/// Says that an appearance does not show the colours of the mesh that it is of.
void tell_of_hidden_colours(const scene::Scene& scene, const std::string& path, const std::string& look);

/// Of each body of the scene, its shape where that is of meshes with coloured vertices.
using ColouredShapes = std::vector<std::optional<Shape>>;
ColouredShapes coloured_shapes(const scene::Scene& scene);

/// The frame of the present time. Requires evaluate() at this time. Totals are sums in double over v(t). Where a shape
/// has colours, surfels have `Cd`: the colour of where they were made.
Frame make_frame(const Simulation& sim, const std::vector<DrawnBoundary>& boundaries,
                 const ColouredShapes& coloured = {});

}  // namespace thixo
