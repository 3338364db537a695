// Handles: parts of bodies that are held, moved along keyframes, or pulled.
#pragma once

#include "sim/external/outside.h"
#include "sim/state/solids.h"

namespace thixo {

/// Anchors the handles that have begun by `time` [s]. Writes which elements are held from then on, and the
/// accelerations of the sub-steps: those from outside, and the pull of handles.
void take_hold(double time, const Outside& outside, Solids& solids);

/// Moves every held element to the place of its handle at the time `to` [s], `dt` after its present place. Its velocity
/// is leapfrog's, that of the way.
void move_held(double to, double dt, Solids& solids);

}  // namespace thixo
