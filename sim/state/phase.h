// What matter is.
#pragma once

#include <cstdint>

namespace thixo {

/// The phase of a particle. It stands in Particles::phase, with the melt fraction beside it. Once a run has begun,
/// set_phase (sim/phase/phases.h) alone writes it; everything else asks it.
enum class Phase : std::uint8_t {
    liquid,
    solid,         // bound to its body's rest shape as far as it has not melted, to its present neighbours beyond that
    viscoelastic,  // bound to its present neighbours alone: it has been liquid, or has left its rest shape
};

/// Whether its own stress moves it, in steps of its own. Such a particle has an element.
inline bool is_elastic(Phase p) { return p != Phase::liquid; }

}  // namespace thixo
