// What the colour field sums over: the particles, and their mirror images behind nearby walls.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "pipeline/geometry/point_grid.h"
#include "sim/space/walls.h"
#include "sim/state/particles.h"

namespace thixo {

/// A wall as seen from a place: the plane through the nearest point of the wall. Without a wall the plane is farther
/// away than anything.
struct WallPlane {
    Vec3 normal{0, 0, 1};                             // unit, into the room
    Real offset = -std::numeric_limits<Real>::max();  // normal.x = offset on the plane [m]
    Real distance(const Vec3& x) const { return normal.dot(x) - offset; }
};

/// Points in the order of their grid, of cell `support`.
struct FieldPoints {
    std::vector<Vec3> position;  // [m]
    std::vector<Real> weight;    // V0 phi_j [m^3], see set_colours; then PointGrid::kPadding zeros
    std::vector<Real> loose;     // how far apart matter has come, 0 to 1, see set_colours; then kPadding zeros
    std::vector<Index> particle;
    PointGrid grid;
    std::size_t size() const { return position.size(); }
};

/// Particles of one liquid and their images. An image stands where its particle's mirror image behind a wall is, so
/// that the field is even about the wall: a free surface meets it squarely instead of curling away from where particles
/// end. A particle has an image for every wall nearer than a support, and in edges and corners those of its images in
/// the other walls. Images count as far as their particle has melted: what is solid wets no wall, and its surface would
/// jump to the wall when it begins to melt.
struct LiquidPart {
    FieldPoints own, images;
    std::vector<std::array<Index, 3>> mirrors;  // of an image: its walls in `planes`, then kNone
    Real lift = 0;                              // of the surface over the iso-surface where matter is loose [m]
};

struct LiquidPoints {
    std::vector<LiquidPart> part;          // by component: points of different components do not see each other
    std::vector<WallPlane> planes;         // walls that particles are mirrored in
    std::vector<Real> particle_fill;       // s_j = sum of V0 w over a particle's neighbours and images [1], by particle
    std::vector<Vec3> particle_slope;      // gradient of particle_fill in space [1/m], by particle: points inwards
    std::vector<WallPlane> particle_wall;  // the nearest, where it is nearer than a support; by particle

    /// Whether an image of these mirrors counts at x: it does down to `depth` [m] behind its walls only, or a thin wall
    /// would be wet on its far side.
    bool counts_at(const std::array<Index, 3>& mirrors, const Vec3& x, Real depth) const {
        for (const Index plane : mirrors) {
            if (plane == kNone) break;
            if (planes[plane].distance(x) < -depth) return false;
        }
        return true;
    }
};

/// Gathers the particles and their images; weights are V0. `support` h [m].
LiquidPoints gather_liquid(const Particles& particles, const Walls& walls, Real support);

/// Gives every point its phi_j = max(1, s_flat/s_j), s_j = sum_k V0_k w_poly6(x_j - x_k, h) over the component, s_flat
/// its value in the outermost layer of a flat surface. A lone particle, a thread, a sheet then have a surface that
/// encloses about their volume, where phi_j = 1 leaves what is thinner than a support without any (the normalisation of
/// CSPM, 2.24, applied to the colour). Fills particle_fill and particle_slope.
/// Also tells where matter has come apart so that its iso-surface encloses more than its volume: in sheets and jets
/// that stretch, for SPH has no tension. `loose` is 1 - s'_j over a quarter, s'_j = s_j + 0.34 h |grad s_j|, which is 1
/// inside of a liquid and in its outermost layer; it falls to 0 from s_j = 0.5 to 0.3, for threads and single drops
/// have their volume.
void set_colours(LiquidPoints& points, Real support);

}  // namespace thixo
