// All tables of solid matter.
#pragma once

#include <algorithm>
#include <vector>

#include "pipeline/geometry/keyframes.h"
#include "sim/state/blades.h"
#include "sim/state/bodies.h"
#include "sim/state/contacts.h"
#include "sim/state/cracks.h"
#include "sim/state/elements.h"
#include "sim/state/stress_law.h"

namespace thixo {

/// A part of a body that is held, moved or pulled.
struct Handle {
    RigidMotion motion;
    Vec3d force{0, 0, 0};         // [N]; not zero: pulls in place of holding
    double start = 0, stop = 0;   // [s]
    std::vector<Index> elements;  // ascending
    double mass = 0;              // of these elements [kg]
    // State.
    std::vector<Vec3d> anchor;  // places of the elements in the world at `start` [m]; empty: not yet anchored
    bool active(double time) const { return time >= start && time < stop; }
    bool pulls() const { return !force.isZero(); }
};

/// How the matter about an element moves, to first order: surfels sum it up. One cache line in single precision.
struct alignas(16 * sizeof(Real)) AffineMotion {
    Real value[16];  // H by columns, u - H m [m], v [m/s], 0
};

/// Matter that melts, freezes or flows, where a scene has any. Every element has two stencils, each of which conserves
/// momentum. R holds the rest neighbours, each bond weighed by its solidity 1 - max(b_i, b_j). D holds the present
/// neighbours; its rest shape absorbs the deformation of every step (6.15). With b the melt fraction, the energy is
///     r U^R + (1 - r) U^D      [J]
/// r is 1 - b where the rest shape binds, 0 elsewhere.
struct Softening {
    bool any = false;
    // Of the present step.
    bool moves = true;                // some element is not liquid
    bool freezes = false;             // some element is at least partly bound to its present neighbours
    bool flows = false;               // D has elements
    std::vector<StressLaw> law;       // at the element's temperature
    std::vector<StressLaw> rest_law;  // r times that law: the laws of R
    std::vector<StressLaw> flow_law;  // (1 - r) times that law: the laws of D
    Elements
        flow;  // D: rest holds the particles' places in the world; plastic: minus the elastic strain, which is state
    std::vector<Vec3> force;  // of D, in the world [N]
    std::vector<Mat3> gradients;
    FastestRates rates;  // of elements that have softened or flow
    // These rates over the unevenness of a stencil, per modulus and per viscosity [1].
    double stiffest_per = 0, damping_per = 0;
};

struct Solids {
    std::vector<SolidBody> bodies;
    Elements elements;
    std::vector<Handle> handles;
    Contacts contacts;
    Softening softening;
    Cracks cracks;
    std::vector<Breaking> breaking;  // of the scene bodies that can break or are cut
    std::vector<Blade> blades;
    std::int32_t next_body = 0;  // id of the next new body
    // Bodies have split, or elements have come or gone. A checkpoint then also holds what the scene no longer tells.
    bool altered = false;
    double last_dt = 0;     // the last sub-step; 0: none yet [s]
    double stretch2 = 1;    // largest squared stretch of any element in it [1]
    double stiffening = 1;  // largest stiffness of any element in it, over that of its rest shape [1]
    // Of the present time.
    std::vector<StressLaw> laws;      // by body
    std::vector<FastestRates> rates;  // by body, of `rates_version` of the bonds
    std::uint64_t rates_version = 0;
    std::vector<Index> element_of;   // by particle id; kNone where the particle has none
    std::vector<Index> particle_of;  // by element: the place of its particle, rewritten when particles are sorted
    // Of a step.
    std::vector<Vec3> force;            // in the material frames [N]
    std::vector<Vec3> external;         // acceleration that stays the same over the sub-steps, material frames [m/s^2]
    std::vector<std::uint8_t> held;     // 1 + the handle that holds an element; 0: free
    std::vector<Mat3> gradients;        // H
    std::vector<AffineMotion> motions;  // these displace surfels and the contact surface

    bool empty() const { return bodies.empty(); }
    Index element(std::int64_t id) const {
        return static_cast<std::size_t>(id) < element_of.size() ? element_of[static_cast<std::size_t>(id)] : kNone;
    }
    /// Whether no matter of a body has begun to melt.
    bool solid_throughout(const SolidBody& body) const {
        return !elements.softens ||
               std::ranges::all_of(body.elements, [&](Index i) { return elements.solidity(i) == 1; });
    }
    const SolidBody& owner(std::size_t element) const {
        return bodies[static_cast<std::size_t>(elements.owner[element])];
    }
};

}  // namespace thixo
