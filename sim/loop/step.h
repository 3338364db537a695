// One step of the animation loop.
#pragma once

#include <functional>

#include "sim/loop/simulation.h"
#include "sim/loop/surface_updates.h"

namespace thixo {

/// Brings the particles into the order of (cell key, id), and finds all neighbours within the support. Computes density
/// and pressure with the walls' share at the present time. Frames show this state.
void evaluate(Simulation& sim);

/// Pressure of particle i as frames and probes show it [Pa]; 0 in a solid that `dfsph` has no part in. Requires
/// evaluate.
Real shown_pressure(const Simulation& sim, std::size_t i);

/// One step of the animation loop towards clock.next_frame. The last one ends on it exactly. Throws DivergedError.
void step(Simulation& sim);

/// Time of a frame of the scene, (frame - first)/fps [s].
double frame_time(const scene::Frames& frames, int frame);

/// Steps to the next frame, with surface, density and pressure of that instant. Returns false between two steps where
/// `stop` becomes true.
bool advance_frame(
    Simulation& sim, const std::function<bool()>& stop = [] { return false; });

}  // namespace thixo
