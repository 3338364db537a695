#include "sim/fracture/frozen.h"

#include <algorithm>
#include <map>

#include "pipeline/geometry/shapes.h"
#include "sim/fracture/rigid_fragments.h"

namespace thixo {
namespace {

constexpr std::size_t kFewest = 16;  // surfels that bound a shape

const Breaking* breaking_of_source(const Solids& solids, std::int32_t source) {
    const auto at = std::ranges::find(solids.breaking, source, &Breaking::frame);
    return at == solids.breaking.end() ? nullptr : &*at;
}

/// Keeps these surfels, ascending rows, with their ids: what was one family may become several. All weights are lost.
void keep_surfels(const std::vector<Index>& rows, EmbeddedSurface& s) {
    std::vector<SurfelFamily> families;
    for (Index k = 0; k < rows.size(); ++k) {
        const SurfelFamily& old = s.family(rows[k]);
        if (k == 0 || rows[k] != rows[k - 1] + 1 || old.first == rows[k])
            families.push_back({.first = k, .base = s.id(rows[k]), .shift = old.shift});
    }
    keep_table_rows(s, rows);
    s.families = std::move(families);
    s.begin.assign(s.size() + 1, 0);
    s.weight.clear();
    s.screened.assign(s.size(), 0);
}

/// The animated surfels of a body, by rows, with the rows of their bound discs. Empty where one of them is not bound.
std::vector<std::pair<Index, Index>> bound_surfels(const SolidBody& body, const MixedSurface& surface) {
    std::vector<std::pair<Index, Index>> rows;
    const SurfaceState& animated = surface.animated;
    const RefrozenSurface& bound = surface.refrozen;
    for (Index i = 0; i < animated.size(); ++i) {
        if (animated.body[i] != body.id) continue;
        const auto at = std::ranges::lower_bound(bound.id, animated.id[i]);
        if (at == bound.id.end() || *at != animated.id[i]) return {};
        rows.emplace_back(i, static_cast<Index>(at - bound.id.begin()));
    }
    return rows;
}

void drop_rows(std::vector<Index> gone, auto& table) {
    std::ranges::sort(gone);
    std::vector<Index> rows;
    for (Index i = 0; i < table.size(); ++i)
        if (!std::ranges::binary_search(gone, i)) rows.push_back(i);
    keep_table_rows(table, rows);
}

/// Replaces the surfels that a body had before it melted by those that it has now. Those of bodies without matter go, too.
void embed(std::size_t b, const std::vector<std::pair<Index, Index>>& rows, const Matter& matter,
           MixedSurface& surface) {
    SolidBody& body = matter.solids.bodies[b];
    EmbeddedSurface& s = matter.embedded;
    std::vector<Index> others;
    for (Index i = 0; i < s.size(); ++i) {
        const auto owner = static_cast<std::size_t>(s.owner[i]);
        if (owner != b && !matter.solids.bodies[owner].empty()) others.push_back(i);
    }
    keep_surfels(others, s);
    SurfelCloud cloud;
    std::vector<Index> animated, bound;
    for (const auto& [i, k] : rows) {
        const Vec3 &a = surface.refrozen.axis1[k], &c = surface.refrozen.axis2[k];
        const Vec3 n = a.cross(c);
        cloud.position.push_back(surface.refrozen.place[k] + body.origin);
        cloud.axis1.push_back(a);
        cloud.axis2.push_back(c);
        cloud.normal.push_back(n.squaredNorm() > 0 ? Vec3(n.normalized()) : surface.animated.surfels.normal[i]);
        animated.push_back(i);
        bound.push_back(k);
    }
    const std::size_t first = append_family(cloud, std::vector<std::int32_t>(rows.size(), 0), b, matter);
    for (std::size_t k = 0; k < rows.size(); ++k) {
        s.first[first + k] = surface.animated.rest[rows[k].first];
        s.temperature[first + k] = surface.animated.temperature[rows[k].first];
    }
    drop_rows(std::move(animated), surface.animated);
    drop_rows(std::move(bound), surface.refrozen);
    body.skin = Skin::embedded;
    body.refrozen = body.scene_shape = false;
    body.cuts.clear();
}

/// The outer surface of a frozen rest shape.
struct Frozen {
    std::int32_t source = 0;
    Vec3 origin{0, 0, 0};  // of the frame in the world at time 0 [m]
    TriangleMesh points{};
    double radii = 0;  // sum of its surfels' radii [m]

    void add(const EmbeddedSurface& s, std::size_t i, const Vec3& at) {
        origin = at;
        points.vertices.push_back((s.rest.position[i] + at).cast<float>());
        points.normals.push_back(s.rest.normal[i].cast<float>());
        radii += static_cast<double>(s.rest.axis1[i].norm() + s.rest.axis2[i].norm()) / 2;
    }
};

}  // namespace

void make_frozen_breaking(const Matter& matter) {
    Solids& solids = matter.solids;
    const EmbeddedSurface& s = matter.embedded;
    std::erase_if(solids.breaking, [](const Breaking& b) { return b.frame != b.source; });
    std::map<std::int32_t, Frozen> frames;
    for (const Crack& crack : solids.cracks.cracks) frames[crack.frame].source = crack.source;
    for (std::size_t i = 0; i < s.size(); ++i) {
        const SolidBody& body = solids.bodies[static_cast<std::size_t>(s.owner[i])];
        if (s.frame[i] == body.source || !breaking_of_source(solids, body.source)) continue;
        frames[s.frame[i]].source = body.source;
        if (s.sheet[i] < kFirstCrackSheet && !s.beyond[i]) frames[s.frame[i]].add(s, i, body.origin);
    }
    for (const auto& [frame, frozen] : frames) {
        if (frame == frozen.source) continue;
        Breaking breaking = *breaking_of_source(solids, frozen.source);
        breaking.frame = frame;
        breaking.origin = frozen.origin;
        // Without its surfels a frame has no matter left.
        if (frozen.points.vertices.size() >= kFewest) {
            breaking.surfel = static_cast<Real>(frozen.radii / static_cast<double>(frozen.points.vertices.size()));
            breaking.shape = point_shape(frozen.points);
        }
        solids.breaking.push_back(std::move(breaking));
    }
}

bool embed_frozen(const Matter& matter, MixedSurface& surface) {
    Solids& solids = matter.solids;
    std::vector<std::uint8_t> embedded(solids.bodies.size(), 0);
    for (std::size_t b = 0; b < solids.bodies.size(); ++b) {
        const SolidBody& body = solids.bodies[b];
        if (body.skin != Skin::rebound || !breaking_of_source(solids, body.source)) continue;
        const auto rows = bound_surfels(body, surface);
        if (rows.size() < kFewest) continue;
        embed(b, rows, matter, surface);
        embedded[b] = 1;
    }
    if (std::ranges::none_of(embedded, [](std::uint8_t e) { return e != 0; })) return false;
    solids.altered = true;
    make_rigid(embedded, matter);
    make_frozen_breaking(matter);
    bind_matter(std::vector<std::uint8_t>(solids.bodies.size(), 1), matter);
    return true;
}

void follow_returned(const Solids& solids, MixedSurface& surface) {
    std::map<std::int32_t, std::int32_t> now;  // id of the body that has the matter, by that of the fragment
    for (const SolidBody& body : solids.bodies) {
        if (!body.empty() || body.parent < 0) continue;
        const auto root = std::ranges::find_if(
            solids.bodies, [&](const SolidBody& b) { return b.parent < 0 && b.source == body.source; });
        now[body.id] = root->id;
    }
    if (now.empty()) return;
    for (auto* bodies : {&surface.animated.body, &surface.zombies.body})
        for (std::int32_t& id : *bodies)
            if (const auto at = now.find(id); at != now.end()) id = at->second;
}

}  // namespace thixo
