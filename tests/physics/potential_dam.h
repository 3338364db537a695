// The collapse of a column of ideal fluid, as the reference of the dam front.
#pragma once

#include <vector>

namespace thixo::potential_flow {

/// A plane column of ideal fluid, released at t = 0 in the corner of floor and wall.
struct Column {
    double width, height, gravity;  // [m], [m], [m/s^2]
};

struct State {
    double time;    // [s]
    double toe;     // where the free surface meets the floor [m]
    double front;   // beyond it lies a thousandth of the fluid [m]
    double area;    // of the fluid [m^2]
    double energy;  // kinetic and potential, over that at the start [1]
};

/// The states after each step of `step` seconds, up to `until` seconds. Potential flow with a free surface at zero
/// pressure (Longuet-Higgins & Cokelet 1976):
///     laplace(phi) = 0
///     d phi/dn = 0 at floor and wall
///     D phi/Dt = |grad phi|^2/2 - g z  [m^2/s^2]
///     Dx/Dt = grad phi  [m/s]
/// It is solved by linear boundary elements on the free surface alone. Floor and wall are planes of symmetry, so that
/// images of the source represent them. `nodes` lie eight times as densely at the toe as at the wall. The corner of the
/// column is rounded by 3 % of its height. A longer and thinner toe needs more nodes. With 120 nodes, area and energy
/// of a column of 1 m by 2 m stay within a thousandth for 0.7 s.
std::vector<State> collapse(const Column& column, double until, double step, int nodes);

}  // namespace thixo::potential_flow
