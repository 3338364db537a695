// The rest shape follows the body as a whole. Dissertation 5.4.3.
#pragma once

#include "sim/state/bodies.h"

namespace thixo {

/// Fits every body's pose to its deformed shape by the masses' least squares,
///   S = sum_j m_j m_j (x_j - xbar)^T = U W V^T,   R = V diag(1, 1, |V U^T|) U^T,   t = xbar - R mbar
/// and takes the displacements and velocities over into the new frame, so that places and motion in the world stay what
/// they are and displacements are small.
/// `share` [1] weighs the elements' masses; none: all alike. A body whose weights are all zero stays in its pose.
void fit_rest_shapes(std::vector<SolidBody>& bodies, Elements& elements, const std::vector<Real>* share = nullptr);

}  // namespace thixo
