// Particles inside a shape: on an octree that is finer at the surface, or on a lattice.
#pragma once

#include <vector>

#include "pipeline/geometry/shape.h"

namespace thixo {

enum class Lattice {
    octree,     ///< one particle in every leaf of a balanced octree that is finest at the surface
    hexagonal,  ///< hexagonal close packing
    uniform     ///< cubes
};

struct VolumeSampling {
    Lattice lattice = Lattice::octree;
    double spacing = 0;     // [m]; one particle per spacing^3: at the surface (octree) or everywhere (lattices)
    std::size_t count = 0;  // wanted number of particles, in place of a spacing; met to about a tenth
    int levels = 2;         // octree: cells inside may be up to 2^levels times as wide as at the surface
};

/// Element k of every array is particle k. Particles ascend in the order (z, y, x) of their cells; leaves of the octree
/// ascend by their lower corners.
struct SampledVolume {
    std::vector<Vec3> position;  // [m]
    std::vector<Real> volume;    // of its cell [m^3]; their sum is the body's volume
    std::vector<Real> spacing;   // edge of its cell: about the distance of its neighbours [m]
    double total = 0;            // the body's volume [m^3]
};

/// Particles at the centres of the cells that are inside (distance < 0).
///
/// In the octree (dissertation 5.7), cells that the surface cuts have the edge `spacing`. Wider cells are away from the
/// surface by at least one cell of every finer level. Leaves that share a face, an edge or a corner differ by at most
/// one level (2:1). The volume of a particle is the part of its cell that is inside. Volume in cells whose centres are
/// outside goes to the nearest particle. All volumes are then scaled, so that their sum is the body's volume. Throws
/// InputError where the shape is unbounded, nothing is inside, or there would be more than 2^27 cells. It also throws
/// where not exactly one of count and spacing is given.
SampledVolume sample_volume(const Shape& shape, const VolumeSampling& sampling);

/// Volume [m^3] of the part of a box along the axes that is inside. It is the sum over small boxes, each filled to the
/// part
///     clamp(1/2 - d/width, 0, 1)
double volume_inside(const Shape& shape, const Vec3& centre, const Vec3d& edges);

}  // namespace thixo
