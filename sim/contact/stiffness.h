// The stiffness of a surface in contact.
#pragma once

#include <cmath>

#include "sim/state/stress_law.h"

namespace thixo {

/// Pressure per depth of a body's surface [Pa/m]: that of the material, or that of a layer as thick as an element,
///     (lambda + 2 mu)/V^(1/3)      [Pa/m]
inline Real contact_pressure(const StressLaw& law, Real volume) {
    return law.contact_stiffness > 0 ? law.contact_stiffness : law.wave_modulus() / std::cbrt(volume);
}
/// Stiffness of the contact spring of an element, whose surface is V^(2/3), over its mass [1/s^2].
inline Real contact_stiffness(const StressLaw& law, Real volume, Real mass) {
    return contact_pressure(law, volume) * square(std::cbrt(volume)) / mass;
}

}  // namespace thixo
