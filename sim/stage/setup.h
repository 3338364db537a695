// From a scene to a simulation at time 0.
#pragma once

#include "sim/loop/simulation.h"

namespace thixo {

/// Builds walls, materials, emitters and the particles of all bodies. A body's particles are packed in its shape, away
/// from walls (0.1 spacings) and from earlier bodies (0.7 spacings). Ids count up in order of bodies and sites. Throws
/// InputError.
Simulation make_simulation(const scene::Scene& scene);

/// The speed the flow is expected to reach [m/s], for the automatic stiffness: solver.expected_speed, or else the
/// largest of
///   sqrt(v^2 + 2 g H)     v the fastest body, emitter or moving wall, H from the highest matter to the lowest wall
///   sqrt(56/3 gamma/(rho0 h))      so that the surface's pull on its outermost layer compresses it by at most 1 %
///   0.1 m/s
double expected_speed(const scene::Scene& scene);

/// What a scene will have at its end, for `--estimate`: particles of bodies, counted, and what the emitters release by
/// the last frame; surfels on solids, counted as they are at the start.
struct Size {
    double particles = 0, surfels = 0;
};
Size estimate_size(const scene::Scene& scene);
/// The same of a simulation at its first frame.
Size final_size(const scene::Scene& scene, const Simulation& at_start);
/// Memory that a simulation of this size takes [bytes].
double memory_of(const Size& size);

}  // namespace thixo
