// Set-up: from a scene to a simulation at time 0.
#pragma once

#include "sim/loop/simulation.h"

namespace thixo {

/// Whether solids get their surfels and their very mass. What only counts matter does without: sampling surfaces and
/// volumes takes longest by far. The mass of a solid is then that of the packing.
enum class SkinSetup { make, leave_out };

/// Builds walls, materials, emitters and the particles of all bodies. A body's particles are packed in its shape, away
/// from walls (0.1 spacings) and from earlier bodies (0.7 spacings). Ids count up in order of bodies and sites. All
/// places of the simulation, and of the scene that it holds, are relative to `problem.scene.origin`. Throws InputError.
Simulation make_simulation(const scene::Scene& scene, SkinSetup skins = SkinSetup::make);

/// The speed that the flow is expected to reach [m/s], for the automatic stiffness: solver.expected_speed, or else the
/// largest of three speeds:
///     sqrt(v^2 + 2 g H)
///     sqrt(56/3 gamma/(rho0 h))
///     0.1 m/s
/// v is the speed of the fastest body, emitter or moving wall, and H the height of the highest matter over the lowest
/// wall. With the second, the surface's pull on its outermost layer compresses it by at most 1 %.
double expected_speed(const scene::Scene& scene);

}  // namespace thixo
