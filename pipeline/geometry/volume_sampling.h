// Particles in the room a shape fills: an octree finer at the surface, or a lattice.
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
    double spacing = 0;     // [m]; one particle to every spacing^3: at the surface (octree), everywhere (the others)
    std::size_t count = 0;  // particles wanted, in place of a spacing; met to about a tenth
    int levels = 2;         // octree: cells inside may be up to 2^levels times as wide as at the surface
};

/// Element k of every array is particle k, in ascending order of cells (z, y, x; the octree's leaves by their lower
/// corners).
struct SampledVolume {
    std::vector<Vec3> position;  // [m]
    std::vector<Real> volume;    // of its cell [m^3]; their sum is the body's volume
    std::vector<Real> spacing;   // edge of its cell: about the distance of its neighbours [m]
    double total = 0;            // the body's volume [m^3]
};

/// Particles at the centres of the cells that are inside (distance < 0). The octree (dissertation 5.7): cells that the
/// surface passes have the edge `spacing`, wider ones are at least one cell of every finer level away from it; leaves
/// that share a face, an edge or a corner differ by one level at most (2:1). A cell's volume is its part inside, and
/// what lies in cells whose centres are outside goes to the nearest particles' cells; then all are scaled so that their
/// sum is the body's volume. Throws InputError where the shape is unbounded, nothing is inside, there would be more
/// than 2^27 cells, or not exactly one of count and spacing is given.
SampledVolume sample_volume(const Shape& shape, const VolumeSampling& sampling);

}  // namespace thixo
