// One frame of a cache in memory: particles, surfels, and the facts frame.NNNN.json states.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/contract/point_set.h"
#include "pipeline/contract/shortfall.h"
#include "pipeline/contract/trim.h"

namespace thixo {

/// A body of one material: a connected piece of fluid or solid, as the surface knows it.
struct FrameBody {
    int id = 0;
    int parent = -1;                 // the body it split from, -1: none
    std::string name;                // scene body or emitter it comes from
    std::string material;            // scene material; the look's appearance of that name shades it
    std::optional<TrimNode> trim{};  // over its sheets; none: all of its surfels bound it
};

/// A boundary or obstacle where it stands in this frame.
struct FrameObstacle {
    std::string name;
    std::string look;   // appearance name
    std::string asset;  // hash of the mesh in assets/<hash>.ply; empty: not drawn
    std::array<double, 16> transform{1, 0, 0, 0, 0, 1, 0, 0,
                                     0, 0, 1, 0, 0, 0, 0, 1};  // row-major, asset space -> world
    std::array<double, 3> velocity{0, 0, 0};                   // of the asset's origin [m/s]
    std::array<double, 3> angular_velocity{0, 0, 0};           // [rad/s]
};

/// The front of a crack: a line through the matter, where its sheets end.
struct FrameFront {
    bool closed = false;                       // the last node is followed by the first
    std::vector<std::array<double, 3>> nodes;  // where they are in this frame [m]
};

/// Totals of a frame in SI units.
struct FrameTotals {
    double mass = 0;                                  // kg
    std::array<double, 3> momentum{0, 0, 0};          // kg m/s
    std::array<double, 3> angular_momentum{0, 0, 0};  // kg m^2/s about the origin
    double kinetic_energy = 0;                        // J
    double potential_energy = 0;                      // J, of gravity, zero at z = 0
    double particle_volume = 0;                       // m^3, sum of m/rho0
    double surface_volume = 0;                        // m^3, enclosed by the surfels; 0 where there is no surface
    double density_error = 0;                         // mean of max(rho/rho0 - 1, 0)
    std::int64_t air = 0, virtual_particles = 0;
};

struct Frame {
    int number = 1;
    double time = 0;     // s
    double spacing = 0;  // particle spacing [m]
    PointSet particles;
    PointSet surfels;
    std::vector<FrameBody> bodies;
    std::vector<FrameObstacle> obstacles;
    std::vector<FrameFront> fronts;
    FrameTotals totals;
    std::vector<Shortfall> shortfalls;  // since the frame before
};

/// frame.NNNN.json: everything of a frame but its points (of those their counts). Throws DivergedError where a number
/// is not finite.
std::string print_frame_facts(const Frame& frame);

/// Parses and checks; `file` is named in messages. The point sets stay empty. Throws CacheError.
Frame parse_frame_facts(std::string_view text, const std::string& file);

/// Whether the text is as print_frame_facts lays it out.
bool is_own_facts(std::string_view text);

}  // namespace thixo
