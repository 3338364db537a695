// The stiffness of elastic bodies: how their forces change with small displacements. Dissertation 5.3; Mueller et al.
// 2004.
#pragma once

#include "sim/solid/elasticity.h"

namespace thixo {

/// Which terms of the tangent are taken.
enum class Tangent {
    exact,    // all: minus the derivative of the forces
    definite  // those that are never negative: the stress of what is pressed, and the second part of the volume term,
              // are left out. Slower to converge with, and never astray
};

/// The tangent of all stencils at one state. It is never stored as a matrix: each of the rows would have some 260
/// blocks (neighbours of neighbours), ten kilobytes a particle to be read for every product, while this needs 64 bytes,
/// the stencils that are there already, and no longer than a force sweep takes.
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

/// At elements.displacement and velocity, for steps of dt [s] backwards in time: viscosity eta adds eta/dt to mu, and
/// its stress.
void linearise(const std::vector<StressLaw>& laws, const Elements& elements, double dt, Tangent tangent,
               Stiffness& stiffness);

/// -K du [N], K minus the derivative of find_stress_forces: with dH the gradient of du,
///   dsigma = C (J^T dH + dH^T J)/2,   dP = dH sigma + J dsigma + k_v ((cof J : dH) cof J + (|J| - 1) d(cof J))
/// and each stencil's -V dP A+ in the place of its F. Symmetric.
void multiply(const Elements& elements, Stiffness& stiffness, const std::vector<Quad>& du, std::vector<Vec3>& out);

/// dP of element i unstrained, for the gradient dh.
Mat3 stress_change_at_rest(const StressLaw& law, const Elements& elements, std::size_t i, const Mat3& dh);

/// The 3x3 blocks of K on the diagonal, in the unstrained rest shape: of elasticity, and of a viscosity of 1/s.
void find_diagonal(const std::vector<StressLaw>& laws, const Elements& elements, std::vector<Symmetric>& elastic,
                   std::vector<Symmetric>& viscous);

}  // namespace thixo
