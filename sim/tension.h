// Surface tension and wetting: cohesion between particles, adhesion to walls.
#pragma once

#include <vector>

#include "pipeline/geometry/neighbour_lists.h"
#include "sim/materials.h"
#include "sim/particles.h"
#include "sim/smoothing.h"
#include "sim/sweep.h"
#include "sim/walls.h"

namespace thixo {

/// Room of one evaluation: sqrt(k) m of particles and ghosts.
struct TensionScratch {
    std::vector<Real> charge;
};

/// w(r) = 630/(pi h^3) integral_{r/h}^1 s^3 (1 - s)^3 ds, which integrates to one over its ball. Its slope, in shape the
/// cohesion of Akinci, Akinci & Teschner 2013 without a core, is greatest at h/2, where the next neighbours are, and
/// vanishes at the centre: what holds particles apart there, the pressure, is left alone. (With the spiky kernel of
/// the pressure, as dissertation 4.15 has it, cohesion and the pressure that answers it cancel pair by pair: particles
/// fall into each other, and no tension is left.)
struct CohesionKernel {
    explicit CohesionKernel(Real support)
        : h_inv(1 / support), scale(Real(630 / kPi) * cube(h_inv)), slope(scale * square(h_inv)) {}
    Real value(Real r) const {
        const Real s = r * h_inv, s4 = square(square(s));
        if (!(s < 1)) return 0;
        return scale * (Real(1.0 / 140) - s4 * (Real(0.25) - s * (Real(0.6) - s * (Real(0.5) - s / 7))));
    }
    Real h_inv, scale;
    Real slope;  // - dw/dr / r = slope s^2 (1 - s)^3
};

/// Surface tension of a packing cut at a layer, over k rho0^2 [m]: half the work of parting it, of pairs of energy
/// -k m_i m_j w. (A continuum has 0.0597 h.)
Real packed_tension(const Smoothing& smoothing);
/// The k that gives a packing its surface tension [Pa m^6/kg^2].
Real attraction_for(Real surface_tension, Real density, const Smoothing& smoothing);
/// The work of parting a packing over that of taking it off a wall, whose attraction is k rho0^2 V w_spiky integrated over
/// its volume; the first layer stands half a layer off it [1].
Real packed_adhesion(const Smoothing& smoothing);

/// Adds the accelerations f_i/m_i of cohesion and adhesion, minus the gradient of the energy
///   E = - 1/2 sum_i sum_j q_i q_j w(r_ij) - sum_i q_i sqrt(k_i) rho0_i sum_walls b a integral over the wall of w_spiky
///   q_i = sqrt(k_i) m_i,   b = (1 + cos theta)/2
/// The pair force is the cohesion of dissertation 4.15, k V_i V_j (rho_i^2 + rho_j^2)/2 grad w, with m_i for V_i rho_i,
/// so that it is the gradient of an energy whatever the densities are: both momenta and the energy are conserved. Between two materials the strength is the geometric mean (Berthelot), which leaves an
/// interface the tension (sqrt gamma_1 - sqrt gamma_2)^2. A wall attracts as the liquid itself would, b times as
/// strong: its work of adhesion is 2 gamma b, which by Young and Dupre, W = gamma (1 + cos theta), is the contact angle
/// theta; a = packed_adhesion.
/// What melts has the charge of its liquid share, sqrt(b k) m, so that solids take no part.
/// What it cannot: the attraction has an inner pressure of 8 gamma/h, dozens of times the capillary pressure of a drop of
/// some spacings, under which the packing is stiff like a soft solid. Drops hold together and carry the right pressure, but
/// do not swing freely.
/// In: sweep.place. Adds to particles.acceleration [m/s^2]. Nothing where no material has cohesion.
void add_tension(Particles& particles, const NeighbourLists& neighbours, const Walls& walls, const Smoothing& smoothing,
                 const std::vector<MaterialParams>& materials, const Sweep& sweep, TensionScratch& scratch);

}  // namespace thixo
