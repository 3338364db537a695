// Handles: parts of bodies that are held, moved along keyframes, or pulled.
#pragma once

#include "sim/solid/solids.h"

namespace thixo {

/// Anchors the grips that have begun by `time` [s], and writes for [time, ...) which elements are held and the
/// accelerations held over the sub-steps: gravity and the pull of grips.
void take_hold(double time, const Vec3& gravity, Solids& solids);

/// Brings every held element to where its grip is at the time `to` [s], `dt` after it was where it is: leapfrog's
/// velocity of that way.
void move_held(double to, double dt, Solids& solids);

}  // namespace thixo
