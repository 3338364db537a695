#include "pipeline/base/parallel.h"
#include "sim/solid/contact.h"
#include "sim/solid/solids.h"
#include "sim/solid/wall_contact.h"

namespace thixo {
namespace {

constexpr Real kBraked = Real(0.25);  // depth in particle widths from which on what goes deeper is braked

struct Motion {
    Vec3 way, velocity;  // of the owner against the partner, in the world
};

Motion motion_of_node(const ContactNodes& n, const Elements& e, const std::vector<BodyPose>& poses, std::size_t k) {
    const auto sum = [&](std::size_t begin, std::size_t end, std::int32_t body) {
        Motion m{Vec3::Zero(), Vec3::Zero()};
        for (std::size_t l = begin; l < end; ++l) {
            const Real w = n.weights.weight[l];
            m.way += w * xyz(e.displacement[n.weights.element[l]]);
            m.velocity += w * xyz(e.velocity[n.weights.element[l]]);
        }
        const Mat3& turn = poses[static_cast<std::size_t>(body)].turn;
        return Motion{turn * m.way, turn * m.velocity};
    };
    const Motion a = sum(n.weights.begin[k], n.middle[k], n.owner[k]);
    const Motion b = sum(n.middle[k], n.weights.begin[k + 1], n.partner[k]);
    return {a.way + b.way, a.velocity + b.velocity};
}

struct Press {
    Real brake, outwards;  // [1/s], [m]
    Real dt, last;         // the sub-step to come, the one that led here [s]
};

/// The force of node k; friction's spring and the excess go on.
Vec3 force_of_node(const Motion& m, const Mat3& turn, const Press& press, Real width, ContactNodes& n, std::size_t k) {
    const Vec3& normal = n.normal[k];
    const Real gap = n.gap[k] + normal.dot(m.way - n.start[k]);
    // Only while it presses hardly: what parts faster, or cannot part, is not helped on.
    if (n.excess[k] - gap < kUnexplained * width) n.excess[k] = std::min(n.excess[k] + press.outwards, Real(0));
    n.depth[k] = std::max(n.excess[k] - gap, Real(0));
    const Real speed = normal.dot(m.velocity);
    Real push = n.depth[k] > 0 ? std::max(n.stiffness[k] * n.depth[k] - n.damping[k] * speed, Real(0)) : Real(0);
    if (gap < -kBraked * width && speed < 0) push -= press.brake * n.brake[k] * speed;
    if (push > 0) {
        n.pressed[k] = std::min(n.pressed[k] + press.dt, n.memory[k]);
        n.press[k] += (push - n.press[k]) * press.dt / n.pressed[k];
    }
    const Real most = push > 0 ? n.friction[k] * n.press[k] : Real(0);
    if (!(most > 0)) {
        n.slip[k].setZero();
        n.last[k] = m.way;
        return push * normal;
    }
    Vec3 slip = turn * n.slip[k] + (m.way - n.last[k]);
    slip -= normal * normal.dot(slip);
    const Vec3 sliding = m.velocity - speed * normal;
    Vec3 rub = -n.stiffness[k] * slip - n.drag[k] * sliding;
    const Real size = rub.norm();
    if (size > most) {
        rub *= most / size;
        slip = (n.drag[k] * (slip - press.last * sliding) - press.last * rub) /
               (n.drag[k] + press.last * n.stiffness[k]);
    }
    n.slip[k] = turn.transpose() * slip;
    n.last[k] = m.way;
    return push * normal + rub;
}

}  // namespace

void follow_contacts(Solids& solids) {
    ContactNodes& n = solids.contacts.nodes;
    const std::vector<BodyPose> poses = poses_of(solids.bodies);
    parallel_for(
        n.size(),
        [&](std::size_t k) {
            if (!(n.friction[k] * n.depth[k] > 0)) return;
            const Vec3 way = motion_of_node(n, solids.elements, poses, k).way;
            n.slip[k] += poses[static_cast<std::size_t>(n.partner[k])].turn.transpose() * (way - n.last[k]);
            n.last[k] = way;
        },
        64);
}

void press_contacts(double dt, Solids& solids) {
    Contacts& c = solids.contacts;
    ContactNodes& n = c.nodes;
    if (n.size() == 0) return;
    const Elements& e = solids.elements;
    const std::vector<BodyPose> poses = poses_of(solids.bodies);
    const double kick = 0.5 * (solids.last_dt + dt);
    parallel_for(
        n.size(),
        [&](std::size_t k) {
            const auto partner = static_cast<std::size_t>(n.partner[k]);
            const Real width = std::cbrt(e.volume[solids.bodies[partner].begin]);
            const Press press{static_cast<Real>(0.5 / kick), kOutwards * width * static_cast<Real>(dt),
                              static_cast<Real>(dt), static_cast<Real>(solids.last_dt)};
            n.force[k] = force_of_node(motion_of_node(n, e, poses, k), poses[partner].turn, press, width, n, k);
        },
        64);
    parallel_for(
        c.touched.size(),
        [&](std::size_t t) {
            Vec3 sum(0, 0, 0);
            for (std::size_t l = c.begin[t]; l < c.begin[t + 1]; ++l) sum += c.weight[l] * n.force[c.node[l]];
            const Index i = c.touched[t];
            solids.force[i] += poses[static_cast<std::size_t>(e.owner[i])].turn.transpose() * sum;
        },
        64);
}

}  // namespace thixo
