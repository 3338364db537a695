// Walls: rigid shapes, at rest or moved along keyframes, that matter cannot enter.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/base/math.h"
#include "pipeline/contract/scene.h"
#include "pipeline/geometry/keyframes.h"
#include "pipeline/geometry/shape.h"
#include "sim/space/smoothing.h"
#include "sim/space/wall_map.h"
#include "sim/state/particles.h"
#include "sim/state/strategy.h"

namespace thixo {

struct WallContact {
    Real distance;  // [m], > 0 in the room of the fluid, < 0 inside the wall
    Vec3 normal;    // unit, from the wall into the room
    Vec3 velocity;  // of the wall at the point [m/s]
};

/// One rigid solid. It is a moving boundary, or all boundaries at rest that have the same surface. What overlaps among
/// these then counts once.
struct Wall {
    Wall(WallMap map_, RigidMotion motion_, bool no_slip_, Real adhesion_, std::optional<double> temperature_)
        : map(std::move(map_)),
          motion(std::move(motion_)),
          no_slip(no_slip_),
          adhesion(adhesion_),
          temperature(temperature_) {}
    WallMap map;         // in the wall's own frame
    RigidMotion motion;  // own frame -> world
    bool no_slip;
    Real adhesion;                      // (1 + cos theta)/2 of the contact angle: 0 repels, 1 is wetted completely [1]
    std::optional<double> temperature;  // of an isothermal wall; else no heat passes [degC]
    Mat3 turn = Mat3::Identity();       // pose at the walls' present time
    Vec3 shift{0, 0, 0};                // [m]
    Vec3 velocity{0, 0, 0};             // of the frame's origin [m/s]
    Vec3 spin{0, 0, 0};                 // [rad/s]
    Vec3 to_wall(const Vec3& x) const { return turn.transpose() * (x - shift); }
    Vec3 velocity_at(const Vec3& x) const { return velocity + spin.cross(x - shift); }
};

struct Walls {
    std::vector<Wall> list;
};

/// What all walls together add to the sums of one particle.
struct WallEffect {
    Real distance = std::numeric_limits<Real>::max();  // to the nearest wall, or a lower bound beyond one support [m]
    Real share = 0;                                    // of the relative density [1]
    Vec3 gradient{0, 0, 0};                            // integral of grad w_spiky over the walls' volume [1/m]; with
                                                       // the implicit solver the gradient of the share
    Real inflow = 0;                                   // the gradients times the walls' velocities, summed [1/s]
    Real drag = 0;                // integral of lap w_visc over the volume of no-slip walls [1/m^2]
    Vec3 drag_velocity{0, 0, 0};  // the same times the wall's velocity [1/(m s)]
};

/// The walls of a scene, with the kernels of its pressure solver; shapes are resolved against its named ones. Throws
/// InputError.
Walls make_walls(const scene::Scene& scene, const Smoothing& smoothing, const Strategy& strategy);

/// Brings all walls to where they stand at `time` [s].
void move_walls(Walls& walls, double time);

/// The signed distance from x to the nearest wall at the walls' present time [m]; +max where there is none. Within one
/// support h of the wall it is interpolated in cells of h/4. Farther away it is a lower bound that is at least h.
Real wall_distance(const Walls& walls, const Vec3& x);
/// Distance, normal and velocity of the nearest wall.
WallContact wall_contact(const Walls& walls, const Vec3& x);

/// Remembers the page of blocks of each wall that was last asked for. Particles in cell order ask for the same page
/// many times in a row. For one thread.
struct WallCursor {
    explicit WallCursor(const Walls& walls) : at(walls.list.size()) {}
    std::vector<WallMap::Cursor> at;
};
WallEffect wall_effect(const Walls& walls, const Vec3& x, WallCursor& cursor);
/// The effects at all points.
void find_wall_effects(const Walls& walls, const std::vector<Vec3>& points, std::vector<WallEffect>& effects);

/// Keeps particles that the wall's pressure let through at `least` [m] from the wall. It moves them there along the
/// normal and takes away their velocity towards the wall. A particle that leaves the wall is never held. `before` says
/// how near the walls were a step earlier. `dt` [s] and `wall_speed` [m/s] bound how near they can have come since, so
/// that most particles need no look. Returns how many came to the other side of a wall: the way that they took against it
/// leads through its inside.
std::int64_t hold_off_walls(const Walls& walls, Particles& particles, Real least, const std::vector<WallEffect>& before,
                            double dt, double wall_speed);

/// The largest speed of any wall at any of the points [m/s].
double largest_wall_speed(const Walls& walls, const std::vector<Vec3>& points);

}  // namespace thixo
