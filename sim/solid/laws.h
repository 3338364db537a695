// The laws of elastic materials at one instant.
#pragma once

#include "sim/state/elements.h"
#include "sim/state/materials.h"
#include "sim/state/stress_law.h"

namespace thixo {

/// The elastic values of a material at `time` [s]. Changes are linear in time.
ElasticValues elastic_at(const ResolvedMaterial& material, double time);

/// The law of a material at `time` [s], where it has not melted.
StressLaw law_at(const ResolvedMaterial& material, double time);

/// The law at melt fraction b [1], between the elastic values of the cold material and its liquid end (6.16). Damping of
/// elastic vibrations goes with the solid's share.
StressLaw melting_law(const scene::Melting& melting, const ElasticValues& cold, double b);

/// C of an orthotropic material whose axes 1, 2, 3 are the columns of `axes` [Pa]. It is the inverse of the compliance
///     eps_aa = sigma_aa/E_a - nu_ba sigma_bb/E_b - nu_ca sigma_cc/E_c
///     2 eps_ab = sigma_ab/G_ab,   nu_ab/E_a = nu_ba/E_b
Stiffness6 orthotropic_stiffness(const scene::Orthotropic& o, const Mat3d& axes);

}  // namespace thixo
