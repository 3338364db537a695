// The fields of a particle that sweeps over neighbours read, packed: a neighbour costs two loads instead of eight.
#pragma once

#include <vector>

#include "pipeline/base/lanes.h"
#include "pipeline/geometry/neighbour_lists.h"
#include "sim/space/periodic.h"
#include "sim/space/smoothing.h"
#include "sim/space/walls.h"
#include "sim/state/materials.h"
#include "sim/state/particles.h"

namespace thixo {

/// Particles, then their ghosts across periodic faces (periodic.h), then a dummy without volume far from everything.
/// The dummy pads the last run of a list.
struct Sweep {
    Ghosts ghosts;
    std::vector<Quad> place;    // x [m]; rest volume V0 [m^3] until compute_density has read it, then pressure P [Pa]
    std::vector<Quad> motion;   // v(t) [m/s], volume V [m^3]
    std::vector<Quad> matter;   // viscosity mu [Pa s], rho0 c [kg/(m^2 s)], -, -
    bool one_material = true;   // matter is the same everywhere
    bool mixed = false;         // not all is liquid: the following fields weigh pairs
    std::vector<Real> melt;     // b [1]
    std::vector<Real> present;  // q: 1 where density is that of the present neighbours, b elsewhere [1]
    std::vector<Real> rest_share;   // of the relative density, by rest neighbours; of particles alone [1]
    std::vector<WallEffect> walls;  // of particles alone

    /// The dummy's index.
    Index nobody() const { return static_cast<Index>(ghosts.particles + ghosts.size()); }
};

/// The surroundings of particles in a sweep: neighbours, walls, kernels and the packed fields.
struct SweepInput {
    const NeighbourLists& neighbours;
    const Walls& walls;
    const Smoothing& smoothing;
    const Sweep& sweep;
};

/// Fills place with V0, and motion but for the volumes, ghosts included. The velocity at t is the half-step velocity
/// continued by the acceleration of the step before:
///     v(t) = v(t - dt0/2) + dt0/2 a(t - dt0)
/// This is of second order, as dissertation 7.2 asks where a force needs it. The pressure of the implicit solver is an
/// impulse of its step, and must not be continued. With it (`impulses`) only particles without pressure are continued.
void pack_motion(const Particles& particles, double last_dt, bool impulses, Sweep& sweep);

}  // namespace thixo
