// The surface of a scene in which not all is liquid: surfels of solids follow their matter, those of liquids and of
// what melts are the animated surface. Dissertation 6.6.6.
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
    Zombies zombies;           // of those bodies
    RefrozenSurface refrozen;  // of those that are solid again
};

/// Ids of animated surfels begin here: those of solids are below.
inline constexpr std::int64_t kFirstAnimated = std::int64_t(1) << 40;

/// Brings both parts up to date, and `shown` to all surfels: first those of solids, from `source`, then the animated.
/// When a body begins to melt its surfels, where they are, become animated ones, but for those that reach past its
/// edges: from then on they go with the particles, and as far as the matter about them has melted, b, they follow the
/// potentials and are resampled: s = (1 - b) s_displaced + b s_deformed. What has frozen throughout is a solid again,
/// and its surfels follow the rest shape it froze in.
SurfaceReport update_mixed_surface(const EmbeddedSurface& embedded, Solids& solids, Particles& particles,
                                   const Walls& walls, const scene::Surface& params, Real spacing, Real support,
                                   const std::vector<Mould>& moulds, MixedSurface& state, SurfaceState& shown,
                                   std::vector<Index>& source);

}  // namespace thixo
