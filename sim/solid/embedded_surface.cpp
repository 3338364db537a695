#include "sim/solid/embedded_surface.h"

#include <algorithm>
#include <array>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/kernels.h"
#include "pipeline/geometry/surface_sampling.h"
#include "sim/scene_shapes.h"

namespace thixo {
namespace {

constexpr int kEnough = 4;  // elements whose weights a surfel needs at least

std::vector<Vec3> places(const SolidBody& body, const Elements& e) {
    std::vector<Vec3> place;
    for (Index i = body.begin; i < body.end; ++i) place.push_back(xyz(e.rest[i]));
    return place;
}

/// The disc's part on a body with edges: how far one can go in the disc before the surface is left behind.
EdgeCut edge_cut(const Shape& shape, const SurfelCloud& cloud, std::size_t k) {
    constexpr int kWays = 16;
    const Real radius = cloud.axis1[k].norm();
    std::array<Real, kWays> reach{};
    for (int w = 0; w < kWays; ++w) {
        const Real angle = static_cast<Real>(2 * kPi * w / kWays);
        const Vec3 way = std::cos(angle) * cloud.axis1[k] + std::sin(angle) * cloud.axis2[k];
        Real r = 1;
        while (r > Real(0.15) && std::abs(shape.distance(cloud.position[k] + r * way)) > Real(0.1) * radius)
            r -= Real(0.05);
        reach[static_cast<std::size_t>(w)] = r;
    }
    const auto least = static_cast<std::size_t>(std::ranges::min_element(reach) - reach.begin());
    const Real across = std::min(reach[(least + kWays / 4) % kWays], reach[(least + 3 * kWays / 4) % kWays]);
    return {static_cast<Real>(2 * kPi * static_cast<double>(least) / kWays), reach[least], across};
}

struct Disc {
    Vec3 place, axis1, axis2;
};
/// A surfel in the world.
struct Drawn {
    Disc now;
    Vec3 normal, velocity, rest;
    std::int64_t id;
    Index root;
};

/// The displacement about one surfel made at the start.
struct Field {
    const EmbeddedSurface& embedded;
    const Solids& solids;
    std::size_t root;
    std::size_t owner() const { return static_cast<std::size_t>(embedded.owner[root]); }
    const SolidBody& body() const { return solids.bodies[owner()]; }
    Carried at(const Vec3& m) const {
        return carried(embedded.grid[owner()], body(), solids, m, embedded.support[root]);
    }
};

Drawn displaced(const Field& field, const Disc& rest, std::int64_t id) {
    const SolidBody& body = field.body();
    const Mat3 turn = body.turn.cast<Real>();
    const Carried at = field.at(rest.place);
    Drawn d;
    d.now.place = (body.turn * (rest.place + at.shift).cast<double>() + body.place).cast<Real>();
    d.now.axis1 = turn * (rest.axis1 + field.at(rest.place + rest.axis1).shift - at.shift);
    d.now.axis2 = turn * (rest.axis2 + field.at(rest.place + rest.axis2).shift - at.shift);
    const Vec3 n = d.now.axis1.cross(d.now.axis2);
    const Real size = n.norm();
    d.normal = size > 0 ? Vec3(n / size) : Vec3(turn * field.embedded.rest.normal[field.root]);
    d.velocity = turn * at.velocity;
    d.rest = field.embedded.first[field.root] + rest.place - field.embedded.rest.position[field.root];
    d.id = id;
    d.root = static_cast<Index>(field.root);
    return d;
}

/// The surfel, or what it splits into.
void draw(const Field& field, const Disc& rest, std::int64_t id, int level, std::vector<Drawn>& out) {
    constexpr int kDeepest = 8;
    const Drawn d = displaced(field, rest, id);
    const Vec3 &a = d.now.axis1, &b = d.now.axis2;
    const Real radius2 = field.embedded.rest.axis1[field.root].squaredNorm();
    const Real aa = a.squaredNorm() / radius2, bb = b.squaredNorm() / radius2, ab = a.dot(b) / radius2;
    const Real mean = (aa + bb) / 2, half = std::sqrt(square((aa - bb) / 2) + square(ab));
    const Real longest = mean + half, shortest = mean - half;
    if (level == kDeepest || !(longest > kSplitStretch || (longest > Real(1.2) && longest > kSplitRatio * shortest)))
        return out.push_back(d);
    // The eigenvector of the longest: along it the disc at rest is cut in two, that overlap a little.
    const Real angle = std::atan2(2 * ab, aa - bb) / 2, c = std::cos(angle), s = std::sin(angle);
    const Vec3 along = c * rest.axis1 + s * rest.axis2, across = c * rest.axis2 - s * rest.axis1;
    const std::int64_t first = 2 * id + static_cast<std::int64_t>(field.embedded.size());
    draw(field, {rest.place - along / 2, Real(0.6) * along, across}, first, level + 1, out);
    draw(field, {rest.place + along / 2, Real(0.6) * along, across}, first + 1, level + 1, out);
}

}  // namespace

Real weights_support(const PointGrid& grid, const Vec3& m, Real disc, Real usual) {
    std::vector<std::pair<Real, Index>> near;
    grid.nearest(m, kEnough, std::numeric_limits<Real>::max(), near);
    return std::max(usual, Real(1.2) * (std::sqrt(near.back().first) + disc));
}

Carried carried(const PointGrid& grid, const SolidBody& body, const Solids& s, const Vec3& m, Real support) {
    const Poly6 w(support);
    Real weight = 0;
    Carried sum{Vec3::Zero(), Vec3::Zero()};
    const Elements& e = s.elements;
    grid.for_each_neighbour(m, support, [&](Index near, Real r2) {
        const Index j = body.begin + near;
        const Real a = w.value(r2);
        weight += a;
        sum.shift += a * (xyz(e.displacement[j]) + s.gradients[j] * (m - xyz(e.rest[j])));
        sum.velocity += a * xyz(e.velocity[j]);
    });
    return {sum.shift / weight, sum.velocity / weight};
}

std::optional<Vec3> displacement_at(const EmbeddedSurface& embedded, const Solids& solids, std::size_t owner,
                                    const Vec3& m, Real support) {
    const Vec3 u = carried(embedded.grid[owner], solids.bodies[owner], solids, m, support).shift;
    return u.allFinite() ? std::optional(u) : std::nullopt;
}

EmbeddedSurface make_embedded_surface(const scene::Scene& scene, const Solids& solids) {
    EmbeddedSurface out;
    for (std::size_t b = 0; b < solids.bodies.size(); ++b) {
        const SolidBody& body = solids.bodies[b];
        out.trim.emplace_back();
        out.grid.emplace_back();
        // What has no rest shape has no such surface.
        if (body.body < 0 || (solids.phases.any && solids.phases.bond[body.begin] != Bond::rest)) continue;
        const scene::Body& source = scene.bodies[static_cast<std::size_t>(body.body)];
        const Shape shape = make_shape(scene, source.shape);
        SurfaceSampling sampling{.count = static_cast<std::size_t>(source.surfels), .seed = scene.solver.seed};
        if (source.surfels == 0) sampling.spacing = scene.surface.radius * scene.solver.spacing;
        const SampledSurface sampled = sample_surface(shape, sampling);
        const std::vector<Vec3> place = places(body, solids.elements);
        const Real usual = solids.elements.support[body.begin];
        // The grid's cells must hold the widest support.
        PointGrid near;
        near.build(place, usual);
        const Vec3 centre = body.place.cast<Real>();
        Real widest = usual;
        const SurfelCloud& cloud = sampled.surfels;
        for (std::size_t k = 0; k < cloud.size(); ++k) {
            const Vec3 m = cloud.position[k] - centre;
            const Real disc = std::max(cloud.axis1[k].norm(), cloud.axis2[k].norm());
            out.rest.position.push_back(m);
            out.rest.axis1.push_back(cloud.axis1[k]);
            out.rest.axis2.push_back(cloud.axis2[k]);
            out.rest.normal.push_back(cloud.normal[k]);
            out.owner.push_back(static_cast<std::int32_t>(b));
            out.sheet.push_back(sampled.sheet[k]);
            out.first.push_back(cloud.position[k]);
            const Real off = std::abs(shape.distance(cloud.position[k]));
            out.beyond.push_back(sampled.trim && off > Real(0.02 * sampled.spacing));
            out.edge.push_back(sampled.trim ? edge_cut(shape, cloud, k) : EdgeCut{});
            out.support.push_back(weights_support(near, m, disc, usual));
            out.temperature.push_back(static_cast<Real>(source.temperature));
            widest = std::max(widest, out.support.back());
        }
        if (sampled.trim) out.trim.back() = trim_node(*sampled.trim);
        out.grid.back().build(place, widest);
    }
    return out;
}

void displace_embedded(const EmbeddedSurface& embedded, Solids& solids, SurfaceState& surface,
                       std::vector<Index>& source) {
    displace_embedded(embedded, solids, std::vector<std::uint8_t>(solids.bodies.size(), 0), surface, source);
}

void displace_embedded(const EmbeddedSurface& embedded, Solids& solids, const std::vector<std::uint8_t>& taken,
                       SurfaceState& surface, std::vector<Index>& source) {
    const std::size_t n = embedded.size();
    find_gradients(solids.elements, solids.gradients);
    std::vector<std::vector<Drawn>> drawn((n + kChunk - 1) / kChunk);
    parallel_chunks(n, [&](std::size_t begin, std::size_t end, std::size_t c) {
        for (std::size_t i = begin; i < end; ++i)
            if (!taken[static_cast<std::size_t>(embedded.owner[i])])
                draw(Field{embedded, solids, i},
                     {embedded.rest.position[i], embedded.rest.axis1[i], embedded.rest.axis2[i]},
                     static_cast<std::int64_t>(i), 0, drawn[c]);
    });
    std::size_t count = 0;
    std::vector<std::size_t> first;
    for (const auto& part : drawn) {
        first.push_back(count);
        count += part.size();
    }
    source.resize(count);
    for_each_array(surface, [&]<class T>(const char*, std::vector<T>& array) {
        if constexpr (std::is_same_v<T, Vec3>)
            array.resize(count, Vec3::Zero());
        else
            array.resize(count);
    });
    surface.next_id = static_cast<std::int64_t>(n);
    parallel_for(
        drawn.size(),
        [&](std::size_t c) {
            for (std::size_t k = 0; k < drawn[c].size(); ++k) {
                const Drawn& d = drawn[c][k];
                const std::size_t i = first[c] + k;
                source[i] = d.root;
                surface.id[i] = d.id;
                surface.surfels.position[i] = d.now.place;
                surface.surfels.axis1[i] = d.now.axis1;
                surface.surfels.axis2[i] = d.now.axis2;
                surface.surfels.normal[i] = d.normal;
                surface.velocity[i] = d.velocity;
                surface.rest[i] = d.rest;
                surface.temperature[i] = embedded.temperature[d.root];
                surface.body[i] = solids.bodies[static_cast<std::size_t>(embedded.owner[d.root])].body;
            }
        },
        1);
}

}  // namespace thixo
