// What is promised of a liquid's surface through a pour, frame by frame: that it is closed, has the liquid's volume, is
// still where the liquid is, and joins no liquid that does not touch.
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
    /// How far the surface is from what it is when updated again with the particles frozen, so that no motion of theirs
    /// explains it: the largest distance of a surfel of either from the discs of the other, and that of 99 in 100, in
    /// supports h. Left out are surfels hidden in walls, and what is within h of a piece that the update takes away or
    /// makes: there it parts or joins.
    double pop = 0, pop99 = 0;
    /// Pieces of the surface in the room, and those of them that hold particles of two clusters that do not touch: the
    /// surfaces of two drops or pairs meet when they are 1.07 and 1.09 h apart, hence particles within 1.15 h are one
    /// cluster.
    std::size_t pieces = 0, bridges = 0;
};

/// Distances of the surfels of either surface from the discs of the other, in supports h, ascending. Left out is what
/// is within h of a piece that only one of them has, and surfels hidden in walls.
std::vector<Real> moves_between(const Simulation& s, const SurfelCloud& a, const SurfelCloud& b);
/// The same between the surface and itself updated again with the particles where they are: `pop` of all surfels.
std::vector<Real> moves_when_frozen(const Simulation& s);

/// Of the simulation's present frame.
PourFrame check_frame(const Simulation& s, std::size_t rays);

/// Advances to frame `last`, calling f after each frame.
void check_pour(Simulation& s, int last, std::size_t rays, const std::function<void(const PourFrame&)>& f);

}  // namespace thixo::gate
