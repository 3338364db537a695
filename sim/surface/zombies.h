// Zombies: what carries the texture of a body that melts. Dissertation 6.6.4 (Pauly et al. 2003).
#pragma once

#include "sim/surface/surface.h"

namespace thixo {

/// Copies of the surfels that a body had when it began to melt. They are no part of the surface that is seen: they go
/// with the matter and stay on its surface, but nothing pushes them apart, deletes or adds any, so that each keeps its
/// m0 and what is painted there. State; part of a checkpoint.
struct Zombies {
    std::vector<Vec3> position, normal;   // [m], unit
    std::vector<Vec3> rest;               // m0 [m]
    std::vector<std::int32_t> component;  // material
    std::vector<std::int32_t> body;
    std::size_t size() const { return position.size(); }
};

template <class Z, class F>
void for_each_field(Z& z, F&& f) requires std::same_as<std::remove_const_t<Z>, Zombies> {
    f("zombie.position", Life::state, z.position);
    f("zombie.normal", Life::state, z.normal);
    f("zombie.rest", Life::state, z.rest);
    f("zombie.component", Life::state, z.component);
    f("zombie.body", Life::state, z.body);
}

/// A copy of a surfel.
void add_zombie(const SurfelCloud& cloud, std::size_t i, const Vec3& rest, std::int32_t component, std::int32_t body,
                Zombies& zombies);

/// Step 1 for zombies: as `displace` moves surfels. Requires particles.surface_position of the last update.
void displace_zombies(const Particles& particles, Real support, Zombies& zombies);

/// Back to within three tenths of `support` of the surface there is now, F = 0 of the surfels of their component and
/// side, by one step along its normal n and as far as the matter there has melted: x <- x - b (F - clamp(F, -d, d)) n,
/// b the mean of `melt` of those surfels, d those three tenths. Nearer they stay with their matter: it slips along
/// itself at every depth, and what is put on another depth at each update is painted where it was not. Those with fewer
/// than three such surfels within `support` [m] are left where they are: their side is buried for now.
void project_zombies(const SurfaceState& surface, const std::vector<std::int32_t>& component,
                     const std::vector<Real>& melt, Real support, Zombies& zombies);

/// m0 of every surfel whose matter has melted, `melt` > 0: of the nearest zombies of one body that face its way the
/// first-order least squares fit of m0 along the surface (the normalised interpolation, 2.24, made exact for fields
/// that are linear there), weights w_poly6 up to the farthest of them: across the surface m0 changes with the shear of
/// the matter, and zombies at several depths would be taken for a slope. Where zombies are on one side only the fit is
/// continued little beyond them. Surfels with none within `reach` [m] keep what they have: liquid that was never
/// solid, surface torn open within the body.
void take_rest_of_zombies(const Zombies& zombies, const std::vector<std::int32_t>& component,
                          const std::vector<Real>& melt, Real reach, SurfaceState& surface);

}  // namespace thixo
