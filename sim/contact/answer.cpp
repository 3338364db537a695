#include "sim/contact/answer.h"

#include "pipeline/base/parallel.h"

namespace thixo {

void spread_forces(const std::vector<Vec3>& node_force, const std::vector<BodyPose>& poses, const Solids& solids,
                   std::vector<Vec3>& force) {
    const Contacts& c = solids.contacts;
    parallel_for(
        c.touched.size(),
        [&](std::size_t t) {
            Vec3 sum(0, 0, 0);
            for (std::size_t l = c.begin[t]; l < c.begin[t + 1]; ++l) sum += c.weight[l] * node_force[c.node[l]];
            const Index i = c.touched[t];
            force[i] += poses[static_cast<std::size_t>(solids.elements.owner[i])].turn.transpose() * sum;
        },
        64);
}

void follow_contacts(Solids& solids) {
    ContactNodes& n = solids.contacts.nodes;
    const std::vector<BodyPose> poses = poses_of(solids.bodies);
    parallel_for(
        n.size(),
        [&](std::size_t k) {
            if (!(n.friction[k] * n.depth[k] > 0)) return;
            const Vec3 displacement = motion_of_node(n, solids.elements, poses, k).displacement;
            n.slip[k] += poses[static_cast<std::size_t>(n.partner[k])].turn.transpose() * (displacement - n.last[k]);
            n.last[k] = displacement;
        },
        64);
}

NodeConditions conditions_at(const Solids& solids, std::size_t partner, double kick, double dt, double last,
                             bool backwards) {
    const Real width = std::cbrt(solids.elements.volume[solids.bodies[partner].typical]);
    return {static_cast<Real>(0.5 / kick),
            kOutwards * width * static_cast<Real>(dt),
            static_cast<Real>(dt),
            static_cast<Real>(last),
            width,
            backwards};
}

void add_contact_forces(double dt, Solids& solids) {
    ContactNodes& n = solids.contacts.nodes;
    if (n.size() == 0) return;
    const std::vector<BodyPose> poses = poses_of(solids.bodies);
    const double kick = 0.5 * (solids.last_dt + dt);
    parallel_for(
        n.size(),
        [&](std::size_t k) {
            const auto partner = static_cast<std::size_t>(n.partner[k]);
            const NodeMotion m = motion_of_node(n, solids.elements, poses, k);
            const NodeConditions conditions = conditions_at(solids, partner, kick, dt, solids.last_dt);
            store_answer(answer_of(n, k, m, poses[partner].turn, conditions), m.displacement, k, n);
        },
        64);
    spread_forces(n.force, poses, solids, solids.force);
}

}  // namespace thixo
