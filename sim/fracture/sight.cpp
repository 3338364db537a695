#include "sim/fracture/sight.h"

#include <algorithm>
#include <limits>

#include "pipeline/base/parallel.h"
#include "sim/fracture/crack_parts.h"

namespace thixo {
namespace {

const Breaking& breaking_of(const std::vector<Breaking>& breaking, const Cracks& cracks, Index triangle) {
    return *std::ranges::find(breaking, frame_of(cracks, triangle), &Breaking::frame);
}

Real distance_to_segment(const Vec3& x, const Vec3& a, const Vec3& b) {
    const Vec3 way = b - a;
    const Real length2 = way.squaredNorm();
    const Real t = length2 > 0 ? std::clamp((x - a).dot(way) / length2, Real(0), Real(1)) : Real(0);
    return (a + t * way - x).norm();
}

/// The edges of a front that have a node inside.
struct Edge {
    Vec3 a, b;
};
std::vector<std::vector<Edge>> live_edges(const Cracks& cracks) {
    std::vector<std::vector<Edge>> edges(cracks.cracks.size());
    for (const CrackFront& front : cracks.fronts) {
        const std::size_t n = front.nodes.size();
        for (std::size_t i = 0; i + (front.closed ? 0 : 1) < n; ++i) {
            const CrackNode &a = front.nodes[i], &b = front.nodes[(i + 1) % n];
            if (a.state == NodeState::inside || b.state == NodeState::inside)
                edges[static_cast<std::size_t>(front.crack)].push_back({a.tip(), b.tip()});
        }
    }
    return edges;
}

}  // namespace

Real transparency(Real q, Real behind, Real opaque) {
    if (!(behind < opaque)) return 0;
    const Real hidden = q + square(behind / opaque);
    if (hidden >= 1) return behind > 0 ? 0 : 1;
    return cube((1 - hidden) / (1 - q));
}

void follow_fronts(const std::vector<Breaking>& breaking, Cracks& cracks) {
    const std::vector<std::vector<Edge>> edges = live_edges(cracks);
    CrackTriangles& t = cracks.triangles;
    parallel_for(t.size(), [&](std::size_t k) {
        const Real opaque = breaking_of(breaking, cracks, static_cast<Index>(k)).opaque;
        // Far behind: farther makes no difference, and a front that is left elsewhere brings nothing back.
        if (t.behind[k] >= 3 * opaque) return;
        const auto& front = edges[static_cast<std::size_t>(t.crack[k])];
        const Vec3 middle = middle_of(cracks, static_cast<Index>(k));
        Real nearest = kParted;
        for (const Edge& e : front) nearest = std::min(nearest, distance_to_segment(middle, e.a, e.b));
        t.behind[k] = std::max(t.behind[k], nearest);
    });
}

void find_crossings(const CrackedMatter& matter, const Elements& e, Index first, Cracks& cracks) {
    std::vector<Index> rows;
    for (Index k = first; k < cracks.triangles.size(); ++k)
        if (frame_of(cracks, k) == matter.breaking().frame) rows.push_back(k);
    if (rows.empty()) return;
    const CrackTree fresh(cracks, rows);
    const Vec3 reach = Vec3::Constant(matter.breaking().support);
    const Vec3 lower = fresh.lower() - reach, upper = fresh.upper() + reach;
    const auto& elements = matter.elements();
    constexpr std::size_t kElements = 64;
    std::vector<BondCrossings> found((elements.size() + kElements - 1) / kElements);
    parallel_chunks(
        elements.size(),
        [&](std::size_t begin, std::size_t end, std::size_t c) {
            for (std::size_t n = begin; n < end; ++n) {
                const Index i = elements[n];
                const Vec3 m = xyz(e.rest[i]);
                if ((m.array() < lower.array()).any() || (m.array() > upper.array()).any()) continue;
                for (std::size_t k = e.bonds.begin[i]; k < e.bonds.begin[i + 1]; ++k) {
                    const Index j = e.bonds.neighbour[k];
                    if (j <= i) continue;
                    fresh.for_each_crossing(m, xyz(e.rest[j]), [&](Index triangle, const Vec3&) {
                        found[c].first.push_back(i);
                        found[c].second.push_back(j);
                        found[c].triangle.push_back(triangle);
                    });
                }
            }
        },
        kElements);
    for (const BondCrossings& part : found)
        for_each_pair(cracks.crossings, part,
                      [](auto& array, const auto& from) { array.insert(array.end(), from.begin(), from.end()); });
}

namespace {

/// Whether a bond is longer than the strain at its ends explains, by more than this part of its length.
bool gapes(const Solids& solids, Index i, Index j, Real part) {
    const Elements& e = solids.elements;
    const Vec3 r = xyz(e.rest[j]) - xyz(e.rest[i]), u = xyz(e.displacement[j]) - xyz(e.displacement[i]);
    const Vec3 strained = (solids.gradients[i] + solids.gradients[j]) * r / 2;
    return (u - strained).norm() > part * r.norm();
}

/// Whether a way comes nearer to a sheet than a row.
bool passes_a_sheet(const CrackedMatter& matter, const Vec3& from, const Vec3& to) {
    const Real row = matter.breaking().row;
    const int parts = std::max(1, static_cast<int>(std::ceil(2 * (to - from).norm() / row)));
    for (int k = 0; k <= parts; ++k)
        if (matter.sheets().nearest(from + static_cast<Real>(k) / static_cast<Real>(parts) * (to - from), row,
                                    [](Index) { return true; }))
            return true;
    return false;
}

}  // namespace

std::vector<WeakBond> pinhole_bonds(const CrackedMatter& matter, const Solids& solids) {
    const Elements& e = solids.elements;
    const Bonds& bonds = e.bonds;
    if (bonds.visibility.empty()) return {};
    const auto part_of = [&](Index i) {
        const Real modulus = solids.laws[static_cast<std::size_t>(e.owner[i])].wave_modulus();
        return std::min(2 * e.strength[i] / modulus, Real(0.5));
    };
    const std::vector<Index>& elements = matter.elements();
    constexpr std::size_t kElements = 256;
    std::vector<std::vector<WeakBond>> found((elements.size() + kElements - 1) / kElements);
    parallel_chunks(
        elements.size(),
        [&](std::size_t begin, std::size_t end, std::size_t c) {
            for (std::size_t n = begin; n < end; ++n) {
                const Index i = elements[n];
                const auto weakened = [&](std::size_t k) { return bonds.visibility[k] < 1; };
                bool beside = false;
                for (std::size_t k = bonds.begin[i]; k < bonds.begin[i + 1]; ++k) beside = beside || weakened(k);
                for (std::size_t k = bonds.begin[i]; beside && k < bonds.begin[i + 1]; ++k)
                    if (const Index j = bonds.neighbour[k]; j != i && bonds.weight[k] > 0 && !weakened(k) &&
                                                            gapes(solids, i, j, part_of(i)) &&
                                                            passes_a_sheet(matter, xyz(e.rest[i]), xyz(e.rest[j])))
                        found[c].push_back({i, j, 0});
            }
        },
        kElements);
    std::vector<WeakBond> all;
    for (const auto& part : found) all.insert(all.end(), part.begin(), part.end());
    return all;
}

std::vector<WeakBond> loose_bonds(const Elements& e) {
    constexpr Real kHeld = Real(0.15);
    const Bonds& bonds = e.bonds;
    if (bonds.visibility.empty()) return {};
    std::vector<std::uint8_t> loose(e.size(), 0);
    parallel_for(e.size(), [&](std::size_t i) {
        Real whole = 0, left = 0;
        for (std::size_t k = bonds.begin[i]; k < bonds.begin[i + 1]; ++k) {
            whole += bonds.base[k];
            left += bonds.base[k] * bonds.visibility[k];
        }
        loose[i] = left > 0 && left < kHeld * whole;
    });
    std::vector<WeakBond> all;
    for (Index i = 0; i < e.size(); ++i)
        for (std::size_t k = bonds.begin[i]; loose[i] && k < bonds.begin[i + 1]; ++k)
            if (bonds.neighbour[k] != i) all.push_back({i, bonds.neighbour[k], 0});
    return all;
}

std::vector<Vec3> gaping_places(const Solids& solids, std::int32_t frame) {
    const Elements& e = solids.elements;
    const BondCrossings& crossings = solids.cracks.crossings;
    std::vector<Vec3> places;
    for (std::size_t k = 0; k < crossings.size(); ++k) {
        const Index i = crossings.first[k], j = crossings.second[k];
        if (e.owner[i] != e.owner[j] || solids.owner(i).frame != frame) continue;
        if (gapes(solids, i, j, Real(0.5))) places.push_back((xyz(e.rest[i]) + xyz(e.rest[j])) / 2);
    }
    return places;
}

std::vector<WeakBond> weak_bonds(const std::vector<Breaking>& breaking, const Elements& e,
                                 const std::vector<Tension>& tension, Cracks& cracks) {
    constexpr Real kOverload = 3;
    const auto overloaded = [&](Index i) { return !tension.empty() && tension[i].value > kOverload * e.strength[i]; };
    BondCrossings& crossings = cracks.crossings;
    std::vector<WeakBond> weak(crossings.size());
    parallel_for(weak.size(), [&](std::size_t k) {
        const Index i = crossings.first[k], j = crossings.second[k], triangle = crossings.triangle[k];
        const Real r = (xyz(e.rest[j]) - xyz(e.rest[i])).norm(), h = (e.support[i] + e.support[j]) / 2;
        if (overloaded(i) || overloaded(j))
            weak[k] = {i, j, 0};
        else
            weak[k] = {
                i, j,
                transparency(r / h, cracks.triangles.behind[triangle], breaking_of(breaking, cracks, triangle).opaque)};
    });
    std::vector<Index> remaining;
    for (Index k = 0; k < weak.size(); ++k)
        if (weak[k].visibility > 0) remaining.push_back(k);
    keep_table_rows(crossings, remaining);
    return weak;
}

Real share_left(const CrackTree& sheets, const Cracks& cracks, const Vec3& from, const Vec3& to, Real support,
                Real opaque) {
    const Real q = std::min((to - from).norm() / support, Real(0.999));
    Real left = 1;
    (void)sheets.any_crossing(from, to, [&](Index k, const Vec3&) {
        left = std::min(left, transparency(q, cracks.triangles.behind[k], opaque));
        return left <= 0;
    });
    return left;
}

CrackSight::CrackSight(const Solids& solids) : solids_(&solids) {
    for (const Breaking& breaking : solids.breaking)
        if (std::ranges::any_of(solids.cracks.cracks, [&](const Crack& c) { return c.frame == breaking.frame; }))
            matter_.emplace_back(solids, breaking);
}

const CrackedMatter* CrackSight::matter_of(std::int32_t frame) const {
    const auto at = std::ranges::find_if(matter_, [&](const CrackedMatter& m) { return m.breaking().frame == frame; });
    return at == matter_.end() ? nullptr : &*at;
}

namespace {

/// A surfel looks from just below the surface.
Vec3 looking_place(const Breaking& breaking, const Vec3& m, const Vec3& normal) {
    constexpr Real kBelow = Real(0.02);  // supports
    return m - kBelow * breaking.support * normal;
}

}  // namespace

Real CrackSight::share(const CrackedMatter& matter, const CrackTree& sheets, const Vec3& from, Index element) const {
    const Breaking& b = matter.breaking();
    return share_left(sheets, solids_->cracks, from, xyz(solids_->elements.rest[element]), b.support, b.opaque);
}

bool CrackSight::shares(const Vec3& m, const Vec3& normal, std::span<const Index> elements,
                        std::vector<Real>& share) const {
    const CrackedMatter* matter = elements.empty() ? nullptr : matter_of(solids_->owner(elements.front()).frame);
    if (!matter) return false;
    const Vec3 from = looking_place(matter->breaking(), m, normal);
    const auto place = [&](std::size_t k) { return xyz(solids_->elements.rest[elements[k]]); };
    thread_local WayFan fan;
    fan.start(from);
    for (std::size_t k = 0; k < elements.size(); ++k) fan.add(place(k));
    fan.finish();
    share.assign(elements.size(), 1);
    const Breaking& b = matter->breaking();
    return matter->sheets().for_each_crossing(
        fan, place, [&](std::size_t k) { return share[k] > 0; },
        [&](std::size_t k, Index triangle) {
            const Real q = std::min((place(k) - from).norm() / b.support, Real(0.999));
            share[k] = std::min(share[k], transparency(q, solids_->cracks.triangles.behind[triangle], b.opaque));
        });
}

bool CrackSight::crosses(const CrackTree& triangles, const EmbeddedSurface& embedded, Index i) const {
    const CrackedMatter* matter = matter_of(solids_->bodies[static_cast<std::size_t>(embedded.owner[i])].frame);
    if (!matter) return false;
    const SurfelCloud& rest = embedded.rest;
    const SurfelWeight* weight = embedded.weight.data() + embedded.begin[i];
    const auto place = [&](std::size_t k) { return xyz(solids_->elements.rest[weight[k].element]); };
    thread_local WayFan fan;
    fan.start(looking_place(matter->breaking(), rest.position[i], rest.normal[i]));
    for (std::size_t k = 0; k < embedded.begin[i + 1] - embedded.begin[i]; ++k) fan.add(place(k));
    fan.finish();
    bool any = false;
    triangles.for_each_crossing(
        fan, place, [&](std::size_t) { return !any; }, [&](std::size_t, Index) { any = true; });
    return any;
}

namespace {

/// The nearest element of a frame without cracks.
Index nearest_of(const Solids& solids, std::int32_t frame, const Vec3& m) {
    Index nearest = kNone;
    Real least = std::numeric_limits<Real>::max();
    for (Index i = 0; i < solids.elements.size(); ++i) {
        const Real r2 = (xyz(solids.elements.rest[i]) - m).squaredNorm();
        if (solids.owner(i).frame != frame || r2 >= least) continue;
        nearest = i;
        least = r2;
    }
    return nearest;
}

}  // namespace

Index CrackSight::nearest_seen(std::int32_t frame, const Vec3& m, const Vec3& normal) const {
    const CrackedMatter* matter = matter_of(frame);
    if (!matter) return nearest_of(*solids_, frame, m);
    constexpr int kTried = 32;
    std::vector<std::pair<Real, Index>> near;
    matter->grid().nearest(m, kTried, std::numeric_limits<Real>::max(), near);
    const Vec3 from = looking_place(matter->breaking(), m, normal);
    for (const auto& [r2, k] : near)
        if (share(*matter, matter->sheets(), from, matter->elements()[k]) > 0) return matter->elements()[k];
    return matter->elements()[near.front().second];
}

}  // namespace thixo
