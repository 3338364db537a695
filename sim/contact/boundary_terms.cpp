#include "sim/contact/boundary_terms.h"

#include <cmath>

#include "pipeline/base/parallel.h"
#include "sim/contact/answer.h"

namespace thixo {
namespace {

/// sqrt(k m). The product alone leaves the range of a float where matter is as large as an asteroid.
Real root_of_product(Real k, Real m) {
    const int half = std::ilogb(m) / 2;
    return std::ldexp(std::sqrt(k * std::ldexp(m, -2 * half)), half);
}

Mat3 node_stiffness(const BoundaryTerms::Node& n) {
    return n.across * Mat3::Identity() + (n.along - n.across) * n.normal * n.normal.transpose();
}

/// Force and stiffness of the walls on element i, in the frame of its body.
Vec3 wall_force(const Walls& walls, const ElementBesideWalls& element, Real dt, bool frozen, WallCursor& cursor,
                Real* drag, Mat3& stiffness) {
    const auto& [law, pose, e, i, layer] = element;
    const Vec3 x = pose.turn * (xyz(e.rest[i]) + xyz(e.displacement[i])) + pose.place,
               v = pose.turn * xyz(e.velocity[i]);
    const Real spring = contact_stiffness(law, e.volume[i], e.mass[i]) * e.mass[i];
    const Real damping = 2 * law.contact_damping * root_of_product(spring, e.mass[i]), hold = kHold * e.mass[i] / dt;
    Vec3 force(0, 0, 0);
    Mat3 k = Mat3::Zero();
    for (std::size_t w = 0; w < walls.list.size(); ++w) {
        const Wall& wall = walls.list[w];
        Vec3 n;
        const Real d = wall.map.distance(wall.to_wall(x), n, cursor.at[w]);
        if (!(d < layer)) continue;
        n = wall.turn * n;
        const Vec3 against = v - wall.velocity_at(x);
        const Real speed = n.dot(against);
        const auto [push, along] = spring_force(spring, damping, layer - d, speed, dt, true);
        if (!(push > 0)) continue;
        const Vec3 slide = against - speed * n;
        const Real sliding = slide.norm();
        if (!frozen) drag[w] = sliding * hold > law.friction * push ? law.friction * push / sliding : hold;
        force += push * n - drag[w] * slide;
        const Mat3 normal = n * n.transpose();
        k += along * normal + drag[w] / dt * (Mat3::Identity() - normal);
    }
    stiffness = pose.turn.transpose() * k * pose.turn;
    return pose.turn.transpose() * force;
}

}  // namespace

void add_boundary_forces(const Walls& walls, double dt, const Solids& solids, BoundaryTerms& terms,
                         std::vector<Vec3>& force) {
    const ContactNodes& n = solids.contacts.nodes;
    const Elements& e = solids.elements;
    const NodeFrames frames(solids, walls);
    terms.node.resize(n.size());
    terms.force.resize(n.size());
    parallel_for(
        n.size(),
        [&](std::size_t k) {
            const NodeAnswer a =
                answer_of(n, k, motion_of_node(n, e, frames, k), frames.turn(n.partner[k]),
                          conditions_at(solids, k, dt, dt, dt, true), terms.frozen ? terms.node[k].part : Real(-1));
            terms.node[k] = {n.normal[k], a.along, a.across, a.part};
            terms.force[k] = a.force;
        },
        64);
    if (n.size() > 0) spread_forces(terms.force, frames, solids, force);
    terms.walls = !walls.list.empty();
    if (!terms.walls) return;
    terms.wall.resize(e.size());
    terms.drag.resize(e.size() * walls.list.size(), 0);
    parallel_chunks(
        e.size(),
        [&](std::size_t begin, std::size_t end, std::size_t) {
            WallCursor cursor(walls);
            for (std::size_t i = begin; i < end; ++i) {
                terms.wall[i].setZero();
                const Real layer = layer_beside_walls(solids, i);
                if (solids.held[i] || !(layer > 0)) continue;
                const auto owner = static_cast<std::size_t>(e.owner[i]);
                force[i] +=
                    wall_force(walls, {solids.laws[owner], frames.poses[owner], e, i, layer}, static_cast<Real>(dt),
                               terms.frozen, cursor, terms.drag.data() + i * walls.list.size(), terms.wall[i]);
            }
        },
        256);
}

void multiply_boundaries(const Walls& walls, const Solids& solids, const std::vector<Quad>& du, BoundaryTerms& terms,
                         std::vector<Vec3>& out) {
    const ContactNodes& n = solids.contacts.nodes;
    const NodeFrames frames(solids, walls);
    if (n.size() > 0) {
        parallel_for(
            n.size(),
            [&](std::size_t k) {
                terms.force[k].setZero();
                const BoundaryTerms::Node& node = terms.node[k];
                if (!(node.along > 0)) return;
                terms.force[k] = -(node_stiffness(node) * displacement_of_node(n, du, frames, k));
            },
            64);
        spread_forces(terms.force, frames, solids, out);
    }
    if (terms.walls)
        parallel_for(
            out.size(), [&](std::size_t i) { out[i] -= terms.wall[i] * xyz(du[i]); }, 1024);
}

void add_boundary_diagonal(const Solids& solids, const BoundaryTerms& terms, std::vector<Symmetric>& diagonal) {
    const Contacts& c = solids.contacts;
    const auto add = [](Symmetric& to, const Mat3& m) {
        const Symmetric added = symmetric(m);
        to = {to.xx + added.xx, to.yy + added.yy, to.zz + added.zz,
              to.xy + added.xy, to.yz + added.yz, to.zx + added.zx};
    };
    if (c.nodes.size() > 0) {
        const std::vector<BodyPose> poses = poses_of(solids.bodies);
        parallel_for(
            c.touched.size(),
            [&](std::size_t t) {
                const Index i = c.touched[t];
                const Mat3& turn = poses[static_cast<std::size_t>(solids.elements.owner[i])].turn;
                Mat3 sum = Mat3::Zero();
                for (std::size_t l = c.begin[t]; l < c.begin[t + 1]; ++l)
                    sum += square(c.weight[l]) * node_stiffness(terms.node[c.node[l]]);
                add(diagonal[i], turn.transpose() * sum * turn);
            },
            64);
    }
    if (terms.walls)
        parallel_for(
            diagonal.size(), [&](std::size_t i) { add(diagonal[i], terms.wall[i]); }, 1024);
}

void store_boundary_state(const Walls& walls, double dt, Solids& solids) {
    ContactNodes& n = solids.contacts.nodes;
    const NodeFrames frames(solids, walls);
    parallel_for(
        n.size(),
        [&](std::size_t k) {
            const NodeMotion m = motion_of_node(n, solids.elements, frames, k);
            const NodeConditions conditions = conditions_at(solids, k, dt, dt, dt, true);
            store_answer(answer_of(n, k, m, frames.turn(n.partner[k]), conditions), m.displacement, k, n);
        },
        64);
}

}  // namespace thixo
