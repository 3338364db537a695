#include "sim/external/handles.h"

#include "pipeline/base/parallel.h"

namespace thixo {
namespace {

Vec3d in_world(const SolidBody& body, const Elements& e, Index i) {
    return body.turn * (xyz(e.rest[i]).cast<double>() + xyz(e.displacement[i]).cast<double>()) + body.place;
}

/// Where the handle has carried `anchor` by `time`: its motion since `start`.
Vec3d carried(const Handle& handle, double time, const Vec3d& anchor) {
    return handle.motion.pose(time).apply(handle.motion.pose(handle.start).apply_inverse(anchor));
}

}  // namespace

void take_hold(double time, const Outside& outside, Solids& solids) {
    Elements& e = solids.elements;
    solids.held.assign(e.size(), 0);
    solids.external.resize(e.size());
    const std::vector<BodyPose> poses = poses_of(solids.bodies);
    parallel_for(e.size(), [&](std::size_t i) {
        const BodyPose& pose = poses[static_cast<std::size_t>(e.owner[i])];
        const Vec3 place = pose.turn * (xyz(e.rest[i]) + xyz(e.displacement[i])) + pose.place;
        const Vec3 a = acceleration_from_outside(outside, place, pose.turn * xyz(e.velocity[i]));
        solids.external[i] = (solids.owner(i).turn.transpose() * a.cast<double>()).cast<Real>();
    });
    for (std::size_t g = 0; g < solids.handles.size(); ++g) {
        Handle& handle = solids.handles[g];
        if (!handle.active(time)) continue;
        if (handle.elements.empty()) continue;
        if (handle.pulls()) {
            for (const Index i : handle.elements)
                solids.external[i] += (solids.owner(i).turn.transpose() * (handle.force / handle.mass)).cast<Real>();
            continue;
        }
        if (handle.anchor.empty())
            for (const Index i : handle.elements) handle.anchor.push_back(in_world(solids.owner(i), e, i));
        // Molten matter is no longer held.
        for (const Index i : handle.elements)
            if (e.phase_of(i) == Phase::solid) solids.held[i] = static_cast<std::uint8_t>(g + 1);
    }
}

void move_held(double to, double dt, Solids& solids) {
    Elements& e = solids.elements;
    for (std::size_t g = 0; g < solids.handles.size(); ++g) {
        const Handle& handle = solids.handles[g];
        if (handle.anchor.empty()) continue;
        parallel_for(handle.elements.size(), [&](std::size_t k) {
            const Index i = handle.elements[k];
            if (solids.held[i] != g + 1) return;
            const SolidBody& body = solids.owner(i);
            const Vec3d y = body.turn.transpose() * (carried(handle, to, handle.anchor[k]) - body.place);
            const Vec3d u = y - xyz(e.rest[i]).cast<double>();
            e.velocity[i] = quad(((u - xyz(e.displacement[i]).cast<double>()) / dt).cast<Real>());
            e.displacement[i] = quad(u.cast<Real>());
            e.acceleration[i] = Vec3::Zero();
        });
    }
}

}  // namespace thixo
