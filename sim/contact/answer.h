// The force of one contact node between two bodies, or a body and a wall.
#pragma once

#include "pipeline/geometry/power_of_two.h"
#include "sim/contact/contact.h"
#include "sim/contact/walls.h"
#include "sim/state/solids.h"

namespace thixo {

inline constexpr Real kBraked = Real(0.25);  // depth in particle widths from which on inward motion is braked

struct NodeMotion {
    Vec3 displacement, velocity;  // of the owner relative to the partner, in the world [m], [m/s]
};

/// The frames of all that nodes join, at one instant.
struct NodeFrames {
    NodeFrames(const Solids& solids, const Walls& walls_) : poses(poses_of(solids.bodies)), walls(walls_) {}
    std::vector<BodyPose> poses;  // by body
    const Walls& walls;
    const Wall& wall(std::int32_t partner) const { return walls.list[wall_of(partner)]; }
    const Mat3& turn(std::int32_t partner) const {
        return is_wall(partner) ? wall(partner).turn : poses[static_cast<std::size_t>(partner)].turn;
    }
};

/// Sums what `add(element, weight, motion)` adds over a node's elements, in the world.
template <class Add>
NodeMotion sum_of_node(const ContactNodes& n, const NodeFrames& frames, std::size_t k, Add&& add) {
    const auto sum = [&](std::size_t begin, std::size_t end, std::int32_t body) {
        NodeMotion m{Vec3::Zero(), Vec3::Zero()};
        for (std::size_t l = begin; l < end; ++l) add(n.weights.element[l], n.weights.weight[l], m);
        const Mat3& turn = frames.turn(body);
        return NodeMotion{turn * m.displacement, turn * m.velocity};
    };
    const NodeMotion a = sum(n.weights.begin[k], n.middle[k], n.owner[k]);
    const NodeMotion b = sum(n.middle[k], n.weights.begin[k + 1], n.partner[k]);
    return {a.displacement + b.displacement, a.velocity + b.velocity};
}

/// The part of a node's relative displacement that comes from `displacement` of elements [m].
inline Vec3 displacement_of_node(const ContactNodes& n, const std::vector<Quad>& displacement, const NodeFrames& frames,
                                 std::size_t k) {
    const auto add = [&](Index i, Real w, NodeMotion& m) { m.displacement += w * xyz(displacement[i]); };
    return sum_of_node(n, frames, k, add).displacement;
}
/// At the present displacement and velocity. A wall's displacement is its motion since the node was found.
inline NodeMotion motion_of_node(const ContactNodes& n, const Elements& e, const NodeFrames& frames, std::size_t k) {
    NodeMotion m = sum_of_node(n, frames, k, [&](Index i, Real w, NodeMotion& sum) {
        sum.displacement += w * xyz(e.displacement[i]);
        sum.velocity += w * xyz(e.velocity[i]);
    });
    if (!is_wall(n.partner[k])) return m;
    const Wall& wall = frames.wall(n.partner[k]);
    const Vec3 now = wall.turn * n.anchor[k] + wall.shift;
    m.displacement -= now - n.place[k];
    m.velocity -= wall.velocity_at(now);
    return m;
}

/// What nodes with one partner have in common at one instant.
struct NodeConditions {
    Real brake, outwards;  // braking rate [1/s], most by which unexplained depth decreases [m]
    Real dt, last;         // the step that the force acts over, the step that led here [s]
    Real width;            // of the partner's particles; at a wall of the owner's [m]
    bool backwards;        // a step backwards in time, which needs forces without jumps
};

/// The force of a spring compressed by d, with a damper. It never pulls:
///     f = max(k d - c v, 0)      [N]
/// The stiffness is minus its derivative by d, where v is the change of -d per `last`. Backwards in time the damping of
/// an impact is at most the spring's own force, so that the force has no jump.
struct SpringForce {
    Real force, stiffness;
};
inline SpringForce spring_force(Real k, Real c, Real d, Real v, Real last, bool backwards) {
    const Real force = k * d - c * v, per_last = last > 0 ? 1 / last : Real(0);
    if (!(d > 0 && force > 0)) return {0, 0};
    if (backwards && force > 2 * k * d) return {2 * k * d, 2 * k};
    return {force, k + c * per_last};
}

/// The conditions at a node, for forces over `dt` that brake over `kick`, `last` after the state before [s].
NodeConditions conditions_at(const Solids& solids, std::size_t node, double kick, double dt, double last,
                             bool backwards = false);

/// The node's force, and its state afterwards.
struct NodeAnswer {
    Vec3 force;          // on the owner, in the world [N]
    Real along, across;  // stiffness of a step `last` backwards in time: along the normal, tangential [N/m]
    Real part;           // part of the force of friction's spring and damper that friction's limit permits [1]
    Real excess, depth, normal_force, duration;
    Vec3 slip;  // tangential, in the partner's frame
};

/// The law of add_contact_forces for one node. The tangential stiffness while sliding is a secant: the force over the
/// displacement that led to it. A `part` of 0 or more replaces the part that friction's limit permits.
inline NodeAnswer answer_of(const ContactNodes& n, std::size_t k, const NodeMotion& m, const Mat3& turn,
                            const NodeConditions& p, Real part = -1) {
    NodeAnswer a{Vec3::Zero(), 0, 0, 0, n.excess[k], 0, n.normal_force[k], n.duration[k], Vec3::Zero()};
    const Vec3& normal = n.normal[k];
    const Real gap = n.gap[k] + normal.dot(m.displacement - n.start[k]);
    // Excess shrinks only under a small load: bodies that part faster, or cannot part, need no help.
    if (a.excess - gap < kUnexplained * p.width) a.excess = std::min(a.excess + p.outwards, Real(0));
    a.depth = std::max(a.excess - gap, Real(0));
    const Real speed = normal.dot(m.velocity), per_last = p.last > 0 ? 1 / p.last : Real(0);
    const SpringForce spring = spring_force(n.stiffness[k], n.damping[k], a.depth, speed, p.last, p.backwards);
    Real push = spring.force;
    a.along = spring.stiffness;
    if (gap < -kBraked * p.width && speed < 0) {
        const Real part = p.backwards ? std::min(-gap / p.width / kBraked - 1, Real(1)) : Real(1);
        push -= part * p.brake * n.brake[k] * speed;
        a.along += part * p.brake * n.brake[k] * per_last;
    }
    a.force = push * normal;
    if (!(push > 0)) return a;
    a.duration = std::min(a.duration + p.dt, n.memory[k]);
    if (a.duration > 0) a.normal_force += (push - a.normal_force) * std::min(p.dt / a.duration, Real(1));
    const Real most = n.friction[k] * a.normal_force;
    if (!(most > 0)) return a;
    Vec3 slip = turn * n.slip[k] + (m.displacement - n.last[k]);
    slip -= normal * normal.dot(slip);
    const Vec3 sliding = m.velocity - speed * normal;
    Vec3 friction = -n.stiffness[k] * slip - n.drag[k] * sliding;
    a.across = n.stiffness[k] + n.drag[k] * per_last;
    // In units of a power of two near the limit: squares of forces between asteroids leave the range of a float.
    const Real unit = 1 / power_of_two_below(most), size = (unit * friction).norm(), limit = unit * most;
    a.part = part >= 0 ? part : size > limit ? limit / size : Real(1);
    friction *= a.part;
    a.across *= a.part;
    if (a.part < 1) {
        slip = (n.drag[k] * (slip - p.last * sliding) - p.last * friction) / (n.drag[k] + p.last * n.stiffness[k]);
    }
    a.slip = turn.transpose() * slip;
    a.force += friction;
    return a;
}

inline void store_answer(const NodeAnswer& a, const Vec3& displacement, std::size_t k, ContactNodes& n) {
    n.force[k] = a.force;
    n.excess[k] = a.excess;
    n.depth[k] = a.depth;
    n.normal_force[k] = a.normal_force;
    n.duration[k] = a.duration;
    n.slip[k] = a.slip;
    n.last[k] = displacement;
}

/// Adds the nodes' forces to their elements, in the bodies' frames.
void spread_forces(const std::vector<Vec3>& node_force, const NodeFrames& frames, const Solids& solids,
                   std::vector<Vec3>& force);

}  // namespace thixo
