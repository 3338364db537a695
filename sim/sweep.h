// What the sweeps over neighbours read of a particle, packed so that a neighbour costs three cache-line-friendly loads instead of ten.
#pragma once

#include <vector>

#include "sim/materials.h"
#include "sim/particles.h"
#include "sim/walls.h"

namespace thixo {

/// Four scalars side by side.
struct alignas(4 * sizeof(Real)) Quad {
    Real x, y, z, w;
};

struct Sweep {
    std::vector<Quad> place;    // x [m], rest volume V0 [m^3]
    std::vector<Quad> motion;   // v(t) [m/s], volume V [m^3]
    std::vector<Quad> matter;   // pressure P [Pa], viscosity mu [Pa s], rho0 c [kg/(m^2 s)], -
    std::vector<WallEffect> walls;
};

/// Fills place, and motion but for the volumes. v(t) is the half-step velocity carried on by the acceleration of the step before:
///   v(t) = v(t - dt0/2) + dt0/2 a(t - dt0)
/// second order in the step, as dissertation 7.2 asks where a force needs it.
void pack_motion(const Particles& particles, double last_dt, Sweep& sweep);

}  // namespace thixo
