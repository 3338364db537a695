// The weights of bonds: what of its base a bond has left.
#pragma once

#include <functional>

#include "sim/state/elements.h"

namespace thixo {

/// Keeps the present weights as bases, where matter may melt or crack from now on. Nothing where they are kept already
/// for these lists.
void keep_bases(Bonds& bonds);

/// Sets every weight to base x visibility x solidity, the solidity of a bond that of its softer end,
///   w_ij = base_ij visibility_ij min(solidity_i, solidity_j)
/// and measures the moments of the neighbourhoods that this changes; `flat` as in measure_moments. Requires bases.
void weigh_bonds(Elements& elements, double flat);

/// Sets the visibility of every bond, `of(i, j)` in [0, 1] and the same both ways, and weighs the bonds. Raises the
/// bonds' version: matrices and rates that were made for the old ones are made anew. The stiffness of zero-energy modes
/// follows with the laws (update_laws).
void set_visibility(Elements& elements, const std::function<Real(Index, Index)>& of);

}  // namespace thixo
