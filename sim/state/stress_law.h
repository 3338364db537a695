// The law of an elastic material: what of it the scene says, and the stress that it answers a strain with.
#pragma once

#include "pipeline/contract/scene_solids.h"
#include "sim/state/elements.h"

namespace thixo {

/// What the stress of a material needs at one instant (law_at, sim/solid/laws.h).
struct StressLaw {
    Real lambda = 0, mu = 0;     // Lame [Pa]
    Real volume_stiffness = 0;   // k_v [Pa]
    Real viscosity = 0;          // [Pa s]
    Real zero_energy = 0;        // modulus of the zero-energy modes [Pa]
    Real yield = 0;              // k_yield [1]
    Real creep = 0;              // k_creep [1/s]
    Real hardening = 0;          // k_hardening, by which flow raises k_yield [1]
    Real most_plastic = 0;       // largest norm of eps^p [1]; 0: no limit
    Real friction = 0;           // [1]
    Real contact_damping = 0;    // of critical [1]
    Real contact_stiffness = 0;  // [Pa/m]; 0: of a layer of the matter
    Real rate_modulus = 0;       // added to mu by viscosity in a tangent [Pa]
    Index keeps_volume = 0;      // deviatoric flow; 0: the whole elastic strain flows
    Index anisotropy = kNone;    // of Elements::anisotropic; kNone: isotropic, by lambda and mu
    bool operator==(const StressLaw&) const = default;
    Real wave_modulus() const { return lambda + 2 * mu; }  // rho c^2 of pressure waves [Pa]
};

/// Resolves elastic keys, and a viscosity [Pa s].
inline StressLaw law_of(const scene::Elastic& e, double viscosity) {
    const double modulus = e.youngs_modulus, nu = e.poisson_ratio;
    const auto real = [](double a) { return static_cast<Real>(a); };
    StressLaw law;
    law.lambda = real(modulus * nu / ((1 + nu) * (1 - 2 * nu)));
    law.mu = real(modulus / (2 * (1 + nu)));
    law.volume_stiffness = real(e.volume_stiffness);
    law.viscosity = real(viscosity);
    law.zero_energy = real(e.zero_energy * modulus);
    law.yield = real(e.yield_strain);
    law.creep = real(e.creep);
    law.hardening = real(e.hardening);
    law.keeps_volume = e.flow == scene::Flow::deviatoric ? 1 : 0;
    law.most_plastic = real(e.maximum_plastic_strain);
    law.friction = real(e.friction);
    law.contact_damping = real(e.contact_damping);
    law.contact_stiffness = real(e.contact_stiffness);
    return law;
}

/// The law with all moduli and the damping times a share [1]. Yield and creep stay.
inline StressLaw scaled(const StressLaw& law, Real share) {
    StressLaw out = law;
    for (Real* a : {&out.lambda, &out.mu, &out.volume_stiffness, &out.viscosity, &out.zero_energy}) *a *= share;
    return out;
}

/// Second Piola-Kirchhoff stress of an elastic strain, where the law is isotropic [Pa]. Requires that it is linear in the
/// strain: tangents and stable steps (sim/solid/stiffness.h) ask here for the stress of a change of strain.
inline Symmetric stress_of(const StressLaw& law, const Symmetric& e) {
    const Real pressure = law.lambda * (e.xx + e.yy + e.zz), shear = 2 * (law.mu + law.rate_modulus);
    return {pressure + shear * e.xx,
            pressure + shear * e.yy,
            pressure + shear * e.zz,
            shear * e.xy,
            shear * e.yz,
            shear * e.zx};
}

/// The fastest rates of small motions of a body about its unstrained rest shape.
struct FastestRates {
    double stiffest = 0;  // omega^2 of vibrations [1/s^2]
    double damping = 0;   // of viscosity [1/s]
};

}  // namespace thixo
