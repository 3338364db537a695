// Surfels on all solids of a scene, and what they are displaced by.
#include <algorithm>
#include <array>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/kernels.h"
#include "pipeline/geometry/surface_sampling.h"
#include "sim/space/scene_shapes.h"
#include "sim/surface/embedded_surface.h"

namespace thixo {
namespace {

constexpr int kEnough = 4;  // elements whose weights a surfel needs at least

constexpr int kWays = 16;
Real way_angle(int w) { return static_cast<Real>(2 * kPi * w / kWays); }

/// A disc of a face of a body.
struct FaceDisc {
    const Shape& shape;
    Vec3 centre, axis1, axis2;

    Vec3 way(Real angle) const { return std::cos(angle) * axis1 + std::sin(angle) * axis2; }
    /// Within a part of the disc's radius.
    bool on_body(const Vec3& x, Real part = Real(0.1)) const {
        return std::abs(shape.distance(x)) <= part * axis1.norm();
    }
};

/// How a disc with its centre on the body is cut by its edges. Of ways that are as short the one along which the other
/// axis is longest: from a centre on an edge many ways lead off the body, and one leads straight.
EdgeCut edge_cut(const FaceDisc& disc) {
    std::array<Real, kWays> reach{};
    for (int w = 0; w < kWays; ++w) {
        const Vec3 way = disc.way(way_angle(w));
        Real r = 1;
        while (r > Real(0.15) && !disc.on_body(disc.centre + r * way)) r -= Real(0.05);
        reach[static_cast<std::size_t>(w)] = r;
    }
    const Real least = *std::ranges::min_element(reach);
    EdgeCut cut{0, least, -1};
    for (int w = 0; w < kWays; ++w) {
        const auto at = [&](int k) { return reach[static_cast<std::size_t>(k % kWays)]; };
        const Real across = std::min(at(w + kWays / 4), at(w + 3 * kWays / 4));
        if (at(w) > least + Real(0.01) || across <= cut.across) continue;
        cut.angle = way_angle(w);
        cut.across = across;
    }
    return cut;
}

/// The same of a disc with its centre past the edge: it goes the shortest way to the body, and a little on. Ways that
/// are as short lie to both sides of the one that leads straight, their mean.
EdgeCut edge_cut_past(const FaceDisc& disc) {
    constexpr Real kOn = Real(0.15);
    for (Real r = Real(0.05); r < 1; r += Real(0.05)) {
        Real c = 0, s = 0;
        for (int w = 0; w < kWays; ++w) {
            if (!disc.on_body(disc.centre + r * disc.way(way_angle(w)), Real(0.02) + Real(0.08) * r * r)) continue;
            c += std::cos(way_angle(w));
            s += std::sin(way_angle(w));
        }
        if (std::hypot(c, s) < Real(0.01)) continue;
        const Real angle = std::atan2(s, c);
        const Vec3 there = disc.centre + (r + kOn) * disc.way(angle);
        if (!disc.on_body(there)) continue;
        EdgeCut cut = edge_cut({disc.shape, there, disc.axis1, disc.axis2});
        cut.shift_angle = angle;
        cut.shift = r + kOn;
        return cut;
    }
    return {0, 0, 0};
}

/// The weights of a disc's three places, of all elements within `support` of any of them.
void append_weights(const PointGrid& grid, const SolidBody& body, const Vec3& m, const Vec3& axis1, const Vec3& axis2,
                    Real support, std::vector<SurfelWeight>& out) {
    const std::size_t begin = out.size();
    const Poly6 w(support);
    Real sum[3] = {0, 0, 0};
    const Vec3 place[3] = {m, m + axis1, m + axis2};
    for (int k = 0; k < 3; ++k)
        grid.for_each_neighbour(place[k], support, [&](Index near, Real r2) {
            const Index element = body.elements[near];
            auto at = std::find_if(out.begin() + static_cast<std::ptrdiff_t>(begin), out.end(),
                                   [&](const SurfelWeight& a) { return a.element == element; });
            if (at == out.end()) at = out.insert(at, {0, 0, 0, element});
            Real& weight = k == 0 ? at->at : k == 1 ? at->along1 : at->along2;
            weight = w.value(r2);
            sum[k] += weight;
        });
    for (std::size_t i = begin; i < out.size(); ++i) {
        out[i].at /= sum[0];
        out[i].along1 /= sum[1];
        out[i].along2 /= sum[2];
    }
}

/// The weights of the last body's surfels, from those on that have none yet.
void keep_weights(const SolidBody& body, EmbeddedSurface& s) {
    const std::size_t from = s.begin.size() - 1, count = s.size() - from;
    std::vector<std::vector<SurfelWeight>> found((count + kChunk - 1) / kChunk);
    std::vector<std::size_t> end(count);
    parallel_chunks(count, [&](std::size_t begin, std::size_t stop, std::size_t c) {
        for (std::size_t k = begin; k < stop; ++k) {
            const std::size_t i = from + k;
            append_weights(s.grid.back(), body, s.rest.position[i], s.rest.axis1[i], s.rest.axis2[i], s.support[i],
                           found[c]);
            end[k] = found[c].size();
        }
    });
    for (std::size_t c = 0; c < found.size(); ++c) {
        const std::size_t before = s.weight.size();
        s.weight.insert(s.weight.end(), found[c].begin(), found[c].end());
        for (std::size_t k = c * kChunk; k < std::min(count, (c + 1) * kChunk); ++k) s.begin.push_back(before + end[k]);
    }
}

}  // namespace

Real weights_support(const PointGrid& grid, const Vec3& m, Real disc, Real usual) {
    std::vector<std::pair<Real, Index>> near;
    grid.nearest(m, kEnough, std::numeric_limits<Real>::max(), near);
    return std::max(usual, Real(1.2) * (std::sqrt(near.back().first) + disc));
}

EmbeddedSurface make_embedded_surface(const scene::Scene& scene, const Solids& solids) {
    EmbeddedSurface out;
    for (std::size_t b = 0; b < solids.bodies.size(); ++b) {
        const SolidBody& body = solids.bodies[b];
        out.trim.emplace_back();
        out.grid.emplace_back();
        // What has no rest shape has no such surface.
        if (!body.shaped() || solids.elements.phase_of(body.elements.front()) != Phase::solid) continue;
        const scene::Body& source = scene.bodies[static_cast<std::size_t>(body.source)];
        const Shape shape = make_shape(scene, source.shape);
        SurfaceSampling sampling{.count = static_cast<std::size_t>(source.surfels), .seed = scene.solver.seed};
        if (source.surfels == 0) sampling.spacing = scene.surface.radius * scene.solver.spacing;
        const SampledSurface sampled = sample_surface(shape, sampling);
        const std::vector<Vec3> place = rest_places(body, solids.elements);
        const Real usual = solids.elements.support[body.typical];
        // The grid's cells must hold the widest reach.
        PointGrid near;
        near.build(place, usual);
        const Vec3 centre = body.place.cast<Real>();
        Real widest = usual;
        const SurfelCloud& cloud = sampled.surfels;
        const auto disc = [&](std::size_t k) { return std::max(cloud.axis1[k].norm(), cloud.axis2[k].norm()); };
        std::vector<char> beyond(cloud.size());
        std::vector<EdgeCut> edge(cloud.size());
        std::vector<Real> support(cloud.size());
        parallel_for(cloud.size(), [&](std::size_t k) {
            support[k] = weights_support(near, cloud.position[k] - centre, disc(k), usual);
            if (!sampled.trim) return;
            beyond[k] = std::abs(shape.distance(cloud.position[k])) > Real(0.02 * sampled.spacing);
            const FaceDisc disc{shape, cloud.position[k], cloud.axis1[k], cloud.axis2[k]};
            edge[k] = beyond[k] ? edge_cut_past(disc) : edge_cut(disc);
        });
        for (std::size_t k = 0; k < cloud.size(); ++k) {
            const Vec3 m = cloud.position[k] - centre;
            out.rest.position.push_back(m);
            out.rest.axis1.push_back(cloud.axis1[k]);
            out.rest.axis2.push_back(cloud.axis2[k]);
            out.rest.normal.push_back(cloud.normal[k]);
            out.owner.push_back(static_cast<std::int32_t>(b));
            out.sheet.push_back(sampled.sheet[k]);
            out.first.push_back(cloud.position[k]);
            out.beyond.push_back(beyond[k]);
            out.edge.push_back(edge[k]);
            out.support.push_back(support[k]);
            out.temperature.push_back(static_cast<Real>(source.temperature));
            widest = std::max(widest, reach_of_pieces(out, out.size() - 1));
        }
        if (sampled.trim) out.trim.back() = trim_node(*sampled.trim);
        out.grid.back().build(place, widest);
        keep_weights(body, out);
    }
    return out;
}

}  // namespace thixo
