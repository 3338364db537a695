// The solids of a scene at time 0.
#pragma once

#include "pipeline/contract/scene.h"
#include "sim/space/smoothing.h"
#include "sim/state/particles.h"
#include "sim/state/solids.h"

namespace thixo {

/// Makes elements for all solid particles, with rest shapes, handles and laws. Elements integrate
/// stress by volumes that make a body as stiff in bending as its shape. Throws InputError where a handle holds nothing.
Solids make_solids(const scene::Scene& scene, const Smoothing& smoothing, const Periodic& periodic,
                   const Particles& particles);

}  // namespace thixo
