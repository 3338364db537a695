// The frame of the cache, made from the simulation.
#pragma once

#include <string>
#include <vector>

#include "pipeline/contract/cache.h"
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

/// The frame of the present time. Requires evaluate() at this time. Totals are sums in double over v(t).
Frame make_frame(const Simulation& sim, const std::vector<DrawnBoundary>& boundaries);

}  // namespace thixo
