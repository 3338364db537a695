#include "sim/contact/answer.h"

#include "pipeline/base/parallel.h"

namespace thixo {

void spread_forces(const std::vector<Vec3>& node_force, const NodeFrames& frames, const Solids& solids,
                   std::vector<Vec3>& force) {
    const Contacts& c = solids.contacts;
    parallel_for(
        c.touched.size(),
        [&](std::size_t t) {
            Vec3 sum(0, 0, 0);
            for (std::size_t l = c.begin[t]; l < c.begin[t + 1]; ++l) sum += c.weight[l] * node_force[c.node[l]];
            const Index i = c.touched[t];
            force[i] += frames.turn(solids.elements.owner[i]).transpose() * sum;
        },
        64);
}

void follow_contacts(const Walls& walls, Solids& solids) {
    ContactNodes& n = solids.contacts.nodes;
    const NodeFrames frames(solids, walls);
    parallel_for(
        n.size(),
        [&](std::size_t k) {
            if (!(n.friction[k] * n.depth[k] > 0)) return;
            const Vec3 displacement = motion_of_node(n, solids.elements, frames, k).displacement;
            n.slip[k] += frames.turn(n.partner[k]).transpose() * (displacement - n.last[k]);
            n.last[k] = displacement;
        },
        64);
}

NodeConditions conditions_at(const Solids& solids, std::size_t node, double kick, double dt, double last,
                             bool backwards) {
    const ContactNodes& n = solids.contacts.nodes;
    const std::int32_t body = is_wall(n.partner[node]) ? n.owner[node] : n.partner[node];
    const Real width = std::cbrt(solids.elements.volume[solids.bodies[static_cast<std::size_t>(body)].typical]);
    return {static_cast<Real>(0.5 / kick),
            kOutwards * width * static_cast<Real>(dt),
            static_cast<Real>(dt),
            static_cast<Real>(last),
            width,
            backwards};
}

void add_contact_forces(const Walls& walls, double dt, Solids& solids) {
    ContactNodes& n = solids.contacts.nodes;
    if (n.size() == 0) return;
    const NodeFrames frames(solids, walls);
    const double kick = 0.5 * (solids.last_dt + dt);
    parallel_for(
        n.size(),
        [&](std::size_t k) {
            const NodeMotion m = motion_of_node(n, solids.elements, frames, k);
            const NodeConditions conditions = conditions_at(solids, k, kick, dt, solids.last_dt);
            store_answer(answer_of(n, k, m, frames.turn(n.partner[k]), conditions), m.displacement, k, n);
        },
        64);
    spread_forces(n.force, frames, solids, solids.force);
}

}  // namespace thixo
