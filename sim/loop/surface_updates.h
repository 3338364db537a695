// When the surface is brought up to date with the particles: at frames, and between them where something asks for it.
#pragma once

#include "sim/loop/plan.h"
#include "sim/loop/simulation.h"

namespace thixo {

/// Brings the surface up to date with the particles, where the scene has one.
void refresh_surface(Simulation& sim);

/// The same after a step, where the surface is asked for between frames and is due. Solids that touch, melt or carry a
/// texture ask for it, and so do moulds. A liquid's own is carried from frame to frame.
void update_surface_when_due(const Plan& plan, Simulation& sim);

/// The surface of a frame. Where liquid has been stirred since the last update, surfels come from far. The surface is
/// then brought up to date again, from nearer, once at least and six times at most. It ends where the volume is within a
/// hundredth, or where an update makes it no better.
void make_frame_surface(Simulation& sim);

}  // namespace thixo
