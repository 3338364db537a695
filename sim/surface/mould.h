// The external potential: shapes that the surface is drawn to. Dissertation 6.6.2.
#pragma once

#include <vector>

#include "pipeline/geometry/shape.h"

namespace thixo {

struct Mould {
    Shape shape;
    Real weight;  // k_ext, as the scene has it [1]
    Real reach;   // [m]
};

/// What the moulds do to a surfel.
struct MouldPull {
    Real weight = 0;        // sum of k_ext over the moulds in reach [1]
    Vec3 force{0, 0, 0};    // weighted mean of -d grad d, the way to each one's surface [m]
    Vec3 outward{0, 0, 0};  // weighted mean of their normals, on the side that the surfel's is on; zero: none in reach
};

/// The moulds whose surface is nearer than their reach to x and not across to n, a surfel's unit normal: a surfel takes
/// on a face that looks its way, outwards, or inwards where it lines the mould. `step` of the gradient [m].
MouldPull pull_of_moulds(const std::vector<Mould>& moulds, const Vec3& x, const Vec3& n, Real step);

}  // namespace thixo
