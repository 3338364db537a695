// How one node between two bodies answers their motion.
#pragma once

#include "sim/contact/contact.h"
#include "sim/contact/walls.h"
#include "sim/state/solids.h"

namespace thixo {

inline constexpr Real kBraked = Real(0.25);  // depth in particle widths from which on what goes deeper is braked

struct NodeMotion {
    Vec3 way, velocity;  // of the owner against the partner, in the world
};

/// Sum over a node's elements of what `add(element, weight, motion)` makes of them, in the world.
template <class Add>
NodeMotion sum_of_node(const ContactNodes& n, const std::vector<BodyPose>& poses, std::size_t k, Add&& add) {
    const auto sum = [&](std::size_t begin, std::size_t end, std::int32_t body) {
        NodeMotion m{Vec3::Zero(), Vec3::Zero()};
        for (std::size_t l = begin; l < end; ++l) add(n.weights.element[l], n.weights.weight[l], m);
        const Mat3& turn = poses[static_cast<std::size_t>(body)].turn;
        return NodeMotion{turn * m.way, turn * m.velocity};
    };
    const NodeMotion a = sum(n.weights.begin[k], n.middle[k], n.owner[k]);
    const NodeMotion b = sum(n.middle[k], n.weights.begin[k + 1], n.partner[k]);
    return {a.way + b.way, a.velocity + b.velocity};
}
inline NodeMotion motion_of_node(const ContactNodes& n, const Elements& e, const std::vector<BodyPose>& poses,
                                 std::size_t k) {
    return sum_of_node(n, poses, k, [&](Index i, Real w, NodeMotion& m) {
        m.way += w * xyz(e.displacement[i]);
        m.velocity += w * xyz(e.velocity[i]);
    });
}

/// What all nodes have in common at one instant.
struct Pressing {
    Real brake, outwards;  // [1/s], [m]
    Real dt, last;         // the step that the force acts over, the one that led here [s]
    Real width;            // of the partner's particles [m]
    bool backwards;        // of a step backwards in time, which asks for forces without jumps
};

/// The force k d - c v of a spring that is pressed by d and a damper, never pulling, and minus its derivative for v =
/// change of -d per `last`. Backwards in time what is struck is damped by no more than the spring's own force: it does
/// not jump.
struct SpringForce {
    Real force, stiffness;
};
inline SpringForce spring_force(Real k, Real c, Real d, Real v, Real last, bool backwards) {
    const Real force = k * d - c * v, per_last = last > 0 ? 1 / last : Real(0);
    if (!(d > 0 && force > 0)) return {0, 0};
    if (backwards && force > 2 * k * d) return {2 * k * d, 2 * k};
    return {force, k + c * per_last};
}

/// With a partner's particles, for forces that act over `dt` and brake over `kick`, `last` after the state before [s].
Pressing pressing_of(const Solids& solids, std::size_t partner, double kick, double dt, double last,
                     bool backwards = false);

/// The answer, and the node's state after it.
struct NodeAnswer {
    Vec3 force;          // on the owner, in the world [N]
    Real along, across;  // |d force/d way| of a step `last` backwards in time, along the normal and across [N/m]
    Real part;           // that friction's limit leaves of what its spring and damper would do [1]
    Real excess, depth, normal_force, duration;
    Vec3 slip;  // in the partner's frame
};

/// The law of press_contacts for one node. Sliding counts across as stiff as it would be to get where it got (a
/// secant), and where `part` is given, not below 0, that is the part that friction leaves, whatever its limit.
inline NodeAnswer answer_of(const ContactNodes& n, std::size_t k, const NodeMotion& m, const Mat3& turn,
                            const Pressing& p, Real part = -1) {
    NodeAnswer a{Vec3::Zero(), 0, 0, 0, n.excess[k], 0, n.normal_force[k], n.duration[k], Vec3::Zero()};
    const Vec3& normal = n.normal[k];
    const Real gap = n.gap[k] + normal.dot(m.way - n.start[k]);
    // Only while it presses hardly: what parts faster, or cannot part, is not helped on.
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
    Vec3 slip = turn * n.slip[k] + (m.way - n.last[k]);
    slip -= normal * normal.dot(slip);
    const Vec3 sliding = m.velocity - speed * normal;
    Vec3 rub = -n.stiffness[k] * slip - n.drag[k] * sliding;
    a.across = n.stiffness[k] + n.drag[k] * per_last;
    const Real size = rub.norm();
    a.part = part >= 0 ? part : size > most ? most / size : Real(1);
    rub *= a.part;
    a.across *= a.part;
    if (a.part < 1) {
        slip = (n.drag[k] * (slip - p.last * sliding) - p.last * rub) / (n.drag[k] + p.last * n.stiffness[k]);
    }
    a.slip = turn.transpose() * slip;
    a.force += rub;
    return a;
}

inline void take_answer(const NodeAnswer& a, const Vec3& way, std::size_t k, ContactNodes& n) {
    n.force[k] = a.force;
    n.excess[k] = a.excess;
    n.depth[k] = a.depth;
    n.normal_force[k] = a.normal_force;
    n.duration[k] = a.duration;
    n.slip[k] = a.slip;
    n.last[k] = way;
}

/// Adds the nodes' forces to those of their elements, in the bodies' frames.
void spread_forces(const std::vector<Vec3>& node_force, const std::vector<BodyPose>& poses, const Solids& solids,
                   std::vector<Vec3>& force);

}  // namespace thixo
