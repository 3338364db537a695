// The solids of a scene at time 0.
#pragma once

#include "pipeline/contract/scene.h"
#include "sim/space/smoothing.h"
#include "sim/state/particles.h"
#include "sim/state/solids.h"

namespace thixo {

/// Elements for all particles that are solid, whose volumes are their body's shared evenly; rest shapes, grips, laws.
/// Throws InputError where a handle holds nothing.
Solids make_solids(const scene::Scene& scene, const Smoothing& smoothing, const Particles& particles);

}  // namespace thixo
