#include "sim/fracture/rigid_fragments.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "sim/bonds/gradients.h"
#include "sim/bonds/members.h"

namespace thixo {
namespace {

bool is_held(const SolidBody& body, const Solids& solids) {
    return std::ranges::any_of(solids.handles, [&](const Handle& handle) {
        return std::ranges::any_of(body.elements,
                                   [&](Index i) { return std::ranges::binary_search(handle.elements, i); });
    });
}

bool is_too_small(const SolidBody& body, const Elements& e) {
    if (body.size() >= kFewestFlat) return false;
    return body.size() < kFewestElastic ||
           std::ranges::none_of(body.elements, [&](Index i) { return e.bonds.moment[i].full; });
}

/// Cracks no longer weaken bonds between these elements.
void forget_crossings(const Solids& solids, BondCrossings& crossings) {
    std::vector<Index> rows;
    for (Index k = 0; k < crossings.size(); ++k)
        if (!solids.owner(crossings.first[k]).rigid) rows.push_back(k);
    keep_table_rows(crossings, rows);
}

/// Appends a part of element i at `offset` from its place, with a particle.
void append_part(Index i, const Vec3& offset, const Matter& matter) {
    Solids& solids = matter.solids;
    Elements& e = solids.elements;
    Particles& p = matter.particles;
    const Index part = append_element(e, matter.next_id, e.owner[i]);
    for_each_array(e, [&](const char*, auto& array) {
        if (!array.empty()) array[part] = array[i];
    });
    e.id[part] = matter.next_id;
    e.rest[part] = quad(xyz(e.rest[i]) + offset, e.rest[i].w);
    if (e.softens) {
        e.law[part] = part;
        solids.softening.flow.plastic.push_back(solids.softening.flow.plastic[i]);
    }
    solids.bodies[static_cast<std::size_t>(e.owner[i])].elements.push_back(part);
    number_element(matter.next_id, part, solids);

    const Index from = solids.particle_of[i], k = append_row(p);
    for_each_array(p, [&](const char*, auto& array) { array[k] = array[from]; });
    p.id[k] = matter.next_id++;
    solids.particle_of.push_back(k);
}

void place_particle(Index i, const Matter& matter) {
    const Elements& e = matter.solids.elements;
    const SolidBody& body = matter.solids.owner(i);
    const Index k = matter.solids.particle_of[i];
    matter.particles.position[k] =
        (body.turn * (xyz(e.rest[i]) + xyz(e.displacement[i])).cast<double>() + body.place).cast<Real>();
    matter.particles.mass[k] = e.mass[i];
    matter.particles.rest_volume[k] = e.volume[i];
}

}  // namespace

void split_elements(const std::vector<Index>& which, const Matter& matter) {
    if (which.empty()) return;
    const std::array<Vec3, 4> corners{Vec3(1, 1, 1), Vec3(1, -1, -1), Vec3(-1, 1, -1), Vec3(-1, -1, 1)};
    Solids& solids = matter.solids;
    Elements& e = solids.elements;
    std::vector<Index> origin(e.size());
    std::iota(origin.begin(), origin.end(), Index(0));
    for (const Index i : which) {
        const Mat3 h = gradient_of(e, i);
        const Real reach = std::cbrt(e.volume[i]) / (2 * std::sqrt(Real(3)));
        for (auto* array : {&e.mass, &e.volume, &e.quadrature}) (*array)[i] /= 4;
        std::vector<Index> parts{i};
        for (std::size_t c = 1; c < corners.size(); ++c) {
            append_part(i, reach * corners[c], matter);
            parts.push_back(static_cast<Index>(e.size() - 1));
            origin.push_back(i);
        }
        e.rest[i] = quad(xyz(e.rest[i]) + reach * corners[0], e.rest[i].w);
        for (std::size_t c = 0; c < corners.size(); ++c) {
            e.displacement[parts[c]] = quad(xyz(e.displacement[parts[c]]) + h * (reach * corners[c]));
            place_particle(parts[c], matter);
        }
    }
    bond_parts(origin, solids);
    solids.altered = true;
}

std::vector<std::uint8_t> make_rigid(const std::vector<std::uint8_t>& bodies, const Matter& matter) {
    Solids& solids = matter.solids;
    Elements& e = solids.elements;
    std::vector<std::uint8_t> now(solids.bodies.size(), 0);
    std::vector<Index> split;
    for (std::size_t b = 0; b < bodies.size(); ++b) {
        SolidBody& body = solids.bodies[b];
        if (!bodies[b] || body.empty() || is_held(body, solids)) continue;
        if (!body.rigid && !is_too_small(body, e)) continue;
        body.rigid = true;
        now[b] = 1;
        for (const Index i : body.elements) {
            e.quadrature[i] = 0;
            if (e.breaks) e.strength[i] = kUnbreakable;
            if (!e.bonds.moment[i].full) split.push_back(i);
        }
    }
    if (std::ranges::none_of(now, [](std::uint8_t n) { return n != 0; })) return now;
    forget_crossings(solids, solids.cracks.crossings);
    split_elements(split, matter);
    e.bonds.changed();
    return now;
}

}  // namespace thixo
