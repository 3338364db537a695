// Walls: rigid shapes, at rest or moved along keyframes, that matter cannot enter.
#pragma once

#include <string>
#include <vector>

#include "pipeline/base/math.h"
#include "pipeline/geometry/shape.h"

namespace thixo {

struct WallContact {
    Real distance;  // [m], > 0 in the room of the fluid, < 0 inside the wall
    Vec3 normal;    // unit, from the wall into the room
    Vec3 velocity;  // of the wall at the point [m/s]
};

struct Walls;  // defined by the simulation: see walls.cpp

/// The signed distance from x to the nearest wall at the walls' present time, +max where there is none.
Real wall_distance(const Walls& walls, const Vec3& x);
/// Distance, normal and velocity of the nearest wall.
WallContact wall_contact(const Walls& walls, const Vec3& x);

}  // namespace thixo
