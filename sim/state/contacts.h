// The tables of contact between solids: samples of surfaces, and the nodes at which bodies meet.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/geometry/point_grid.h"
#include "sim/state/table.h"

namespace thixo {

/// Weights of elements at places, sum_j W_j = 1 and sum_j W_j x_j = x. `begin` says where each place's weights begin.
struct ElementWeights {
    std::vector<std::size_t> begin{0};  // one more than places
    std::vector<Index> element;
    std::vector<Real> weight;
};

/// Samples on the bodies' surfaces, at which contact is found, body by body. They are made once, where there are two
/// bodies, and anew for a body that splits.
struct ContactSamples {
    std::vector<std::int32_t> owner;  // index of the SolidBody
    std::vector<Vec3> rest;           // in its material frame [m]
    std::vector<Vec3> normal;         // outward, of the rest shape
    std::vector<Real> area;           // of the rest shape [m^2]
    ElementWeights weights;           // of the owner's elements
    std::vector<Index> first;         // of each body, then the end
    std::size_t size() const { return owner.size(); }
};

/// Where the surface of one body meets another. A node between two solids is a sample of one of them. Where a solid
/// meets itself, a node is two of its elements. The force f acts on the first body, and on the second with the opposite
/// sign: weights of the second are negative.
struct ContactNodes {
    // State; part of a checkpoint.
    std::vector<Index> sample;          // kNone: two elements meet
    std::vector<std::int32_t> partner;  // index of the SolidBody, or partner_of_wall
    std::vector<Index> first, second;   // the two elements; kNone: a sample meets a body. Ascending by all four
    std::vector<Real> excess;           // the part of the depth, < 0, that no motion explains and that has no force [m]
    std::vector<Real> depth;            // the part of the depth with a force in the last sub-step [m]
    std::vector<Real> normal_force;     // its recent mean, for friction [N]
    std::vector<Real> duration;         // of that mean, no longer than `memory` [s]
    std::vector<Vec3> slip;             // tangential: the stretch of friction's spring, in the partner's frame [m]

    // Fields since the nodes were found. Frames do not move meanwhile.
    std::vector<std::int32_t> owner;  // index of the SolidBody of the first elements
    std::vector<Vec3> normal;         // from the partner, in the world
    std::vector<Real> gap;            // at that time, < 0: overlap [m]
    std::vector<Vec3> start, last;    // relative displacement when found, and a sub-step before [m]
    std::vector<Vec3> place, anchor;  // at a wall: where it was found, in the world and in the wall's own frame [m]
    std::vector<Real> stiffness;      // [N/m]
    std::vector<Real> damping, drag;  // along the normal, tangential [kg/s]
    std::vector<Real> friction;       // [1]
    std::vector<Real> memory;         // of friction [s]
    std::vector<Real> area;           // [m^2]
    std::vector<Real> brake;          // mass whose speed the node may take away at once [kg]
    ElementWeights weights;
    std::vector<std::size_t> middle;  // where the partner's weights begin
    std::vector<Vec3> force;          // on the owner, in the world [N]
    std::size_t size() const { return sample.size(); }
};

template <class C, class F>
void for_each_field(C& c, F&& f) requires requires {
    c.excess;
}
{
    f("contact.sample", Life::state, c.sample);
    f("contact.partner", Life::state, c.partner);
    f("contact.first", Life::state, c.first);
    f("contact.second", Life::state, c.second);
    f("contact.excess", Life::state, c.excess);
    f("contact.depth", Life::state, c.depth);
    f("contact.slip", Life::state, c.slip);
    f("contact.normal_force", Life::state, c.normal_force);
    f("contact.duration", Life::state, c.duration);
}

/// Walls as partners of nodes, apart from bodies.
inline std::int32_t partner_of_wall(std::size_t wall) { return -1 - static_cast<std::int32_t>(wall); }
inline bool is_wall(std::int32_t partner) { return partner < 0; }
inline std::size_t wall_of(std::int32_t partner) { return static_cast<std::size_t>(-1 - partner); }

/// What contact adds to the rates of a body's fastest motions: bounds by the sums of rows.
struct ContactRates {
    double stiffest = 0;  // [1/s^2]
    double damping = 0;   // [1/s]
};

struct Contacts {
    ContactSamples samples;
    ContactNodes nodes;
    double next = 0;            // when nodes must be found again [s]
    bool beside_walls = false;  // the scene has walls
    // By body, since the nodes were found: 1 where its samples meet walls, 0 where its elements do.
    std::vector<std::uint8_t> by_samples;
    std::vector<ContactRates> rates;  // by body
    // Nodes by element, for gathering.
    std::vector<Index> touched;      // elements, ascending
    std::vector<std::size_t> begin;  // where the nodes of each begin, then the end
    std::vector<Index> node;
    std::vector<Real> weight;
    // Scratch.
    std::vector<Vec3> place;      // of all elements in the world [m]
    std::vector<PointGrid> grid;  // by body, of its elements in their order
    std::vector<std::uint8_t> gridded;
};

}  // namespace thixo
