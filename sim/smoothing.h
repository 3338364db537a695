// The three kernels of a simulation, of one support, and the packing they are calibrated on.
#pragma once

#include "pipeline/geometry/kernels.h"

namespace thixo {

/// Distance of nearest neighbours in a hexagonal close packing with one particle per spacing^3: 2^(1/6) spacing [m].
Real packing_distance(Real spacing);

/// sum_j spacing^3 w(|x_j|) over the sites of that packing, the site at the origin included [1]. Tends to 1 for a wide kernel.
Real packed_sum(const Poly6& kernel, Real spacing);

/// Kernels of support h = support * spacing. Poly6 is scaled so that packed_sum is exactly 1: particles of mass rho0 spacing^3 then have both
/// the right mass per volume and, packed, a mean summation density of rho0 (at h = 2 spacings the bare kernel gives 1.013 rho0).
/// Pressure and viscosity kernels keep their integral of one.
struct Smoothing {
    Smoothing(Real spacing, Real support);
    Real spacing;            // particle spacing at rest [m]
    Real support;            // h [m]
    Poly6 density;
    Spiky pressure;
    ViscosityKernel viscosity;
};

}  // namespace thixo
