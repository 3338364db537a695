// Contact between bodies and with walls in an implicit step: the forces of a trial state, and their derivatives.
#pragma once

#include "sim/space/walls.h"
#include "sim/state/solids.h"

namespace thixo {

struct BoundaryTerms {
    struct Node {
        Vec3 normal;         // in the world
        Real along, across;  // [N/m]
        Real part;           // of friction, as in NodeAnswer [1]
    };
    std::vector<Node> node;
    std::vector<Vec3> force;  // of nodes [N]
    std::vector<Mat3> wall;   // stiffness of an element against walls, in its frame [N/m]
    std::vector<Real> drag;   // of friction, by element and wall [kg/s]
    bool walls = false;
    bool frozen = false;  // friction's parts and drags stay as they are
};

/// Adds the forces of contact nodes and walls on every element to `force` [N]. Displacement and velocity are dt [s]
/// after the state that the nodes remember. Their stiffness, per displacement over the step, goes into `terms`. Walls
/// act as in push_off_walls, but for static friction. It is a drag of
///     kHold m/dt      [kg/s]
/// A sticking element therefore creeps by 1/kHold of the way that it would fall in a step.
void add_boundary_forces(const Walls& walls, double dt, const Solids& solids, BoundaryTerms& terms,
                         std::vector<Vec3>& force);

/// Adds -K du [N] of the terms to `out`.
void multiply_boundaries(const Walls& walls, const Solids& solids, const std::vector<Quad>& du, BoundaryTerms& terms,
                         std::vector<Vec3>& out);

/// Adds the diagonal blocks of K [N/m].
void add_boundary_diagonal(const Solids& solids, const BoundaryTerms& terms, std::vector<Symmetric>& diagonal);

/// Writes the state that the nodes remember after the step.
void store_boundary_state(const Walls& walls, double dt, Solids& solids);

inline constexpr Real kHold = 1000;

}  // namespace thixo
