// Handles: parts of bodies that are held, moved along keyframes, or pulled.
#pragma once

#include "sim/external/outside.h"
#include "sim/state/solids.h"

namespace thixo {

/// Anchors the handles that have begun by `time` [s], and writes for [time, ...) which elements are held and the
/// accelerations held over the sub-steps: those from outside, and the pull of handles.
void take_hold(double time, const Outside& outside, Solids& solids);

/// Brings every held element to where its handle is at the time `to` [s], `dt` after it was where it is: leapfrog's
/// velocity of that way.
void move_held(double to, double dt, Solids& solids);

}  // namespace thixo
