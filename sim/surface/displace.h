// Step 1 of the animated surface: surfels go with the particles. Dissertation 6.6, 5.5.
#pragma once

#include <functional>

#include "sim/state/particles.h"
#include "sim/surface/surface.h"

namespace thixo {

/// What the particles about a place did since the last update.
struct LocalMotion {
    Vec3 shift{0, 0, 0};           // u(s) [m]
    Mat3 gradient = Mat3::Zero();  // G [1]
    /// unit((1 + G)^-T n); n itself where matter was torn rather than deformed.
    Vec3 turned(const Vec3& normal) const;
};

/// Calls act(i, motion) for every place, in parallel: the motion that `displace` moves a surfel there by, but with this
/// eps, `level` [1]: at a free surface particles spread by 0.03 h^2 across it, and eps damps that part of G by
/// eps/0.03.
void for_each_motion(const std::vector<Vec3>& places, const Particles& particles,
                     const std::vector<std::int32_t>& component, Real support, Real level,
                     const std::function<void(std::size_t, const LocalMotion&)>& act);

/// Moves every surfel by the particles' displacement u since the last update, a first-order moving least squares fit
/// about the weighted mean m of the particles in reach: u(s) = u_m + G (s - m), G = [sum w (u_j - u_m)(x_j - m)^T] [sum
/// w (x_j - m)(x_j - m)^T + eps W]^-1, weights V0 w_poly6(s - x_j, h) at the particles' old places; normals turn with
/// it, n <- unit((1 + G)^-T n), and the axes t <- (1 + G) t, which then need not be at right angles, but no axis grows
/// beyond `longest` [m]. The term eps = 0.005 h^2 makes G vanish across directions the
/// particles do not span. Reads particles.surface_position (old) and position (new). `component` is that of each
/// surfel; particles of other components (materials) are not seen.
void displace(SurfaceState& surface, const Particles& particles, const std::vector<std::int32_t>& component,
              Real support, Real longest);

/// Velocity and temperature of every surfel: normalised interpolation of the particles in reach, sum A_j w_j / sum w_j;
/// body of the nearest. Surfels with no particle in reach keep what they have.
void interpolate_attributes(SurfaceState& surface, const Particles& particles,
                            const std::vector<std::int32_t>& component, Real support);

}  // namespace thixo
