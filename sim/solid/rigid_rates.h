// The rigid motion that has a body's momenta.
#pragma once

#include <utility>

#include "pipeline/base/parallel.h"
#include "sim/state/bodies.h"

namespace thixo {

/// Mass [kg], centre [m], velocity [m/s], angular momentum about the centre [kg m^2/s], spin [1/s] and inertia
/// [kg m^2] of point masses, in one frame.
struct RigidRates {
    double mass = 0;
    Vec3d centre{0, 0, 0}, velocity{0, 0, 0}, angular{0, 0, 0}, spin{0, 0, 0};
    Mat3d inertia = Mat3d::Zero();

    /// The spin that has this angular momentum. None about a line on which all the masses lie.
    Vec3d spin_of(const Vec3d& momentum) const;
};

/// Sums up the rigid motion of a body, `motion(k)` the place and momentum of its k-th element.
template <class F>
RigidRates rigid_rates(const SolidBody& body, const Elements& e, F&& motion) {
    struct Moments {
        double mass = 0;
        Vec3d first = Vec3d::Zero(), momentum = Vec3d::Zero(), angular = Vec3d::Zero();
        Mat3d second = Mat3d::Zero();
        Moments operator+(const Moments& b) const {
            return {mass + b.mass, first + b.first, momentum + b.momentum, angular + b.angular, second + b.second};
        }
    };
    const Moments sum = parallel_sum<Moments>(
        body.size(),
        [&](std::size_t k) {
            const double m = static_cast<double>(e.mass[body.elements[k]]);
            const auto [y, p] = motion(k);
            return Moments{m, m * y, p, y.cross(p), m * y * y.transpose()};
        },
        Moments{});
    RigidRates r;
    r.mass = sum.mass;
    r.centre = sum.first / sum.mass;
    r.velocity = sum.momentum / sum.mass;
    const Mat3d spread = sum.second - sum.mass * r.centre * r.centre.transpose();
    r.inertia = spread.trace() * Mat3d::Identity() - spread;
    r.angular = sum.angular - r.centre.cross(sum.momentum);
    r.spin = r.spin_of(r.angular);
    return r;
}

/// A body that nothing acts on turns so that its angular momentum stays. It turns by the spin at half the step, and
/// ends with the spin of the end. Both are in the frame that turns with the body.
struct Turning {
    Mat3d turn;          // Q, from the old frame to the new one
    Vec3d spin, change;  // omega [1/s], its rate [1/s^2]
};
Turning turn_on(const RigidRates& rates, double dt);

}  // namespace thixo
