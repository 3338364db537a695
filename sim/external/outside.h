// Accelerations that come from outside: what acts on all matter alike, whatever it is.
#pragma once

#include "pipeline/base/math.h"

namespace thixo {

/// What there is of them in a scene.
struct Outside {
    Vec3 gravity{0, 0, 0};  // [m/s^2]
};

/// The acceleration from outside of matter at a place [m] that moves with a velocity [m/s], in the world [m/s^2]. The
/// one place for all of it: liquids (sim/liquid/forces.h), solids (sim/external/handles.h) and what changes its phase
/// (sim/phase/phases.h) ask here.
inline Vec3 acceleration_from_outside(const Outside& outside, const Vec3& /*place*/, const Vec3& /*velocity*/) {
    return outside.gravity;
}

}  // namespace thixo
