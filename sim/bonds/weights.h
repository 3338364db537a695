// The weights of bonds: the part of its base weight that a bond still has.
#pragma once

#include <functional>

#include "sim/state/elements.h"

namespace thixo {

/// Keeps the present weights as bases. It is called where matter may melt or crack from then on. Bases that are already
/// kept for these lists stay.
void keep_bases(Bonds& bonds);

/// Sets every weight to base x visibility x solidity. The solidity of a bond is that of its softer end:
///     w_ij = base_ij visibility_ij min(solidity_i, solidity_j)
/// Measures the moments of the neighbourhoods that change; `flat` as in measure_moments. Requires bases.
void weigh_bonds(Elements& elements, double flat);

/// Sets the visibility of every bond, and weighs the bonds. `of(i, j)` lies in [0, 1] and is symmetric. Raises the
/// bonds' version: matrices and rates of the old bonds are then computed anew. The stiffness of zero-energy modes
/// follows with the laws (update_laws).
void set_visibility(Elements& elements, const std::function<Real(Index, Index)>& of);

}  // namespace thixo
