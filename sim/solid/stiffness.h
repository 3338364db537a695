// The stiffness of elastic bodies: how their forces change with small displacements. Dissertation 5.3; Mueller et al.
// 2004.
#pragma once

#include "sim/solid/elasticity.h"

namespace thixo {

/// Which terms of the tangent are taken.
enum class Tangent {
    exact,    // all: minus the derivative of the forces
    definite  // only those that are never negative: compressive stress and the second part of the volume term are
              // left out. It converges slower, and always to a minimum
};

/// The tangent of all stencils at one state. It is never stored as a matrix. A row of the matrix would have about 260
/// blocks (neighbours of neighbours): ten kilobytes a particle, read in every product. This form reads 64 bytes and the
/// stencils, which exist already. A product takes no longer than a force sweep.
struct Stiffness {
    struct At {
        Mat3 j;            // J
        Symmetric stress;  // sigma, as the tangent takes it [Pa]
        Real dilatation;   // |J| - 1, as the tangent takes it [1]
    };
    std::vector<At> at;
    std::vector<StressLaw> laws;
    StressScratch scratch;
};

/// Linearises at elements.displacement and velocity, for steps of dt [s] backwards in time. Viscosity eta adds eta/dt
/// to mu, and its own stress.
void linearise(const std::vector<StressLaw>& laws, const Elements& elements, double dt, Tangent tangent,
               Stiffness& stiffness);

/// Computes -K du [N], K minus the derivative of find_stress_forces. With dH the gradient of du,
///     dsigma = C (J^T dH + dH^T J)/2
///     dP = dH sigma + J dsigma + k_v ((cof J : dH) cof J + (|J| - 1) d(cof J))
/// Each stencil has -V dP A+ in the place of its F. K is symmetric.
void multiply(const Elements& elements, Stiffness& stiffness, const std::vector<Quad>& du, std::vector<Vec3>& out);

/// dP of element i in the unstrained rest shape, for the gradient dh.
Mat3 stress_change_at_rest(const StressLaw& law, const Elements& elements, std::size_t i, const Mat3& dh);

/// The 3x3 blocks of K on the diagonal, in the unstrained rest shape: of elasticity [N/m], and of viscosity [N s/m].
void find_diagonal(const std::vector<StressLaw>& laws, const Elements& elements, std::vector<Symmetric>& elastic,
                   std::vector<Symmetric>& viscous);

}  // namespace thixo
