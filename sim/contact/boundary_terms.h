// Contact between bodies and with walls as an implicit step sees it: forces at a trial state, and how they change.
#pragma once

#include "sim/space/walls.h"
#include "sim/state/solids.h"

namespace thixo {

struct BoundaryTerms {
    struct Node {
        Vec3 normal;         // in the world
        Real along, across;  // [N/m]
        Real part;           // of friction, as in NodeAnswer
    };
    std::vector<Node> node;
    std::vector<Vec3> force;  // of nodes [N]
    std::vector<Mat3> wall;   // stiffness of an element against walls, in its frame [N/m]
    std::vector<Real> drag;   // of friction, by element and wall [kg/s]
    bool walls = false;
    bool frozen = false;  // friction keeps its parts and drags
};

/// Adds to `force` [N] what contact nodes and walls do to every element at displacement and velocity, dt [s] after
/// the state the nodes remember, and keeps the stiffness of that, per displacement over the step, in `terms`. Walls
/// push and rub as push_off_walls has it, but for friction that holds: it is a drag of kHold m/dt, so that what sticks
/// creeps by 1/kHold of what it would fall in a step.
void add_boundary_forces(const Walls& walls, double dt, const Solids& solids, BoundaryTerms& terms,
                         std::vector<Vec3>& force);

/// Adds -K du [N] of the terms to `out`.
void multiply_boundaries(const Solids& solids, const std::vector<Quad>& du, BoundaryTerms& terms,
                         std::vector<Vec3>& out);

/// Adds the diagonal blocks of K.
void add_boundary_diagonal(const Solids& solids, const BoundaryTerms& terms, std::vector<Symmetric>& diagonal);

/// What the nodes remember after the step.
void take_boundary_state(double dt, Solids& solids);

inline constexpr Real kHold = 1000;

}  // namespace thixo
