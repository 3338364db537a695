// Liquids at rest to test the surface with: packed particles, and walls given as a function.
#pragma once

#include <functional>
#include <vector>

#include "sim/space/walls.h"
#include "sim/surface/surface.h"

namespace thixo::fixture {

inline constexpr double kSpacing = 0.01;          // [m]
inline constexpr double kSupport = 2 * kSpacing;  // particle kernel support [m]

/// Particles of volume spacing^3 at the given places, of one material and body.
Particles liquid(const std::vector<Vec3>& places);

/// Places of a hexagonal close packing, one per spacing^3, within `lower`..`upper` where `inside` holds. Each is
/// shifted at random by up to `shake` spacings along each axis, because a liquid is no crystal.
std::vector<Vec3> packed(const Vec3d& lower, const Vec3d& upper, double shake,
                         const std::function<bool(const Vec3d&)>& inside);
std::vector<Vec3> packed_ball(double radius, double shake);

/// Places of a cubic lattice at half a spacing from the planes x, y, z = 0, as a liquid stands in a box.
std::vector<Vec3> stacked(int nx, int ny, int nz, double shake, const std::function<bool(const Vec3d&)>& inside);

/// The walls that the surface sees until the next call: signed distance, > 0 in the room; empty: none.
void set_walls(std::function<double(const Vec3d&)> distance);

/// One update with the walls set.
SurfaceReport update(SurfaceState& surface, Particles& particles, const scene::Surface& params = {});

}  // namespace thixo::fixture
