// Elements against walls. A wall takes part as a body of infinite stiffness and mass (dissertation 5.8).
#pragma once

#include "sim/contact/stiffness.h"
#include "sim/space/periodic.h"
#include "sim/space/walls.h"
#include "sim/state/solids.h"

namespace thixo {

/// The thickness of the layer before an element that walls compress [m]. 0: it is no element of the outermost layer, or
/// walls meet the samples of its body in its place (find_contacts).
inline Real layer_beside_walls(const Solids& solids, std::size_t i) {
    const Elements& e = solids.elements;
    if (solids.contacts.by_samples[static_cast<std::size_t>(e.owner[i])]) return 0;
    return e.depth[i] < std::cbrt(e.volume[i]) ? e.depth[i] : Real(0);
}

/// An element that may touch walls: its contact law, and the pose of its body.
struct ElementBesideWalls {
    const StressLaw& law;
    const BodyPose& pose;
    const Elements& elements;
    std::size_t index;
    Real layer;  // layer_beside_walls [m]
};

/// Durations of a step's kick and drift [s].
struct LeapfrogTimes {
    Real kick, drift;
};

/// The end of a kick, and the drift, of an element beside walls. The body's surface lies `layer` before the element. A
/// wall at distance d < layer compresses that layer, and pushes with
///     f_n = max(k (layer - d) - 2 zeta sqrt(k m) v_n, 0),   k = (lambda + 2 mu) V^(1/3)      [N]
/// Friction acts against the sliding velocity that all other forces of the step leave:
///     f_t <= mu f_n
/// It can hold without creep, and never reverses the motion. No element of any layer drifts into the wall: its inward
/// motion ends there. In and out: u [m] and v [m/s] in the body's frame, v after the kick by all other forces.
inline void push_off_walls(const Walls& walls, const Periodic& periodic, const ElementBesideWalls& element,
                           const LeapfrogTimes& times, WallCursor& cursor, Vec3& u, Vec3& v) {
    const auto [kick, drift] = times;
    const auto& [law, pose, e, i, layer] = element;
    const Vec3 x = periodic.wrapped(pose.turn * (xyz(e.rest[i]) + u) + pose.place);
    const Vec3 slow = xyz(e.velocity[i]);
    const Real spring = contact_stiffness(law, e.volume[i], e.mass[i]);
    for (std::size_t k = 0; k < walls.list.size(); ++k) {
        const Wall& wall = walls.list[k];
        Vec3 n;
        const Real d = wall.map.distance(wall.to_wall(x), n, cursor.at[k]);
        if (d >= layer + drift * (v - pose.turn.transpose() * wall.velocity_at(x)).norm()) continue;
        n = pose.turn.transpose() * (wall.turn * n);
        const Vec3 moving = pose.turn.transpose() * wall.velocity_at(x);
        const Real compression = layer > 0 ? layer - d : Real(0);
        if (compression > 0) {
            const Real damping = 2 * law.contact_damping * std::sqrt(spring);
            const Real push = kick * std::max(spring * compression - damping * n.dot(slow - moving), Real(0));
            v += push * n;
            Vec3 slide = v - moving;
            slide -= n * n.dot(slide);
            const Real sliding = slide.norm();
            if (sliding > 0) v -= std::min(law.friction * push / sliding, Real(1)) * slide;
        }
        // The remaining way to the wall. This step may use all of it.
        const Real inward = -n.dot(v - moving);
        if (inward * drift > std::max(d, Real(0))) v += (inward - std::max(d, Real(0)) / drift) * n;
        if (d < 0) u -= d * n;
    }
    u += drift * v;
}

}  // namespace thixo
