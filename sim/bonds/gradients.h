// Displacement gradients of elements.
#pragma once

#include <vector>

#include "sim/state/elements.h"

namespace thixo {

/// The gradient of the displacement of every element, and of one:
///     H = sum_j w_ij (u_j - u_i) r_ij^T A+      [1]
void find_gradients(const Elements& elements, std::vector<Mat3>& gradients);
Mat3 gradient_of(const Elements& elements, std::size_t i);

/// The volume of an element's matter over that at rest [1]:
///     |1 + H|
/// Where the element has no neighbours in some direction, it is that of the directions it has, P = A A+:
///     sqrt |(P + H)^T (P + H) + 1 - P|
/// There |1 + H| would shrink where a thin limb only turns.
Real volume_ratio(const Elements& elements, std::size_t i, const Mat3& gradient);

/// Completes the gradients of the elements in Bonds::flat, after find_gradients. H says nothing of the directions in
/// which such an element has no neighbours (the last ones of a thin limb):
///     Q = 1 - A A+
/// Without completion, matter across a limb would stay unturned while the limb turns. Surfels there would be
/// flat and turned over. These directions therefore turn with all others:
///     H <- H + (R - 1) Q,   R the rotation nearest to P + H + R' Q
/// R' is the rotation of the mean gradient of its neighbours, those first that are complete. For a rigid motion H is
/// then exactly R - 1.
void complete_gradients(const Elements& elements, std::vector<Mat3>& gradients);

}  // namespace thixo
