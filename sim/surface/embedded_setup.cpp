// Surfels on all solids of a scene, and the weights of the elements that displace them.
#include <algorithm>
#include <array>
#include <tuple>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/kernels.h"
#include "pipeline/geometry/shapes.h"
#include "pipeline/geometry/surface_sampling.h"
#include "sim/surface/embedded_surface.h"
#include "sim/surface/skin_sampling.h"

namespace thixo {
namespace {

constexpr int kEnough = 4;  // least number of elements whose weights a surfel needs

constexpr int kDirections = 16;
Real direction_angle(int w) { return static_cast<Real>(2 * kPi * w / kDirections); }

/// A disc of a face of a body.
struct FaceDisc {
    const Shape& shape;
    Vec3 centre, axis1, axis2;

    Vec3 direction(Real angle) const { return std::cos(angle) * axis1 + std::sin(angle) * axis2; }
    /// Whether x lies on the body, to a part of the disc's radius.
    bool on_body(const Vec3& x, Real part = Real(0.1)) const {
        return std::abs(shape.distance(x)) <= part * axis1.norm();
    }
};

/// How the body's edges cut a disc with its centre on the body. Among directions with equally near edges, the one with
/// the longest other axis is chosen. From a centre on an edge many directions lead off the body, and one leads
/// straight.
EdgeCut edge_cut(const FaceDisc& disc) {
    std::array<Real, kDirections> reach{};
    for (int w = 0; w < kDirections; ++w) {
        const Vec3 direction = disc.direction(direction_angle(w));
        Real r = 1;
        while (r > Real(0.15) && !disc.on_body(disc.centre + r * direction)) r -= Real(0.05);
        reach[static_cast<std::size_t>(w)] = r;
    }
    const Real least = *std::ranges::min_element(reach);
    EdgeCut cut{0, least, -1};
    for (int w = 0; w < kDirections; ++w) {
        const auto at = [&](int k) { return reach[static_cast<std::size_t>(k % kDirections)]; };
        const Real across = std::min(at(w + kDirections / 4), at(w + 3 * kDirections / 4));
        if (at(w) > least + Real(0.01) || across <= cut.across) continue;
        cut.angle = direction_angle(w);
        cut.across = across;
    }
    return cut;
}

/// The same for a disc with its centre past the edge: it moves to the body by the shortest shift, and a little on.
/// Equally short shifts lie on both sides of the straight one, which is their mean.
EdgeCut edge_cut_past(const FaceDisc& disc) {
    constexpr Real kOn = Real(0.15);
    for (Real r = Real(0.05); r < 1; r += Real(0.05)) {
        Real cosine = 0, sine = 0;
        for (int w = 0; w < kDirections; ++w) {
            if (!disc.on_body(disc.centre + r * disc.direction(direction_angle(w)), Real(0.02) + Real(0.08) * r * r))
                continue;
            cosine += std::cos(direction_angle(w));
            sine += std::sin(direction_angle(w));
        }
        if (std::hypot(cosine, sine) < Real(0.01)) continue;
        const Real angle = std::atan2(sine, cosine);
        const Vec3 there = disc.centre + (r + kOn) * disc.direction(angle);
        if (!disc.on_body(there)) continue;
        EdgeCut cut = edge_cut({disc.shape, there, disc.axis1, disc.axis2});
        cut.shift_angle = angle;
        cut.shift = r + kOn;
        return cut;
    }
    return {0, 0, 0};
}

Real disc_of(const SurfelCloud& cloud, std::size_t i) { return std::max(cloud.axis1[i].norm(), cloud.axis2[i].norm()); }

/// Weakens the weights from row `begin` on by what stands between their elements and surfel i. Returns whether any is
/// weakened. Where no element would be left, all stay.
bool screen_weights(const SurfelCloud& rest, Index i, const ElementSight& sight, std::size_t begin,
                    std::vector<SurfelWeight>& weights) {
    std::vector<Real> left;
    std::vector<Index> elements;
    for (std::size_t k = begin; k < weights.size(); ++k) elements.push_back(weights[k].element);
    if (!sight(rest.position[i], rest.normal[i], elements, left)) return false;
    Real least = 1, sum[3] = {0, 0, 0};
    for (std::size_t k = begin; k < weights.size(); ++k) {
        const SurfelWeight& w = weights[k];
        const Real a = left[k - begin];
        least = std::min(least, a);
        sum[0] += a * w.at, sum[1] += a * w.along1, sum[2] += a * w.along2;
    }
    if (!(least < 1) || !(std::min({sum[0], sum[1], sum[2]}) > 0)) return false;
    for (std::size_t k = begin; k < weights.size(); ++k) {
        const Real a = left[k - begin];
        weights[k].at *= a, weights[k].along1 *= a, weights[k].along2 *= a;
    }
    const auto own = weights.begin() + static_cast<std::ptrdiff_t>(begin);
    weights.erase(std::remove_if(own, weights.end(),
                                 [](const SurfelWeight& w) { return w.at == 0 && w.along1 == 0 && w.along2 == 0; }),
                  weights.end());
    return true;
}

/// Appends the weights of surfel i, of all elements within its support of its middle or of an end of its axes. Returns
/// whether a crack weakens any. Where matter breaks they stand and are summed up in the order of the elements. So they do
/// not depend on when the grid was made.
bool append_weights(const PointGrid& grid, const Solids& solids, const EmbeddedSurface& embedded, Index i,
                    const ElementSight& sight, std::vector<SurfelWeight>& out) {
    const SolidBody& body = solids.bodies[static_cast<std::size_t>(embedded.owner[i])];
    const std::size_t begin = out.size();
    const Real support = embedded.support[i];
    const Poly6 w(support);
    Real sum[3] = {0, 0, 0};
    const Vec3& m = embedded.rest.position[i];
    const Vec3 place[3] = {m, m + embedded.rest.axis1[i], m + embedded.rest.axis2[i]};
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
    const bool screened = sight && screen_weights(embedded.rest, i, sight, begin, out);
    const bool breaks = solids.elements.breaks;
    if (breaks)
        std::sort(out.begin() + static_cast<std::ptrdiff_t>(begin), out.end(),
                  [](const SurfelWeight& a, const SurfelWeight& b) { return a.element < b.element; });
    if (screened || breaks) {
        std::ranges::fill(sum, Real(0));
        for (std::size_t k = begin; k < out.size(); ++k)
            sum[0] += out[k].at, sum[1] += out[k].along1, sum[2] += out[k].along2;
    }
    for (std::size_t k = begin; k < out.size(); ++k) {
        out[k].at /= sum[0];
        out[k].along1 /= sum[1];
        out[k].along2 /= sum[2];
    }
    return screened;
}

/// The weights of the surfels `which`, one after the other, and where those of each end.
struct FoundWeights {
    std::vector<SurfelWeight> weight;
    std::vector<std::size_t> end;
    std::vector<std::uint8_t> screened;
};
FoundWeights find_weights(const Solids& solids, const std::vector<Index>& which, const ElementSight& sight,
                          const EmbeddedSurface& embedded) {
    const std::size_t count = which.size();
    std::vector<std::vector<SurfelWeight>> found((count + kChunk - 1) / kChunk);
    FoundWeights out;
    out.end.resize(count);
    out.screened.resize(count);
    parallel_chunks(count, [&](std::size_t begin, std::size_t stop, std::size_t c) {
        for (std::size_t k = begin; k < stop; ++k) {
            const Index i = which[k];
            const auto owner = static_cast<std::size_t>(embedded.owner[i]);
            out.screened[k] = append_weights(embedded.grid[owner], solids, embedded, i, sight, found[c]);
            out.end[k] = found[c].size();
        }
    });
    for (std::size_t c = 0; c < found.size(); ++c) {
        const std::size_t before = out.weight.size();
        out.weight.insert(out.weight.end(), found[c].begin(), found[c].end());
        for (std::size_t k = c * kChunk; k < std::min(count, (c + 1) * kChunk); ++k) out.end[k] += before;
    }
    return out;
}

/// Replaces the weights of the surfels `which`, ascending; all others stay.
void replace_weights(const std::vector<Index>& which, const FoundWeights& found, EmbeddedSurface& embedded) {
    std::vector<std::size_t> begin{0};
    std::vector<SurfelWeight> weight;
    std::size_t next = 0;
    for (Index i = 0; i < embedded.size(); ++i) {
        const bool fresh = next < which.size() && which[next] == i;
        const auto& from = fresh ? found.weight : embedded.weight;
        const std::size_t first = fresh ? (next == 0 ? 0 : found.end[next - 1]) : embedded.begin[i];
        const std::size_t last = fresh ? found.end[next] : embedded.begin[i + 1];
        weight.insert(weight.end(), from.begin() + static_cast<std::ptrdiff_t>(first),
                      from.begin() + static_cast<std::ptrdiff_t>(last));
        begin.push_back(weight.size());
        next += fresh ? 1 : 0;
    }
    embedded.begin.swap(begin);
    embedded.weight.swap(weight);
    embedded.screened.resize(embedded.size(), 0);
    for (std::size_t k = 0; k < which.size(); ++k) embedded.screened[which[k]] = found.screened[k];
}

/// The surfels of cracks whose other side belongs to the same body, ascending. Both sides are laid at one place.
std::vector<Index> closed_faces(const EmbeddedSurface& embedded, std::int32_t owner) {
    std::vector<Index> faces;
    for (Index i = 0; i < embedded.size(); ++i)
        if (embedded.owner[i] == owner && embedded.sheet[i] >= kFirstCrackSheet) faces.push_back(i);
    const auto key = [&](Index i) {
        const Vec3& m = embedded.rest.position[i];
        return std::tuple(embedded.sheet[i] / 2, m.x(), m.y(), m.z());
    };
    std::ranges::sort(faces, [&](Index a, Index b) { return std::pair(key(a), a) < std::pair(key(b), b); });
    std::vector<Index> both;
    for (std::size_t k = 1; k < faces.size(); ++k)
        if (key(faces[k]) == key(faces[k - 1])) both.insert(both.end(), {faces[k - 1], faces[k]});
    std::ranges::sort(both);
    return both;
}

/// Finds how a body's new surfels, from row `first` on, lie about its edges.
void find_edges(const Shape& shape, double spacing, std::size_t first, EmbeddedSurface& embedded) {
    parallel_for(embedded.size() - first, [&](std::size_t k) {
        const std::size_t i = first + k;
        const Vec3& x = embedded.first[i];
        const FaceDisc disc{shape, x, embedded.rest.axis1[i], embedded.rest.axis2[i]};
        embedded.beyond[i] = std::abs(shape.distance(x)) > Real(0.02 * spacing);
        embedded.edge[i] = embedded.beyond[i] ? edge_cut_past(disc) : edge_cut(disc);
    });
}

}  // namespace

Real weights_support(const PointGrid& grid, const Vec3& m, Real disc, Real usual) {
    std::vector<std::pair<Real, Index>> near;
    grid.nearest(m, kEnough, std::numeric_limits<Real>::max(), near);
    return std::max(usual, Real(1.2) * (std::sqrt(near.back().first) + disc));
}

EmbeddedSurface make_embedded_surface(const scene::Scene& scene, const Solids& solids) {
    EmbeddedSurface out;
    out.trim.resize(solids.bodies.size());
    out.grid.resize(solids.bodies.size());
    for (std::size_t b = 0; b < solids.bodies.size(); ++b) {
        const SolidBody& body = solids.bodies[b];
        // A body without a rest shape has no such surface.
        if (!body.shaped() || solids.elements.phase_of(body.elements.front()) != Phase::solid) continue;
        const scene::Body& source = scene.bodies[static_cast<std::size_t>(body.source)];
        const SampledSurface sampled = sample_surface(*body.shape, skin_sampling(scene, source));
        const std::size_t first = out.size();
        append_surfels(sampled.surfels, body, static_cast<std::int32_t>(b), out);
        std::ranges::copy(sampled.sheet, out.sheet.begin() + static_cast<std::ptrdiff_t>(first));
        std::fill(out.temperature.begin() + static_cast<std::ptrdiff_t>(first), out.temperature.end(),
                  static_cast<Real>(source.temperature));
        if (!sampled.trim) continue;
        find_edges(*body.shape, sampled.spacing, first, out);
        out.trim[b] = trim_node(*sampled.trim);
    }
    out.families_made = 1;
    out.families = {{.first = 0, .base = 0, .shift = static_cast<std::int64_t>(out.size())}};
    bind_surfels(solids, std::vector<std::uint8_t>(solids.bodies.size(), 1), out);
    return out;
}

void append_surfels(const SurfelCloud& cloud, const SolidBody& body, std::int32_t owner, EmbeddedSurface& embedded) {
    const std::size_t first = embedded.size();
    resize_table(embedded, first + cloud.size());
    embedded.begin.resize(embedded.size() + 1, embedded.begin.back());
    for (std::size_t k = 0; k < cloud.size(); ++k) {
        const std::size_t i = first + k;
        embedded.rest.position[i] = cloud.position[k] - body.origin;
        embedded.rest.axis1[i] = cloud.axis1[k];
        embedded.rest.axis2[i] = cloud.axis2[k];
        embedded.rest.normal[i] = cloud.normal[k];
        embedded.owner[i] = owner;
        embedded.frame[i] = body.frame;
        embedded.first[i] = cloud.position[k];
    }
}

void bind_surfels(const Solids& solids, const std::vector<std::uint8_t>& bodies, EmbeddedSurface& embedded,
                  const ElementSight& sight) {
    std::vector<Index> which;
    for (Index i = 0; i < embedded.size(); ++i)
        if (bodies[static_cast<std::size_t>(embedded.owner[i])]) which.push_back(i);
    embedded.grid.resize(solids.bodies.size());
    embedded.trim.resize(solids.bodies.size());
    for (std::size_t b = 0; b < solids.bodies.size(); ++b)
        if (bodies[b]) embedded.grid[b] = {};
    bind_some_surfels(solids, which, embedded, sight);
}

void bind_some_surfels(const Solids& solids, const std::vector<Index>& which, EmbeddedSurface& embedded,
                       const ElementSight& sight) {
    std::vector<Real> widest(solids.bodies.size(), 0);
    for (const Index i : which) widest[static_cast<std::size_t>(embedded.owner[i])] = 1;
    std::vector<PointGrid> near(solids.bodies.size());
    for (std::size_t b = 0; b < solids.bodies.size(); ++b) {
        const SolidBody& body = solids.bodies[b];
        if (!(widest[b] > 0) || !body.shaped() || body.empty()) continue;
        widest[b] = solids.elements.support[body.typical];
        near[b].build(rest_places(body, solids.elements), widest[b]);
    }
    parallel_for(which.size(), [&](std::size_t k) {
        const Index i = which[k];
        const auto b = static_cast<std::size_t>(embedded.owner[i]);
        embedded.support[i] =
            weights_support(near[b], embedded.rest.position[i], disc_of(embedded.rest, i), near[b].cell());
    });
    // The grid's cells must hold the widest reach: of all surfels of a body whose grid is made anew.
    for (Index i = 0; i < embedded.size(); ++i) {
        const auto b = static_cast<std::size_t>(embedded.owner[i]);
        const bool made = embedded.grid[b].cell() > 0;
        if (solids.bodies[b].empty() || (made && !(widest[b] > 0))) continue;
        widest[b] = std::max(widest[b], reach_of_pieces(embedded, i));
    }
    for (std::size_t b = 0; b < solids.bodies.size(); ++b)
        if (widest[b] > 0 && !(embedded.grid[b].cell() >= widest[b]))
            embedded.grid[b].build(rest_places(solids.bodies[b], solids.elements), widest[b]);
    replace_weights(which, find_weights(solids, which, sight, embedded), embedded);
}

std::optional<Shape> shape_of_surfels(const EmbeddedSurface& embedded, const SolidBody& body, std::int32_t index) {
    constexpr std::size_t kFewest = 16;  // surfels_of_points needs as many
    TriangleMesh points;
    const std::vector<Index> closed = closed_faces(embedded, index);
    for (std::size_t i = 0; i < embedded.size(); ++i) {
        if (embedded.owner[i] != index || embedded.beyond[i] ||
            std::ranges::binary_search(closed, static_cast<Index>(i)))
            continue;
        points.vertices.push_back((embedded.rest.position[i] + body.origin).cast<float>());
        points.normals.push_back(embedded.rest.normal[i].cast<float>());
    }
    if (points.vertices.size() < kFewest) return std::nullopt;
    return point_shape(std::move(points));
}

}  // namespace thixo
