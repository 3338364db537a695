// Elements that come, go and move to another body in mid-run, with everything that points at them.
#pragma once

#include <vector>

#include "sim/state/particles.h"
#include "sim/state/solids.h"

namespace thixo {

/// One more element of a body, all else zero and without bonds; returns its index.
Index append_element(Elements& elements, std::int64_t particle, std::int32_t owner);

/// Notes which element a particle has.
void number_element(std::int64_t particle, Index element, Solids& solids);

/// Writes Solids::particle_of anew. Call it when particles have been sorted, added or removed.
void locate_particles(const Particles& particles, Solids& solids);

}  // namespace thixo
