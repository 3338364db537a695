// Hexagonal close packing: the densest lattice, with layers normal to z.
#pragma once

#include "pipeline/base/math.h"

namespace thixo {

/// Distance of nearest neighbours with one site per spacing^3: 2^(1/6) spacing [m].
Real packing_distance(Real spacing);
/// Distance between two layers [m].
Real packing_layer(Real spacing);
/// Distances of sites, rows and layers along x, y, z [m].
Vec3d packing_steps(Real spacing);
/// Place of the site (i, j, k); site (0, 0, 0) is the origin. Odd rows are shifted by half a site along x, and odd
/// layers by a third of a row along y.
Vec3 packing_site(int i, int j, int k, Real spacing);

}  // namespace thixo
