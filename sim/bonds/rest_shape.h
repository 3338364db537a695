// Rest neighbourhoods and their moment matrices. Dissertation 5.3, 5.9.1.
#pragma once

#include <functional>

#include "sim/state/solids.h"

namespace thixo {

/// Whether elements i < j of a body (by its index) hang together: there is matter all the way between them.
using HangTogether = std::function<bool(std::size_t, Index, Index)>;

/// Two elements hang together where no place between them is farther out of their body's shape at rest than this part
/// of a particle's width: not across the gap between two limbs or parts of it. (The visibility criterion of
/// Belytschko et al. 1994.) Bodies that have no such shape any more: all of them.
HangTogether hang_together_in_shapes(const Solids& solids);

/// Lists of every element's neighbours in its own body, with weights in the stencils of both, from rest and support:
///   w_ij = (h_j/h_i)^3 w_spiky(|r_ij|, (h_i + h_j)/2)
/// Where sizes change, matter counts by how much of it there is and both ends see each other alike: then the forces of
/// a uniform stress nearly balance there, as they do where sizes are the same. (By h_i alone, as the dissertation has
/// it, a ball of an octree that fell on a floor was squashed a sixth deeper than one of a packing and rose less high.)
/// Those that `hang_together` (none given: all) denies are none.
void find_rest_neighbours(const std::vector<SolidBody>& bodies, Elements& elements,
                          const HangTogether& hang_together = nullptr);

/// The weight of an element of support hj in the stencil of one of support hi, r apart at rest [1/m^3].
Real rest_weight(Real hi, Real hj, Real r);

inline constexpr double kFlat = 1e-3;  // eigenvalue of A in parts of the largest: squared extents

/// Moments of all neighbourhoods from the lists and weights. Directions in which a neighbourhood reaches less than the
/// root of `flat` (3 %) of its largest extent are left out of A+: those elements are listed in Bonds::flat. `which`:
/// of elements with a 1 there alone.
void measure_moments(Elements& elements, const std::vector<std::uint8_t>* which = nullptr, double flat = kFlat);

}  // namespace thixo
