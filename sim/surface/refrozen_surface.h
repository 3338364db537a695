// The surface of a body that has melted and frozen again: it is that of a solid once more. Dissertation 6.6.6, 5.5.
#pragma once

#include <concepts>
#include <cstdint>
#include <vector>

#include "sim/surface/embedded_surface.h"
#include "sim/surface/zombies.h"

namespace thixo {

/// Animated surfels that are bound to the rest shape in which their body has frozen. State; part of a checkpoint.
struct RefrozenSurface {
    std::vector<std::int64_t> id;           // of the surfel, ascending
    std::vector<Vec3> place, axis1, axis2;  // in the material frame of its body [m]
    std::size_t size() const { return id.size(); }
};

template <class R, class F>
void for_each_field(R& r, F&& f) requires std::same_as<std::remove_const_t<R>, RefrozenSurface> {
    f("refrozen.id", Life::state, r.id);
    f("refrozen.place", Life::state, r.place);
    f("refrozen.axis1", Life::state, r.axis1);
    f("refrozen.axis2", Life::state, r.axis2);
}

/// Before an update: releases bodies that were bound and begin to melt again. Their surfels move with the particles
/// again, and copies of them carry their texture.
void release_thawed(Solids& solids, const SurfaceState& animated, Zombies& zombies);

/// After an update: moves surfels of bodies that are solid throughout, on a rest shape in which they have frozen. They
/// follow the displacement field of a body that never melted (embedded_surface.h), and keep every detail:
///     s = m + u(m),   t' = t + u(m + t) - u(m)
/// When they are first bound, their m and t are found by inverting these equations. Surfels within `support` [m] of
/// molten particles of their material, which may be about to join, are left out. Zombies of such bodies are removed:
/// nothing is resampled. Requires the present solids.gradients.
void follow_refrozen(Solids& solids, const Particles& particles, Real support, SurfaceState& animated,
                     RefrozenSurface& refrozen, Zombies& zombies);

}  // namespace thixo
