// The kernels of a simulation, of one support, and the packing on which they are calibrated.
#pragma once

#include "pipeline/geometry/kernels.h"
#include "pipeline/geometry/packing.h"
#include "sim/space/wall_kernel.h"

namespace thixo {

/// SPH sums over that packing of a constant, a linear and a quadratic field [1]. All tend to 1 for a wide kernel:
///     packed_sum        sum_j spacing^3 w(|x_j|), the site at the origin included
///     packed_gradient   - sum_j spacing^3 |x_j| dw/dr / 3
///     packed_laplacian  sum_j spacing^3 |x_j|^2 lap w / 6
Real packed_sum(const Poly6& kernel, Real spacing);
Real packed_gradient(const Spiky& kernel, Real spacing);
Real packed_gradient(const Poly6& kernel, Real spacing);
Real packed_laplacian(const ViscosityKernel& kernel, Real spacing);
Real packed_sum(const ConvexSpline& kernel, Real spacing);
Real packed_gradient(const ConvexSpline& kernel, Real spacing);

/// Kernels of support h = support * spacing, each scaled so that its sum over the packing is exact. Particles of mass
/// rho0 spacing^3 then have the right mass per volume and, packed, a mean summation density of rho0. A linear pressure
/// has its exact gradient, water its hydrostatic pressure, and viscosity is the scene's. (At h = 2 spacings the bare
/// kernels give 1.013, 0.911 and 0.912.) The implicit solver takes density and pressure from one kernel, `fluid`, of
/// which only the sum can be made exact.
struct Smoothing {
    Smoothing(Real spacing, Real support);
    Real spacing;  // particle spacing of the packing [m]
    Real support;  // h [m]
    Poly6 density;
    Spiky pressure;
    ViscosityKernel viscosity;
    ConvexSpline fluid;   // density and pressure of `dfsph`
    Real fluid_gradient;  // packed_gradient of it [1]: 0.975 at h = 2 spacings
    WallKernel wall;      // of the walls with `dfsph`
};

}  // namespace thixo
