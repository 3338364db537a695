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

/// The visibility of one bond, for weaken_bonds.
struct WeakBond {
    Index first, second;  // elements
    Real visibility;      // at most this is left [1]
};
/// Lowers the visibility of these bonds, never raising one, and weighs the bonds if any has changed. Pairs that are not
/// bonded are passed over. Raises the bonds' version as set_visibility does.
void weaken_bonds(const std::vector<WeakBond>& weak, Elements& elements);

/// Sets the visibility of every bond, and weighs the bonds. `of(i, j)` lies in [0, 1] and is symmetric. Raises the
/// bonds' version: matrices and rates of the old bonds are then computed anew. The stiffness of zero-energy modes
/// follows with the laws (update_laws).
void set_visibility(Elements& elements, const std::function<Real(Index, Index)>& of);

}  // namespace thixo
