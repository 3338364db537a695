// The phases of matter.
#pragma once

#include <cstdint>

namespace thixo {

/// The phase of a particle, in Particles::phase, with the melt fraction beside it. Once a run has begun, set_phase
/// (sim/phase/phases.h) alone writes it. All other code reads it.
enum class Phase : std::uint8_t {
    liquid,
    solid,         // the part that has not melted is bound to the body's rest shape, the other to present neighbours
    viscoelastic,  // bound to its present neighbours alone: it has been liquid, or has left its rest shape
};

/// Whether its own stress moves the particle, in the steps of solids. Such a particle has an element.
inline bool is_elastic(Phase p) { return p != Phase::liquid; }

}  // namespace thixo
