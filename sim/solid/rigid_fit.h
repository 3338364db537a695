// The rest shape follows the body's rigid motion. Dissertation 5.4.3.
#pragma once

#include "sim/state/bodies.h"

namespace thixo {

/// The rotation R that brings places m to places x best, of S = sum_j m_j m_j x_j^T about both centres.
Mat3d fitting_rotation(const Mat3d& spread);

/// Fits every body's pose to its deformed shape by least squares, weighted with the masses:
///     S = sum_j m_j m_j (x_j - xbar)^T = U W V^T
///     R = V diag(1, 1, |V U^T|) U^T,   t = xbar - R mbar
/// Displacements and velocities are taken over into the new frame. Places and motion in the world stay as they are, and
/// displacements are small.
/// `share` [1] weighs the elements' masses; none: all alike. A body whose weights are all zero keeps its pose. Rigid
/// bodies are left out: their motion is their pose's (rigid_pieces.h).
void fit_rest_shapes(std::vector<SolidBody>& bodies, Elements& elements, const std::vector<Real>* share = nullptr);

}  // namespace thixo
