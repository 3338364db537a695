// How stiff a surface is to what touches it.
#pragma once

#include <cmath>

#include "sim/state/stress_law.h"

namespace thixo {

/// Pressure per depth that a body's surface resists with [Pa/m]: the material's own, or (lambda + 2 mu)/V^(1/3), as
/// stiff as the layer of matter that an element is.
inline Real contact_pressure(const StressLaw& law, Real volume) {
    return law.contact_stiffness > 0 ? law.contact_stiffness : law.wave_modulus() / std::cbrt(volume);
}
/// Stiffness of the contact spring of an element, of surface V^(2/3), over its mass [1/s^2].
inline Real contact_stiffness(const StressLaw& law, Real volume, Real mass) {
    return contact_pressure(law, volume) * square(std::cbrt(volume)) / mass;
}

}  // namespace thixo
