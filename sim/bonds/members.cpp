#include "sim/bonds/members.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "sim/bonds/rest_shape.h"

namespace thixo {
namespace {

/// One bond of an element, with all its fields.
struct Bond {
    Index neighbour;
    Real weight, weight_back, base, base_back, visibility;
    Vec3 across{0, 0, 0};
};
using BondLists = std::vector<std::vector<Bond>>;

BondLists unpack(const Bonds& bonds) {
    const bool has_base = !bonds.base.empty(), has_visibility = !bonds.visibility.empty();
    BondLists lists(bonds.size());
    parallel_for(lists.size(), [&](std::size_t i) {
        for (std::size_t k = bonds.begin[i]; k < bonds.begin[i + 1]; ++k)
            if (const Index j = bonds.neighbour[k]; j != i)
                lists[i].push_back(
                    {j, bonds.weight[k], bonds.weight_back[k], has_base ? bonds.base[k] : Real(0),
                     has_base ? bonds.base_back[k] : Real(0), has_visibility ? bonds.visibility[k] : Real(1),
                     bonds.wrap() ? Vec3(bonds.across[0][k], bonds.across[1][k], bonds.across[2][k]) : Vec3(0, 0, 0)});
    });
    return lists;
}

void pack(const BondLists& lists, Bonds& bonds) {
    const bool has_base = !bonds.base.empty(), has_visibility = !bonds.visibility.empty();
    const std::size_t n = lists.size();
    bonds.begin.assign(n + 1, 0);
    for (std::size_t i = 0; i < n; ++i)
        bonds.begin[i + 1] = bonds.begin[i] + (lists[i].size() + kLanes - 1) / kLanes * kLanes;
    const std::size_t total = bonds.begin[n];
    bonds.neighbour.resize(total);
    for (auto* array : {&bonds.weight, &bonds.weight_back}) array->assign(total, 0);
    for (auto* array : {&bonds.base, &bonds.base_back}) array->assign(has_base ? total : 0, 0);
    bonds.visibility.assign(has_visibility ? total : 0, 1);
    const bool wrap = bonds.wrap();
    for (auto& array : bonds.across) array.assign(wrap ? total : 0, 0);
    parallel_for(n, [&](std::size_t i) {
        std::size_t k = bonds.begin[i];
        for (const Bond& bond : lists[i]) {
            bonds.neighbour[k] = bond.neighbour;
            bonds.weight[k] = bond.weight;
            bonds.weight_back[k] = bond.weight_back;
            if (has_base) bonds.base[k] = bond.base, bonds.base_back[k] = bond.base_back;
            if (has_visibility) bonds.visibility[k] = bond.visibility;
            if (wrap)
                for (int a = 0; a < 3; ++a) bonds.across[static_cast<std::size_t>(a)][k] = bond.across[a];
            ++k;
        }
        while (k < bonds.begin[i + 1]) bonds.neighbour[k++] = static_cast<Index>(i);
    });
    bonds.changed();
}

/// Replaces the indices of a list by the new ones, and leaves out those that are gone.
void renumber(const std::vector<Index>& now, std::vector<Index>& list) {
    std::vector<Index> remaining;
    for (const Index i : list)
        if (now[i] != kNone) remaining.push_back(now[i]);
    std::ranges::sort(remaining);
    list = std::move(remaining);
}

/// Renumbers the bonds that cross cracks.
void renumber_crossings(const std::vector<Index>& now, BondCrossings& crossings) {
    std::vector<Index> remaining;
    for (Index k = 0; k < crossings.size(); ++k) {
        Index &a = crossings.first[k], &b = crossings.second[k];
        a = now[a], b = now[b];
        if (a == kNone || b == kNone) continue;
        if (a > b) std::swap(a, b);
        remaining.push_back(k);
    }
    keep_table_rows(crossings, remaining);
}

/// Renumbers the nodes between two elements, and of samples. The order of nodes is that of their keys.
void renumber_nodes(const std::vector<Index>& now, ContactNodes& nodes) {
    std::vector<Index> remaining;
    for (Index k = 0; k < nodes.size(); ++k) {
        const bool elements = nodes.sample[k] == kNone;
        if (elements && (now[nodes.first[k]] == kNone || now[nodes.second[k]] == kNone)) continue;
        if (elements) nodes.first[k] = now[nodes.first[k]], nodes.second[k] = now[nodes.second[k]];
        remaining.push_back(k);
    }
    const auto key = [&](Index k) {
        return std::tuple(nodes.sample[k], nodes.partner[k], nodes.first[k], nodes.second[k]);
    };
    std::ranges::stable_sort(remaining, [&](Index a, Index b) { return key(a) < key(b); });
    ContactNodes sorted;
    resize_table(sorted, remaining.size());
    for_each_pair(sorted, nodes, [&](auto& to, const auto& from) {
        for (std::size_t k = 0; k < remaining.size(); ++k) to[k] = from[remaining[k]];
    });
    nodes = std::move(sorted);
}

}  // namespace

Index append_element(Elements& e, std::int64_t particle, std::int32_t owner) {
    const Index i = append_row(e);
    e.id[i] = particle;
    e.owner[i] = owner;
    Bonds& bonds = e.bonds;
    if (bonds.begin.empty()) bonds.begin.push_back(0);
    bonds.begin.push_back(bonds.begin.back());
    bonds.moment.push_back(RestMoment{.inverse = {}, .full = false});
    bonds.flat.emplace_back(i, Symmetric{});
    return i;
}

void bond_element(Index i, Solids& solids) {
    Elements& e = solids.elements;
    THIXO_ASSERT(!e.bonds.wrap(), "element {} would have no bonds across periodic faces", i);
    BondLists lists = unpack(e.bonds);
    std::vector<std::uint8_t> changed(e.size(), 0);
    changed[i] = 1;
    for (const Index j : solids.owner(i).elements) {
        const Real r = (xyz(e.rest[j]) - xyz(e.rest[i])).norm();
        if (j == i || !(r < (e.support[i] + e.support[j]) / 2)) continue;
        const Real own = rest_weight(e.support[i], e.support[j], r), back = rest_weight(e.support[j], e.support[i], r);
        lists[i].push_back({j, own, back, own, back, 1});
        lists[j].push_back({i, back, own, back, own, 1});
        changed[j] = 1;
    }
    pack(lists, e.bonds);
    measure_moments(e, &changed, flatness(e));
}

void bond_parts(const std::vector<Index>& origin, Solids& solids) {
    Elements& e = solids.elements;
    THIXO_ASSERT(!e.bonds.wrap(), "{} elements would have no bonds across periodic faces", e.size());
    const BondLists whole = unpack(e.bonds);
    std::vector<std::vector<Index>> parts(e.size());
    for (Index i = 0; i < e.size(); ++i) parts[origin[i]].push_back(i);
    BondLists lists(e.size());
    std::vector<std::uint8_t> changed(e.size(), 0);
    parallel_for(e.size(), [&](std::size_t i) {
        const auto bond_to = [&](Index j, Real visible) {
            const Real r = (xyz(e.rest[j]) - xyz(e.rest[i])).norm();
            if (j == i || !(r < (e.support[i] + e.support[j]) / 2)) return;
            const Real own = rest_weight(e.support[i], e.support[j], r),
                       back = rest_weight(e.support[j], e.support[i], r);
            lists[i].push_back({j, visible * own, visible * back, own, back, visible});
        };
        const bool parted = parts[origin[i]].size() > 1;
        changed[i] = parted;
        for (const Bond& bond : whole[origin[i]]) {
            if (!parted && parts[bond.neighbour].size() == 1) {
                lists[i].push_back(bond);
                continue;
            }
            changed[i] = 1;
            for (const Index j : parts[bond.neighbour]) bond_to(j, bond.visibility);
        }
        for (const Index j : parts[origin[i]]) bond_to(j, 1);
    });
    pack(lists, e.bonds);
    measure_moments(e, &changed, flatness(e));
}

void select_elements(const std::vector<Index>& rows, Solids& solids) {
    Elements& e = solids.elements;
    const std::size_t before = e.size();
    const std::vector<Index> now = new_places(rows, before);
    const BondLists old = unpack(e.bonds);
    BondLists lists(rows.size());
    std::vector<std::uint8_t> changed(rows.size(), 0);
    for (std::size_t k = 0; k < rows.size(); ++k)
        for (Bond bond : old[rows[k]]) {
            bond.neighbour = now[bond.neighbour];
            if (bond.neighbour == kNone)
                changed[k] = 1;
            else
                lists[k].push_back(bond);
        }
    select_table_rows(e, rows);
    if (e.softens) {
        for (std::size_t k = 0; k < rows.size(); ++k) e.law[k] = static_cast<Index>(k);
        select_rows(solids.softening.flow.plastic, rows);
    }
    std::vector<RestMoment> moment;
    for (const Index row : rows) moment.push_back(e.bonds.moment[row]);
    e.bonds.moment = std::move(moment);
    std::vector<std::pair<Index, Symmetric>> flat;
    for (const auto& [i, projection] : e.bonds.flat)
        if (now[i] != kNone) flat.emplace_back(now[i], projection);
    std::ranges::sort(flat, {}, &std::pair<Index, Symmetric>::first);
    e.bonds.flat = std::move(flat);
    pack(lists, e.bonds);
    measure_moments(e, &changed, flatness(e));

    for (SolidBody& body : solids.bodies) {
        renumber(now, body.elements);
        if (body.empty()) continue;
        for (Index* example : {&body.typical, &body.lightest})
            *example = now[*example] != kNone ? now[*example] : body.elements.front();
    }
    for (Handle& handle : solids.handles) {
        std::vector<std::pair<Index, std::size_t>> remaining;
        for (std::size_t k = 0; k < handle.elements.size(); ++k)
            if (now[handle.elements[k]] != kNone) remaining.emplace_back(now[handle.elements[k]], k);
        std::ranges::sort(remaining);
        Handle old_handle = handle;
        handle.elements.clear();
        handle.anchor.clear();
        handle.mass = 0;
        for (const auto& [i, k] : remaining) {
            handle.elements.push_back(i);
            handle.mass += static_cast<double>(e.mass[i]);
            if (!old_handle.anchor.empty()) handle.anchor.push_back(old_handle.anchor[k]);
        }
    }
    for (Index& i : solids.element_of)
        if (i != kNone) i = now[i];
    std::vector<Index> particle_of;
    for (const Index row : rows) particle_of.push_back(solids.particle_of[row]);
    solids.particle_of = std::move(particle_of);
    for (Index& i : solids.contacts.samples.weights.element)
        if (i != kNone) i = now[i];
    renumber_nodes(now, solids.contacts.nodes);
    renumber_crossings(now, solids.cracks.crossings);
    solids.altered = true;
}

void part_bonds(Elements& e) {
    BondLists lists = unpack(e.bonds);
    std::vector<std::uint8_t> changed(e.size(), 0);
    parallel_for(e.size(), [&](std::size_t i) {
        const std::size_t before = lists[i].size();
        std::erase_if(lists[i], [&](const Bond& bond) { return e.owner[bond.neighbour] != e.owner[i]; });
        changed[i] = lists[i].size() < before;
    });
    pack(lists, e.bonds);
    measure_moments(e, &changed, flatness(e));
}

void choose_examples(const Elements& e, const Smoothing& smoothing, SolidBody& body) {
    const Real lattice = cube(smoothing.spacing / smoothing.support);
    const auto off = [&](Index i) { return std::abs(std::log(e.volume[i] / (lattice * cube(e.support[i])))); };
    body.typical = body.lightest = body.elements.front();
    for (const Index i : body.elements) {
        if (e.mass[i] < e.mass[body.lightest]) body.lightest = i;
        const Index best = body.typical;
        if (e.support[i] < e.support[best] || (e.support[i] == e.support[best] && off(i) < off(best))) body.typical = i;
    }
}

void number_element(std::int64_t particle, Index element, Solids& solids) {
    const auto id = static_cast<std::size_t>(particle);
    if (solids.element_of.size() <= id) solids.element_of.resize(id + 1, kNone);
    solids.element_of[id] = element;
}

void locate_particles(const Particles& particles, Solids& solids) {
    if (solids.empty()) return;
    solids.particle_of.resize(solids.elements.size(), kNone);
    parallel_for(
        particles.size(),
        [&](std::size_t k) {
            if (const Index i = solids.element(particles.id[k]); i != kNone)
                solids.particle_of[i] = static_cast<Index>(k);
        },
        4096);
}

}  // namespace thixo
