// The external potential: shapes that attract the surface. Dissertation 6.6.2.
#pragma once

#include <vector>

#include "pipeline/geometry/shape.h"

namespace thixo {

struct Mould {
    Shape shape;
    Real weight;  // k_ext, as the scene has it [1]
    Real reach;   // [m]
};

/// The force of the moulds on a surfel.
struct MouldPull {
    Real weight = 0;        // sum of k_ext over the moulds in reach [1]
    Vec3 force{0, 0, 0};    // weighted mean of -d grad d, the way to each one's surface [m]
    Vec3 outward{0, 0, 0};  // weighted mean of their normals on the side of the surfel's; zero: none in reach
};

/// Sums up the moulds whose surface is nearer to x than their reach and not at right angles to n, a surfel's unit
/// normal. A surfel takes on a face with its own direction, outwards, or inwards where it lines the mould. `step` is
/// that of the gradient [m].
MouldPull pull_of_moulds(const std::vector<Mould>& moulds, const Vec3& x, const Vec3& n, Real step);

}  // namespace thixo
