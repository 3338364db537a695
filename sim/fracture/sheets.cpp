#include "sim/fracture/sheets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "pipeline/base/parallel.h"
#include "sim/fracture/crack_parts.h"

namespace thixo {
namespace {

struct Disc {
    Vec3 place, axis1, axis2, normal;
    std::int32_t sheet;
};

/// The discs of one triangle, of both sheets. Their centres lie no farther outside of the body than their radius.
void discs_of(const Cracks& cracks, Index triangle, const Breaking& breaking, std::vector<Disc>& out) {
    const CrackTriangles& t = cracks.triangles;
    const Vec3 &a = cracks.vertex[t.a[triangle]], &b = cracks.vertex[t.b[triangle]], &c = cracks.vertex[t.c[triangle]];
    const Vec3 normal = (b - a).cross(c - a).normalized();
    if (!normal.allFinite()) return;
    const Vec3 middle = (a + b + c) / 3;
    const Real reach = std::max({(a - middle).norm(), (b - middle).norm(), (c - middle).norm()});
    const int parts = std::max(1, static_cast<int>(std::ceil(reach / breaking.surfel)));
    const std::int32_t sheet = cracks.cracks[static_cast<std::size_t>(t.crack[triangle])].sheet;
    const Vec3 u = (b - a) / static_cast<Real>(parts), v = (c - a) / static_cast<Real>(parts);
    const Real radius = Real(1.05) * reach / static_cast<Real>(parts);
    const Vec3 axis1 = radius * u.normalized(), axis2 = normal.cross(axis1);
    const auto add = [&](const Vec3& place) {
        if (breaking.distance(place) > radius) return;
        out.push_back({place, axis1, axis2, normal, sheet});
        out.push_back({place, axis2, axis1, -normal, sheet + 1});
    };
    for (int i = 0; i < parts; ++i)
        for (int k = 0; i + k < parts; ++k) {
            const Vec3 corner = a + static_cast<Real>(i) * u + static_cast<Real>(k) * v;
            add(corner + (u + v) / 3);
            if (i + k + 1 < parts) add(corner + 2 * (u + v) / 3);
        }
}

void append_faces(const CrackSight& sight, const Breaking& breaking, const std::vector<Index>& triangles,
                  const Matter& matter) {
    Solids& solids = matter.solids;
    std::vector<Disc> discs;
    for (const Index k : triangles) discs_of(solids.cracks, k, breaking, discs);
    std::vector<std::int32_t> owner(discs.size());
    parallel_for(
        discs.size(),
        [&](std::size_t i) {
            owner[i] = solids.elements.owner[sight.nearest_seen(breaking.source, discs[i].place, discs[i].normal)];
        },
        64);
    std::map<std::int32_t, std::vector<std::size_t>> of_body;
    for (std::size_t i = 0; i < discs.size(); ++i) of_body[owner[i]].push_back(i);
    for (const auto& [body, rows] : of_body) {
        SurfelCloud cloud;
        std::vector<std::int32_t> sheet;
        for (const std::size_t i : rows) {
            const Disc& d = discs[i];
            cloud.position.push_back(d.place + breaking.origin);
            cloud.axis1.push_back(d.axis1);
            cloud.axis2.push_back(d.axis2);
            cloud.normal.push_back(d.normal);
            sheet.push_back(d.sheet);
        }
        const std::size_t first = append_family(cloud, sheet, static_cast<std::size_t>(body), matter);
        EmbeddedSurface& s = matter.embedded;
        for (std::size_t i = first; i < s.size(); ++i) s.beyond[i] = breaking.distance(s.rest.position[i]) > 0;
    }
}

/// The surfels that a front has passed since they were bound, and those without weights, ascending.
std::vector<Index> stale_surfels(const Breaking& breaking, const Matter& matter) {
    const Solids& solids = matter.solids;
    const Cracks& cracks = solids.cracks;
    const EmbeddedSurface& s = matter.embedded;
    std::vector<Vec3> middles;
    for (Index k = 0; k < cracks.triangles.size(); ++k) {
        const CrackTriangles& t = cracks.triangles;
        if (t.bound[k] == t.behind[k] || source_of(cracks, k) != breaking.source) continue;
        middles.push_back(middle_of(cracks, k));
    }
    PointGrid grid;
    const Real reach = Real(1.2) * breaking.support + 2 * breaking.row;
    grid.build(middles, reach);
    std::vector<std::uint8_t> stale(s.size(), 0);
    parallel_for(s.size(), [&](std::size_t i) {
        if (solids.bodies[static_cast<std::size_t>(s.owner[i])].source != breaking.source) return;
        stale[i] = s.begin[i] == s.begin[i + 1];
        if (!middles.empty()) grid.for_each_neighbour(s.rest.position[i], reach, [&](Index, Real) { stale[i] = 1; });
    });
    std::vector<Index> rows;
    for (Index i = 0; i < s.size(); ++i)
        if (stale[i]) rows.push_back(i);
    return rows;
}

}  // namespace

ElementSight element_sight(const CrackSight& sight) {
    if (sight.empty()) return {};
    return {[&sight](std::int32_t source, const Vec3& m, Real reach) {
                const CrackedMatter* matter = sight.matter_of(source);
                return matter && matter->sheets().nearest(m, reach, [](Index) { return true; }).has_value();
            },
            [&sight](const Vec3& m, const Vec3& normal, Index element) { return sight(m, normal, element); }};
}

void lay_sheets(const CrackSight& sight, const Matter& matter) {
    Cracks& cracks = matter.solids.cracks;
    if (matter.embedded.size() == 0) return;
    std::vector<Index> which;
    for (const Breaking& breaking : matter.solids.breaking) {
        if (!(breaking.surfel > 0) || !sight.matter_of(breaking.source)) continue;
        std::vector<Index> fresh;
        for (Index k = 0; k < cracks.triangles.size(); ++k)
            if (!cracks.triangles.drawn[k] && source_of(cracks, k) == breaking.source) fresh.push_back(k);
        append_faces(sight, breaking, fresh, matter);
        for (const Index k : fresh) cracks.triangles.drawn[k] = 1;
        const std::vector<Index> stale = stale_surfels(breaking, matter);
        which.insert(which.end(), stale.begin(), stale.end());
        for (Index k = 0; k < cracks.triangles.size(); ++k)
            if (source_of(cracks, k) == breaking.source) cracks.triangles.bound[k] = cracks.triangles.behind[k];
    }
    if (which.empty()) return;
    std::ranges::sort(which);
    bind_some_surfels(matter.solids, which, matter.embedded, element_sight(sight));
}

}  // namespace thixo
