// Rest neighbourhoods and their moment matrices. Dissertation 5.3, 5.9.1.
#pragma once

#include <functional>

#include "pipeline/geometry/power_of_two.h"
#include "sim/space/periodic.h"
#include "sim/state/solids.h"

namespace thixo {

/// Whether elements i < j of a body (by its index) are connected by matter all the way from i to j [m].
using HangTogether = std::function<bool(std::size_t, Index, Index, const Vec3&)>;

/// Two elements of a body are connected where every place between them lies in the body's rest shape. Places outside
/// count as inside up to a part of a particle's width. No bond reaches across the gap between two limbs. This is the
/// visibility criterion of Belytschko et al. 1994. In bodies that have no such shape any more, all are connected.
HangTogether hang_together_in_shapes(const Solids& solids);

/// Lists every element's neighbours in its own body, from rest and support, with weights in the stencils of both:
///     w_ij = u_i (h_j/h_i)^3 w_spiky(|r_ij|, (h_i + h_j)/2)      [1],  u_i = weight_unit(h_i)
/// Where sizes change, matter counts by its volume, and both ends see each other alike. The forces of a uniform stress
/// then nearly balance there, as they do where sizes are equal. The dissertation takes h_i alone. With that, a ball
/// sampled by an octree was squashed a sixth deeper on a floor than one of a packing, and rose less high.
/// Pairs that `hang_together` denies are no neighbours. Without it, all are connected. Endless bodies are bonded across
/// the faces of `periodic`, in the world at time 0.
void find_rest_neighbours(const std::vector<SolidBody>& bodies, Elements& elements,
                          const HangTogether& hang_together = nullptr, const Periodic& periodic = {});

/// A power of two near h^3 [m^3], by which all weights of a stencil are multiplied. Forces do not depend on it. Without
/// it a modulus times five lengths would leave the range of a float where the spacing is a micrometre or a kilometre.
inline Real weight_unit(Real h) { return cube(power_of_two_below(h)); }

/// The weight of an element of support hj in the stencil of one of support hi, r apart at rest [1].
Real rest_weight(Real hi, Real hj, Real r);

inline constexpr double kFlat = 1e-3;  // eigenvalue of A in parts of the largest: squared extents
/// The same for neighbours that do not stand on a lattice: of matter that has flowed.
inline constexpr double kThin = 0.05;
/// For stencils that change in mid-run.
inline double flatness(const Elements& e) { return e.softens ? kThin : kFlat; }

/// Measures the moments of all neighbourhoods from the lists and weights. Directions in which a neighbourhood reaches
/// less than the root of `flat` (3 %) of its largest extent are left out of A+. Those elements are listed in
/// Bonds::flat. With `which`, only elements with a 1 there are measured.
void measure_moments(Elements& elements, const std::vector<std::uint8_t>* which = nullptr, double flat = kFlat);

}  // namespace thixo
