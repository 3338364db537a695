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
            owner[i] = solids.elements.owner[sight.nearest_seen(breaking.frame, discs[i].place, discs[i].normal)];
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

}  // namespace

ElementSight element_sight(const CrackSight& sight) {
    if (sight.empty()) return {};
    return [&sight](const Vec3& m, const Vec3& normal, std::span<const Index> elements, std::vector<Real>& share) {
        return sight.shares(m, normal, elements, share);
    };
}

namespace {

/// The triangles that a front has passed since the surfels about them were bound, their middles, and how far from these
/// they reach. A triangle that is opaque stays so.
struct PassedTriangles {
    std::vector<Index> triangle;
    std::vector<Vec3> middle;
    Real widest = 0;  // [m]
};
PassedTriangles passed_triangles(const Breaking& breaking, const Cracks& cracks) {
    const CrackTriangles& t = cracks.triangles;
    PassedTriangles passed;
    for (Index k = 0; k < t.size(); ++k) {
        if (frame_of(cracks, k) != breaking.frame ||
            std::min(t.bound[k], breaking.opaque) == std::min(t.behind[k], breaking.opaque))
            continue;
        passed.triangle.push_back(k);
        const Vec3 middle = passed.middle.emplace_back(middle_of(cracks, k));
        for (const Index v : {t.a[k], t.b[k], t.c[k]})
            passed.widest = std::max(passed.widest, (cracks.vertex[v] - middle).norm());
    }
    return passed;
}

/// Marks surfels that a front has passed since they were bound. The ways from a surfel to its elements decide: a run that
/// continues binds all anew, and has to find the same weights. Elements that cracks hide from a surfel stay hidden.
void mark_passed(const CrackSight& sight, const Breaking& breaking, const Matter& matter,
                 std::vector<std::uint8_t>& marks) {
    constexpr Real kRoom = Real(0.1);  // supports: ways begin a little below the surfel
    const Solids& solids = matter.solids;
    const EmbeddedSurface& s = matter.embedded;
    const PassedTriangles passed = passed_triangles(breaking, solids.cracks);
    if (passed.middle.empty()) return;
    const auto of_frame = [&](std::size_t i) {
        return solids.bodies[static_cast<std::size_t>(s.owner[i])].frame == breaking.frame;
    };
    const auto reach = [&](std::size_t i) {
        const Real disc = std::max(s.rest.axis1[i].norm(), s.rest.axis2[i].norm());
        return s.support[i] + disc + kRoom * breaking.support + passed.widest;
    };
    Real farthest = breaking.support;
    for (std::size_t i = 0; i < s.size(); ++i)
        if (of_frame(i)) farthest = std::max(farthest, reach(i));
    PointGrid grid;
    grid.build(passed.middle, farthest);
    const CrackTree triangles(solids.cracks, passed.triangle);
    parallel_for(s.size(), [&](std::size_t i) {
        if (!of_frame(i)) return;
        bool near = false;
        grid.for_each_neighbour(s.rest.position[i], reach(i), [&](Index, Real) { near = true; });
        if (near && sight.crosses(triangles, s, static_cast<Index>(i))) marks[i] = 1;
    });
}

/// Lays faces on all triangles that have none.
void lay_faces(const CrackSight& sight, const Matter& matter) {
    Cracks& cracks = matter.solids.cracks;
    for (const Breaking& breaking : matter.solids.breaking) {
        // Where all matter has left a frame by melting, its last rows are not drawn.
        const CrackedMatter* own = sight.matter_of(breaking.frame);
        if (!(breaking.surfel > 0) || !own || own->elements().empty()) continue;
        std::vector<Index> fresh;
        for (Index k = 0; k < cracks.triangles.size(); ++k)
            if (!cracks.triangles.drawn[k] && frame_of(cracks, k) == breaking.frame) fresh.push_back(k);
        append_faces(sight, breaking, fresh, matter);
        for (const Index k : fresh) cracks.triangles.drawn[k] = 1;
    }
}

/// Binds marked surfels, and those without weights.
void bind_marked(const CrackSight& sight, const std::vector<std::uint8_t>& marks, const Matter& matter) {
    const EmbeddedSurface& s = matter.embedded;
    std::vector<Index> which;
    for (Index i = 0; i < s.size(); ++i) {
        const SolidBody& body = matter.solids.bodies[static_cast<std::size_t>(s.owner[i])];
        if (body.empty() || body.skin != Skin::embedded) continue;
        if (marks[i] || (s.begin[i] == s.begin[i + 1] && sight.matter_of(body.frame))) which.push_back(i);
    }
    if (!which.empty()) bind_some_surfels(matter.solids, which, matter.embedded, element_sight(sight));
}

}  // namespace

double area_of_sheets(const Solids& solids) {
    const Cracks& cracks = solids.cracks;
    const CrackTriangles& t = cracks.triangles;
    return parallel_sum(t.size(), [&](std::size_t k) {
        const auto triangle = static_cast<Index>(k);
        const Breaking& breaking = *std::ranges::find(solids.breaking, frame_of(cracks, triangle), &Breaking::frame);
        const Vec3 &a = cracks.vertex[t.a[k]], &b = cracks.vertex[t.b[k]], &c = cracks.vertex[t.c[k]];
        const bool inside = breaking.distance(middle_of(cracks, triangle)) < 0;
        return inside ? 0.5 * static_cast<double>((b - a).cross(c - a).norm()) : 0.0;
    });
}

void lay_sheets(const CrackSight& sight, const Matter& matter) {
    if (matter.embedded.size() == 0) return;
    lay_faces(sight, matter);
    bind_marked(sight, std::vector<std::uint8_t>(matter.embedded.size(), 0), matter);
}

void refresh_sheets(const CrackSight& sight, const Matter& matter) {
    if (matter.embedded.size() == 0) return;
    lay_faces(sight, matter);
    std::vector<std::uint8_t> marks(matter.embedded.size(), 0);
    for (const Breaking& breaking : matter.solids.breaking)
        if (breaking.surfel > 0 && sight.matter_of(breaking.frame)) mark_passed(sight, breaking, matter, marks);
    CrackTriangles& t = matter.solids.cracks.triangles;
    t.bound = t.behind;
    bind_marked(sight, marks, matter);
}

}  // namespace thixo
