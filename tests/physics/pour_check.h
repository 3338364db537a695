// Checks the promises of a liquid's surface through a pour, frame by frame. The surface is closed, has the liquid's
// volume, is still where the liquid is, and joins no liquid that does not touch.
#pragma once

#include <functional>

#include "sim/loop/simulation.h"

namespace thixo::gate {

struct PourFrame {
    int frame = 0;
    std::size_t particles = 0, surfels = 0;
    /// Rays from particles farther than h from all surfels, and those of them that leave without a hit.
    std::size_t rays = 0, holes = 0;
    double volume = 1;  // of the surface, over the particles' [1]
    /// Moves of the surface when it is updated again while the particles are frozen. `pop` is the largest distance of a
    /// surfel of either surface from the discs of the other, `pop99` that of 99 in 100, in supports h. Surfels hidden
    /// in walls do not count. Nor does anything within h of a piece that the update removes or adds, because the
    /// surface parts or joins there.
    double pop = 0, pop99 = 0;
    /// Pieces of the surface in the room, and how many of them enclose particles of two clusters that do not touch. The
    /// surfaces of two drops meet when these are 1.07 h apart, those of two pairs at 1.09 h. Hence particles within
    /// 1.15 h belong to one cluster.
    std::size_t pieces = 0, bridges = 0;
};

/// Distances of the surfels of either surface from the discs of the other, in supports h, ascending. Surfels hidden in
/// walls and surfels within h of a piece that only one surface has do not count.
std::vector<Real> moves_between(const Simulation& s, const SurfelCloud& a, const SurfelCloud& b);
/// The same between the surface and its update with frozen particles: `pop` of all surfels.
std::vector<Real> moves_when_frozen(const Simulation& s);

/// Checks the current frame of the simulation.
PourFrame check_frame(const Simulation& s, std::size_t rays);

/// Advances to frame `last`, calling f after each frame.
void check_pour(Simulation& s, int last, std::size_t rays, const std::function<void(const PourFrame&)>& f);

}  // namespace thixo::gate
