// Accelerations from outside, which act on all matter alike.
#pragma once

#include "pipeline/contract/scene_simulation.h"

namespace thixo {

/// The accelerations from outside in a scene.
struct Outside {
    Vec3 gravity{0, 0, 0};  // [m/s^2]
};

inline Outside outside_of(const scene::World& world) { return {.gravity = world.gravity.cast<Real>()}; }

/// The acceleration from outside of matter at a place [m] that moves with a velocity [m/s], in the world [m/s^2]. It is
/// computed here alone. Liquids (sim/liquid/forces.h), solids (sim/external/handles.h) and matter that changes its
/// phase (sim/phase/phases.h) call this function.
inline Vec3 acceleration_from_outside(const Outside& outside, const Vec3& /*place*/, const Vec3& /*velocity*/) {
    return outside.gravity;
}

}  // namespace thixo
