// The surface of a scene in which not all is liquid. Surfels of solids follow their matter; those of liquids and of
// melting matter are the animated surface. Dissertation 6.6.6.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/surface/embedded_surface.h"
#include "sim/surface/refrozen_surface.h"
#include "sim/surface/surface.h"
#include "sim/surface/zombies.h"

namespace thixo {

/// State; part of a checkpoint.
struct MixedSurface {
    SurfaceState animated;     // of liquids, and of bodies that have begun to melt
    Zombies zombies;           // of bodies that have begun to melt
    RefrozenSurface refrozen;  // of bodies that are solid again
};

/// Ids of animated surfels begin here. Those of solids are below.
inline constexpr std::int64_t kFirstAnimated = std::int64_t(1) << 40;

/// Brings both parts up to date. `shown` becomes all surfels: first those of solids, from `source`, then the animated.
/// When a body begins to melt, its present surfels become animated ones, but for those that reach past its edges. They
/// then move with the particles. As far as the matter about them has melted, b, they follow the potentials:
///     s = (1 - b) s_displaced + b s_deformed
/// They are resampled to the same extent. A body that has frozen throughout is a solid again, and its surfels follow
/// the rest shape in which it froze.
SurfaceReport update_mixed_surface(const EmbeddedSurface& embedded, Solids& solids, Particles& particles,
                                   const SurfaceSetting& setting, MixedSurface& state, SurfaceState& shown,
                                   std::vector<Index>& source);

}  // namespace thixo
