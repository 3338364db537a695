#include "sim/surface/refrozen_surface.h"

#include <algorithm>

#include "pipeline/base/parallel.h"

namespace thixo {
namespace {

/// Whether a body is solid throughout, on a rest shape in which it has frozen.
bool refrozen_throughout(const Solids& solids, const SolidBody& body) {
    return body.refrozen &&
           std::ranges::all_of(body.elements, [&](Index i) { return solids.elements.solidity(i) == 1; });
}

std::vector<PointGrid> rest_grids(const Solids& solids, Real cell) {
    std::vector<PointGrid> grids(solids.bodies.size());
    for (std::size_t b = 0; b < grids.size(); ++b) {
        const SolidBody& body = solids.bodies[b];
        if (body.skin == Skin::rebound) grids[b].build(rest_places(body, solids.elements), cell);
    }
    return grids;
}

/// A bound surfel.
struct BoundDisc {
    Vec3 place, axis1, axis2;
};

/// The map between the material frame of a bound body and the world.
struct RestField {
    const PointGrid& grid;
    const SolidBody& body;
    const Solids& solids;

    Real support(const Vec3& m, Real disc) const {
        return std::min(weights_support(grid, m, disc, solids.elements.support[body.typical]), grid.cell());
    }
    /// Solves y = m + u(m) for m, with y a place of the body's frame. u changes little from place to place.
    Vec3 material(const Vec3& y, Real disc) const {
        Vec3 m = y;
        for (int k = 0; k < 12; ++k) m = y - displacement(grid, body, solids, m, support(m, disc));
        return m;
    }
    BoundDisc bind(const SurfelCloud& cloud, Index i) const {
        const Mat3d back = body.turn.transpose();
        const Real disc = std::max(cloud.axis1[i].norm(), cloud.axis2[i].norm());
        const auto at = [&](const Vec3& x) {
            return material((back * (x.cast<double>() - body.place)).cast<Real>(), disc);
        };
        const Vec3& x = cloud.position[i];
        const Vec3 m = at(x);
        return {m, at(x + cloud.axis1[i]) - m, at(x + cloud.axis2[i]) - m};
    }
    void show(const BoundDisc& d, Index i, SurfelCloud& cloud) const {
        const Mat3 turn = body.turn.cast<Real>();
        const Real reach = support(d.place, std::max(d.axis1.norm(), d.axis2.norm()));
        const auto shift = [&](const Vec3& m) { return displacement(grid, body, solids, m, reach); };
        const Vec3 u = shift(d.place);
        cloud.position[i] = (body.turn * (d.place + u).cast<double>() + body.place).cast<Real>();
        const Vec3 a = turn * (d.axis1 + shift(d.place + d.axis1) - u);
        const Vec3 b = turn * (d.axis2 + shift(d.place + d.axis2) - u);
        const Vec3 n = a.cross(b);
        cloud.axis1[i] = a;
        cloud.axis2[i] = b;
        if (n.squaredNorm() > 0) cloud.normal[i] = n.normalized();
    }
};

void drop_zombies(std::int32_t body, Zombies& zombies) {
    std::vector<Index> others;
    for (Index k = 0; k < zombies.size(); ++k)
        if (zombies.body[k] != body) others.push_back(k);
    keep_table_rows(zombies, others);
}

/// The body of every surfel that belongs to a bound one.
std::vector<std::int32_t> bound_owner(const Solids& solids, const Particles& particles, Real support,
                                      const SurfaceState& animated) {
    std::vector<Vec3> melted;
    std::vector<std::int32_t> material;
    for (std::size_t k = 0; k < particles.size(); ++k)
        if (particles.melt[k] > 0) {
            melted.push_back(particles.position[k]);
            material.push_back(particles.material[k]);
        }
    PointGrid grid;
    grid.build(melted, support);
    std::vector<std::pair<std::int32_t, std::int32_t>> bound;  // id and index of a body
    for (std::size_t b = 0; b < solids.bodies.size(); ++b)
        if (solids.bodies[b].skin == Skin::rebound)
            bound.emplace_back(solids.bodies[b].id, static_cast<std::int32_t>(b));
    std::ranges::sort(bound);
    std::vector<std::int32_t> owner(animated.size(), -1);
    parallel_for(animated.size(), [&](std::size_t i) {
        const auto found = std::ranges::lower_bound(bound, std::pair(animated.body[i], std::int32_t(0)));
        if (found == bound.end() || found->first != animated.body[i]) return;
        owner[i] = found->second;
        bool free = true;
        grid.for_each_neighbour(animated.surfels.position[i], support, [&](Index k, Real) {
            free = free && material[k] != solids.bodies[static_cast<std::size_t>(owner[i])].material;
        });
        if (!free) owner[i] = -1;
    });
    return owner;
}

}  // namespace

void release_thawed(Solids& solids, const SurfaceState& animated, Zombies& zombies) {
    for (SolidBody& body : solids.bodies) {
        if (body.skin != Skin::rebound || refrozen_throughout(solids, body)) continue;
        body.skin = Skin::animated;
        for (std::size_t i = 0; i < animated.size(); ++i)
            if (animated.body[i] == body.id)
                add_zombie(animated.surfels, i, animated.rest[i], body.material, body.id, zombies);
    }
}

void follow_refrozen(Solids& solids, const Particles& particles, Real support, SurfaceState& animated,
                     RefrozenSurface& refrozen, Zombies& zombies) {
    bool any = false;
    for (SolidBody& body : solids.bodies) {
        if (body.skin == Skin::animated && refrozen_throughout(solids, body)) {
            body.skin = Skin::rebound;
            drop_zombies(body.id, zombies);
        }
        any = any || body.skin == Skin::rebound;
    }
    std::vector<std::pair<std::int64_t, Index>> surfels;  // those that are bound now, by id
    std::vector<std::int32_t> owner;
    if (any) {
        owner = bound_owner(solids, particles, support, animated);
        for (Index i = 0; i < animated.size(); ++i)
            if (owner[i] >= 0) surfels.emplace_back(animated.id[i], i);
        std::ranges::sort(surfels);
    }
    const std::vector<PointGrid> grids = rest_grids(solids, 2 * support);
    RefrozenSurface now;
    now.id.resize(surfels.size());
    for (auto* array : {&now.place, &now.axis1, &now.axis2}) array->resize(surfels.size(), Vec3::Zero());
    parallel_for(surfels.size(), [&](std::size_t k) {
        const auto [id, i] = surfels[k];
        const auto b = static_cast<std::size_t>(owner[i]);
        const RestField field{grids[b], solids.bodies[b], solids};
        const auto found = std::ranges::lower_bound(refrozen.id, id);
        const bool known = found != refrozen.id.end() && *found == id;
        const auto at = static_cast<std::size_t>(found - refrozen.id.begin());
        const BoundDisc disc = known ? BoundDisc{refrozen.place[at], refrozen.axis1[at], refrozen.axis2[at]}
                                     : field.bind(animated.surfels, i);
        now.id[k] = id;
        now.place[k] = disc.place;
        now.axis1[k] = disc.axis1;
        now.axis2[k] = disc.axis2;
        field.show(disc, i, animated.surfels);
    });
    refrozen = std::move(now);
}

}  // namespace thixo
