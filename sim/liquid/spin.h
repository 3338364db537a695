// Shifts of the density solve leave the angular momentum of free liquids as it is.
#pragma once

#include <vector>

#include "sim/space/walls.h"
#include "sim/state/particles.h"

namespace thixo {

/// The density solve shifts places, not velocities. Each shift widens a drop that spins a little, as its motion narrows
/// it, and the drop would spin up. The liquid of each body or emitter that touches no wall is turned back, as a whole:
///     I w = - sum_i m_i dx_i x v_i,   v_i <- v_i + w x (x_i + dx_i - c)
/// I is its moment of inertia about its centre of mass c after the shift. Both momenta of such liquids stay, and no
/// motion within them changes. In a periodic domain nothing has a centre: the loop does not call this there. In: the velocities of the step, and its shifts dx [m]. Out: velocities.
void keep_spin(const std::vector<WallEffect>& walls, const std::vector<Vec3>& shift, Particles& particles);

}  // namespace thixo
