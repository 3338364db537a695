// The constants that the stress of a material needs at one instant.
#pragma once

#include "pipeline/base/math.h"

namespace thixo {

/// Resolved from the scene's elastic block by law_at (sim/solid/laws.h).
struct StressLaw {
    Real lambda = 0, mu = 0;     // Lame [Pa]
    Real volume_stiffness = 0;   // k_v [Pa]
    Real viscosity = 0;          // [Pa s]
    Real zero_energy = 0;        // modulus of the zero-energy modes [Pa]
    Real yield = 0;              // k_yield [1]
    Real creep = 0;              // k_creep [1/s]
    Real most_plastic = 0;       // largest norm of eps^p [1]; 0: no limit
    Real friction = 0;           // [1]
    Real contact_damping = 0;    // of critical [1]
    Real contact_stiffness = 0;  // [Pa/m]; 0: of a layer of the matter
    Real rate_modulus = 0;       // added to mu by viscosity in a tangent [Pa]
    Index anisotropy = kNone;    // of Elements::anisotropic; kNone: isotropic, by lambda and mu
    bool operator==(const StressLaw&) const = default;
    Real wave_modulus() const { return lambda + 2 * mu; }  // rho c^2 of pressure waves [Pa]
};

/// The fastest rates of small motions of a body about its unstrained rest shape.
struct FastestRates {
    double stiffest = 0;  // omega^2 of vibrations [1/s^2]
    double damping = 0;   // of viscosity [1/s]
};

}  // namespace thixo
