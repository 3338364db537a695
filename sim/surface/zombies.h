// Zombies: copies of surfels that carry the texture of a melting body. Dissertation 6.6.4 (Pauly et al. 2003).
#pragma once

#include "sim/state/particle_rows.h"
#include "sim/surface/surface.h"

namespace thixo {

/// Copies of the surfels that a body had when it began to melt. They are no part of the visible surface. They move with
/// the matter and stay on its surface, but are neither pushed apart, deleted nor added. Each keeps its m0 and its
/// paint. State; part of a checkpoint.
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

/// Adds a copy of a surfel.
void add_zombie(const SurfelCloud& cloud, std::size_t i, const Vec3& rest, std::int32_t component, std::int32_t body,
                Zombies& zombies);

/// Step 1 for zombies: `displace` does the same for surfels. Requires particles.surface_position of the last update.
void displace_zombies(const ParticleRows& particles, Real support, Zombies& zombies);

/// Brings zombies back to within d, three tenths of `support`, of the present surface: F = 0 of the surfels of their
/// component and side. One step along the normal n moves them as far as the matter there has melted:
///     x <- x - b (F - clamp(F, -d, d)) n,   b the mean of `melt` of those surfels
/// Nearer zombies stay with their matter. Matter slips along itself at every depth: a zombie that changed its depth at
/// each update would carry its paint to another place. Zombies with fewer than three such surfels within `support` [m]
/// stay: their side is buried at present.
void project_zombies(const SurfaceState& surface, const std::vector<std::int32_t>& component,
                     const std::vector<Real>& melt, Real support, Zombies& zombies);

/// Sets m0 of every surfel whose matter has melted, `melt` > 0. It is the first-order least squares fit of m0 along the
/// surface, from the nearest zombies of one body that face its way. This is the normalised interpolation (2.24) made
/// exact for fields that are linear along the surface. Weights are w_poly6 up to the farthest of them. Across the
/// surface m0 changes with the shear of the matter: zombies at several depths would be taken for a slope. Where zombies
/// are on one side only, the fit is continued little beyond them. Surfels with none within `reach` [m] keep their m0:
/// liquid that was never solid, surface torn open within the body.
void take_rest_of_zombies(const Zombies& zombies, const std::vector<std::int32_t>& component,
                          const std::vector<Real>& melt, Real reach, SurfaceState& surface);

}  // namespace thixo
