// What the colour field sums over: the particles, and their mirror images behind nearby walls.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "pipeline/geometry/point_grid.h"
#include "sim/particles.h"
#include "sim/walls.h"

namespace thixo {

/// A wall as a particle sees it: the plane through the nearest point of the wall.
struct WallPlane {
    Vec3 normal{0, 0, 1};  // unit, into the room
    Real offset = 0;       // normal.x = offset on the plane [m]
    Real distance(const Vec3& x) const { return normal.dot(x) - offset; }
};

/// Points of all liquids in cell order. An image stands where its particle's mirror image behind a wall is, so that the
/// field is even about the wall: a free surface meets it squarely instead of curling away from where particles end. A
/// particle has an image for every wall nearer than a support, and in edges and corners those of its images in the
/// other walls.
struct LiquidPoints {
    std::vector<Vec3> position;           // [m]
    std::vector<Real> volume;             // V0 [m^3]
    std::vector<Real> colour;             // phi_j [1], see set_colours
    std::vector<std::int32_t> component;  // points of different components do not see each other
    std::vector<WallPlane> planes;        // walls that particles are mirrored in
    std::vector<std::array<Index, 3>>
        mirrors;                       // of an image: its walls in `planes`, then kNone; of a particle all kNone
    std::vector<Index> particle;       // source of the point
    PointGrid grid;                    // of cell `support`
    std::vector<Real> particle_fill;   // s_j = sum of V0 w over a particle's neighbours and images [1], by particle
    std::vector<Vec3> particle_slope;  // gradient of particle_fill in space [1/m], by particle: points inwards
    std::vector<Real> particle_wall;   // distance from the wall [m], by particle

    std::size_t size() const { return position.size(); }
    bool is_image(Index i) const { return mirrors[i][0] != kNone; }
    /// Whether point i counts at x: images do down to `depth` [m] behind their walls only, or a thin wall would be wet
    /// on its far side.
    bool counts_at(Index i, const Vec3& x, Real depth) const {
        for (const Index plane : mirrors[i]) {
            if (plane == kNone) break;
            if (planes[plane].distance(x) < -depth) return false;
        }
        return true;
    }
};

/// Gathers the particles and their images. `support` h [m].
LiquidPoints gather_liquid(const Particles& particles, const Walls& walls, Real support);

/// Sets phi_j = max(1, s_flat/s_j), s_j = sum_k V0_k w_poly6(x_j - x_k, h) over the component, s_flat its value in the
/// outermost layer of a flat surface. A lone particle, a thread, a sheet then have a surface that encloses about their
/// volume, where phi_j = 1 leaves what is thinner than a support without any (the normalisation of CSPM, 2.24, applied
/// to the colour). Fills particle_fill and particle_slope.
void set_colours(LiquidPoints& points, Real support);

}  // namespace thixo
