// Displacement gradients of elements whose neighbourhoods do not span space, for what is drawn.
#pragma once

#include <vector>

#include "sim/solid/elements.h"

namespace thixo {

/// Completes the gradients of the elements in Elements::flat, after find_gradients. H says nothing of the directions
/// Q = 1 - A A+ in which such an element has no neighbours (the last ones of a thin limb): taken as it is, matter
/// across a limb would stay unturned while the limb turns, and surfels there would be pressed flat and turned over.
/// They turn with the rest,
///   H <- H + (R - 1) Q,   R the rotation nearest to P + H + R' Q,
/// R' that of its neighbours' mean gradient, those first that are whole. Of a rigid motion H is then exactly R - 1.
void complete_gradients(const Elements& elements, std::vector<Mat3>& gradients);

}  // namespace thixo
