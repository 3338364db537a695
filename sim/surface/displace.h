// Step 1 of the animated surface: surfels move with the particles. Dissertation 6.6, 5.5.
#pragma once

#include <functional>

#include "sim/state/particle_rows.h"
#include "sim/surface/surface.h"

namespace thixo {

/// The motion of the particles about a place since the last update.
struct LocalMotion {
    Vec3 shift{0, 0, 0};           // u(s) [m]
    Mat3 gradient = Mat3::Zero();  // G [1]
    /// unit((1 + G)^-T n), or n itself where matter was torn rather than deformed.
    Vec3 turned(const Vec3& normal) const;
};

/// Calls act(i, motion) for every place, in parallel. The motion is that of `displace`, with `level` as eps over h^2
/// [1]. At a free surface particles spread by 0.03 h^2 across it: eps damps that part of G by eps/0.03.
void for_each_motion(const std::vector<Vec3>& places, const ParticleRows& particles,
                     const std::vector<std::int32_t>& component, Real support, Real level,
                     const std::function<void(std::size_t, const LocalMotion&)>& act);

/// Moves every surfel by the particles' displacement u since the last update. It is a first-order moving least squares
/// fit about the weighted mean m of the particles in reach:
///     u(s) = u_m + G (s - m)
///     G = [sum w (u_j - u_m)(x_j - m)^T] [sum w (x_j - m)(x_j - m)^T + eps W]^-1,   eps = 0.005 h^2
/// The weights are V0 w_poly6(s - x_j, h) at the particles' old places, W their sum. The term eps makes G vanish across
/// directions that the particles do not span. Normals and axes follow:
///     n <- unit((1 + G)^-T n),   t <- (1 + G) t
/// The axes then need not be at right angles. No axis grows beyond `longest` [m]. Reads particles.surface_position
/// (old) and position (new). `component` is that of each surfel; particles of other components (materials) have no
/// effect.
void displace(SurfaceState& surface, const ParticleRows& particles, const std::vector<std::int32_t>& component,
              Real support, Real longest);

/// Sets velocity and temperature of every surfel by normalised interpolation of the particles in reach,
///     sum A_j w_j / sum w_j
/// and its body by the nearest. Surfels with no particle in reach keep their values.
void interpolate_attributes(SurfaceState& surface, const ParticleRows& particles,
                            const std::vector<std::int32_t>& component, Real support);

}  // namespace thixo
