// The laws of elastic materials, from what the scene gives.
#pragma once

#include "pipeline/contract/scene.h"
#include "sim/state/elements.h"
#include "sim/state/stress_law.h"

namespace thixo {

/// The law of a material at `time` [s], with the changes that the scene makes to it. Values change linearly in time.
StressLaw law_at(const scene::Scene& scene, std::size_t material, double time);

/// The law of a material that melts, between its ends (6.16).
class MeltingLaw {
  public:
    MeltingLaw(const scene::Scene& scene, std::size_t material, double time);
    /// The law at melt fraction b [1]; at(0) is law_at. Damping of elastic vibrations goes with the solid's share.
    StressLaw at(double b) const;

  private:
    scene::Elastic cold_;
    scene::Melting melting_;
    double viscosity_;
};

/// Whether the matter of this material keeps any shape at melt fraction b.
inline bool keeps_shape(const scene::Material& m, double b) {
    return m.elastic.solid() && (b < 1 || !m.melting.any() || m.melting.liquid.youngs_modulus > 0);
}

/// C of an orthotropic material whose axes 1, 2, 3 are the columns of `axes` [Pa]. It is the inverse of the compliance
///     eps_aa = sigma_aa/E_a - nu_ba sigma_bb/E_b - nu_ca sigma_cc/E_c
///     2 eps_ab = sigma_ab/G_ab,   nu_ab/E_a = nu_ba/E_b
Stiffness6 orthotropic_stiffness(const scene::Orthotropic& o, const Mat3d& axes);

}  // namespace thixo
