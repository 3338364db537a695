#include "sim/solid/grips.h"

#include "pipeline/base/parallel.h"

namespace thixo {
namespace {

Vec3d in_world(const SolidBody& body, const Elements& e, Index i) {
    return body.turn * (xyz(e.rest[i]).cast<double>() + xyz(e.displacement[i]).cast<double>()) + body.place;
}

/// The grip's pose at `start` taken out: the motion from there on.
Vec3d carried(const Grip& grip, double time, const Vec3d& anchor) {
    return grip.motion.pose(time).apply(grip.motion.pose(grip.start).apply_inverse(anchor));
}

}  // namespace

void take_hold(double time, const Vec3& gravity, Solids& solids) {
    Elements& e = solids.elements;
    solids.held.assign(e.size(), 0);
    solids.external.resize(e.size());
    parallel_for(e.size(), [&](std::size_t i) {
        const SolidBody& body = solids.bodies[static_cast<std::size_t>(e.owner[i])];
        solids.external[i] = (body.turn.transpose() * gravity.cast<double>()).cast<Real>();
    });
    for (std::size_t g = 0; g < solids.grips.size(); ++g) {
        Grip& grip = solids.grips[g];
        if (!grip.active(time)) continue;
        const SolidBody& body = solids.bodies[static_cast<std::size_t>(e.owner[grip.elements.front()])];
        if (grip.pulls()) {
            const Vec3 pull = (body.turn.transpose() * (grip.force / grip.mass)).cast<Real>();
            for (const Index i : grip.elements) solids.external[i] += pull;
            continue;
        }
        if (grip.anchor.empty())
            for (const Index i : grip.elements) grip.anchor.push_back(in_world(body, e, i));
        // What has melted slips out of the hand.
        for (const Index i : grip.elements)
            if (!solids.phases.any || solids.phases.bond[i] == Bond::rest)
                solids.held[i] = static_cast<std::uint8_t>(g + 1);
    }
}

void move_held(double to, double dt, Solids& solids) {
    Elements& e = solids.elements;
    for (std::size_t g = 0; g < solids.grips.size(); ++g) {
        const Grip& grip = solids.grips[g];
        if (grip.anchor.empty()) continue;
        parallel_for(grip.elements.size(), [&](std::size_t k) {
            const Index i = grip.elements[k];
            if (solids.held[i] != g + 1) return;
            const SolidBody& body = solids.bodies[static_cast<std::size_t>(e.owner[i])];
            const Vec3d y = body.turn.transpose() * (carried(grip, to, grip.anchor[k]) - body.place);
            const Vec3d u = y - xyz(e.rest[i]).cast<double>();
            e.velocity[i] = quad(((u - xyz(e.displacement[i]).cast<double>()) / dt).cast<Real>());
            e.displacement[i] = quad(u.cast<Real>());
            e.acceleration[i] = Vec3::Zero();
        });
    }
}

}  // namespace thixo
