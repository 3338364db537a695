// The points that the colour field sums over: the particles, and their mirror images behind nearby walls.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "pipeline/geometry/point_grid.h"
#include "sim/space/walls.h"
#include "sim/state/particle_rows.h"

namespace thixo {

/// A wall as seen from a place: the plane through the nearest point of the wall. Without a wall the plane is infinitely
/// far away.
struct WallPlane {
    Vec3 normal{0, 0, 1};                             // unit, into the room
    Real offset = -std::numeric_limits<Real>::max();  // normal.x = offset on the plane [m]
    Real distance(const Vec3& x) const { return normal.dot(x) - offset; }
};

/// Points in the order of their grid, of cell `support`.
struct FieldPoints {
    std::vector<Vec3> position;    // [m]
    std::vector<Real> weight;      // V0 phi_j [m^3], see set_colours; padded with PointGrid::kPadding zeros
    std::vector<Real> dispersion;  // how far matter has dispersed, 0 to 1, see set_colours; padded in the same way
    std::vector<Index> particle;   // the member of ParticleRows
    PointGrid grid;
    std::size_t size() const { return position.size(); }
};

/// Particles of one liquid and their images. An image is the mirror image of its particle behind a wall. The field is
/// then even about the wall: a free surface meets it squarely, and does not curl away from where particles end. A
/// particle has an image for every wall nearer than a support, and in edges and corners those of its images in the
/// other walls. An image is weighted by its particle's melt fraction. Solid matter does not wet a wall: with full
/// weight its surface would jump to the wall when it begins to melt.
struct LiquidPart {
    FieldPoints own, images;
    std::vector<std::array<Index, 3>> mirrors;  // of an image: its walls in `planes`, then kNone
    Real lift = 0;                              // height of the surface over the iso-surface of dispersed matter [m]
};

struct LiquidPoints {
    std::vector<LiquidPart> part;          // by component: points of different components do not interact
    std::vector<WallPlane> planes;         // walls that particles are mirrored in
    std::vector<Real> particle_fill;       // s_j = sum of V0 w over a particle's neighbours and images [1], by member
    std::vector<Vec3> particle_slope;      // gradient of particle_fill in space [1/m], by member: points inwards
    std::vector<WallPlane> particle_wall;  // the nearest wall, where it is nearer than a support; by member

    /// Whether an image of these mirrors counts at x. It counts down to `depth` [m] behind its walls: deeper, a thin
    /// wall would be wet on its far side.
    bool counts_at(const std::array<Index, 3>& mirrors, const Vec3& x, Real depth) const {
        for (const Index plane : mirrors) {
            if (plane == kNone) break;
            if (planes[plane].distance(x) < -depth) return false;
        }
        return true;
    }
};

/// How far behind a wall its images still count [m]: enough for surfels beyond the crease to return. Deeper places are
/// dry, and must be: they may be the far side of the wall.
inline Real depth_of_images(Real spacing) { return Real(0.5) * spacing; }

/// Gathers the particles and their images; weights are V0. `support` h [m].
LiquidPoints gather_liquid(const ParticleRows& particles, const Walls& walls, Real support);

/// Gives every point its phi_j:
///     phi_j = max(1, s_flat/s_j),   s_j = sum_k V0_k w_poly6(x_j - x_k, h) over the component
/// s_flat is the value of s in the outermost layer of a flat surface. A lone particle, a thread and a sheet then have a
/// surface that encloses about their volume. With phi_j = 1, liquid thinner than a support would have none. This is the
/// normalisation of CSPM (2.24), applied to the colour. Fills particle_fill and particle_slope. Fills `dispersion` as
/// well. Matter disperses in sheets and jets that stretch, because SPH has no tension. Its iso-surface then encloses
/// more than its volume. `dispersion` is 1 - s'_j over a quarter:
///     s'_j = s_j + 0.34 h |grad s_j|
/// s'_j is 1 inside a liquid and in its outermost layer. Threads and single drops have their volume: `dispersion` falls
/// to 0 from s_j = 0.5 to 0.3. Images count at particles as at other places: a drop outside a thin glass has nothing of
/// those of the liquid inside.
void set_colours(LiquidPoints& points, Real support, Real spacing);

}  // namespace thixo
