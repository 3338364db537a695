#include "sim/surface/embedded_surface.h"

#include <algorithm>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/kernels.h"
#include "sim/bonds/gradients.h"

namespace thixo {
namespace {

/// The displacement of a place, H m + u, and its velocity v.
struct Carried {
    static constexpr std::size_t kParts = 16 / kLanes;
    Lanes part[kParts]{};
    void add(Real weight, const AffineMotion& motion) {
        for (std::size_t p = 0; p < kParts; ++p) part[p] += weight * load(motion.value + p * kLanes);
    }
    Real operator[](std::size_t k) const { return part[k / kLanes][k % kLanes]; }
    Vec3 shift(const Vec3& m) const {
        Vec3 u;
        for (std::size_t k = 0; k < 3; ++k)
            u[static_cast<int>(k)] =
                (*this)[9 + k] + ((*this)[k] * m.x() + (*this)[3 + k] * m.y() + (*this)[6 + k] * m.z());
        return u;
    }
    Vec3 velocity() const { return {(*this)[12], (*this)[13], (*this)[14]}; }
};
/// The displacement at the place m of the material frame.
Carried carried(const PointGrid& grid, const SolidBody& body, const std::vector<AffineMotion>& motions, const Vec3& m,
                Real support) {
    const Poly6 w(support);
    Real weight = 0;
    Carried sum;
    grid.for_each_neighbour(m, support, [&](Index near, Real r2) {
        const Real a = w.value(r2);
        weight += a;
        sum.add(a, motions[body.elements[near]]);
    });
    for (Lanes& p : sum.part) p /= weight;
    return sum;
}

void find_motions(const Elements& e, const std::vector<Mat3>& gradients, std::vector<AffineMotion>& motions) {
    motions.resize(e.size());
    parallel_for(e.size(), [&](std::size_t i) {
        const Mat3& h = gradients[i];
        const Vec3 shift = xyz(e.displacement[i]) - h * xyz(e.rest[i]), v = xyz(e.velocity[i]);
        Real* value = motions[i].value;
        for (int k = 0; k < 9; ++k) value[k] = h(k % 3, k / 3);
        for (int k = 0; k < 3; ++k) value[9 + k] = shift[k], value[12 + k] = v[k];
        value[15] = 0;
    });
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

/// A body's pose, split into its parts once.
struct Pose {
    Mat3d turn;
    Vec3d place;
    Mat3 turn_of_axes;
    explicit Pose(const SolidBody& b) : turn(b.turn), place(b.place), turn_of_axes(b.turn.cast<Real>()) {}
};

/// The tables that displace an original surfel.
struct Field {
    const EmbeddedSurface& embedded;
    const Solids& solids;
    const Pose& pose;
    std::size_t root;
};

/// All elements that displace a surfel's pieces, side by side.
struct PieceElements {
    std::vector<Real> x, y, z;
    std::vector<Index> element;

    void find(const Field& field) {
        const EmbeddedSurface& embedded = field.embedded;
        const auto owner = static_cast<std::size_t>(embedded.owner[field.root]);
        const SolidBody& body = field.solids.bodies[owner];
        x.clear(), y.clear(), z.clear(), element.clear();
        const auto add = [&](Index i) {
            const Quad& m = field.solids.elements.rest[i];
            x.push_back(m.x), y.push_back(m.y), z.push_back(m.z);
            element.push_back(i);
        };
        if (embedded.screened[field.root]) {
            // Beside a crack: those that the surfel itself sees.
            for (std::size_t k = embedded.begin[field.root]; k < embedded.begin[field.root + 1]; ++k)
                add(embedded.weight[k].element);
        } else {
            embedded.grid[owner].for_each_neighbour(embedded.rest.position[field.root],
                                                    reach_of_pieces(embedded, field.root),
                                                    [&](Index near, Real) { add(body.elements[near]); });
        }
        // Padded with elements out of all reach.
        constexpr Real kFar = Real(1e18);
        for (const std::size_t n = (element.size() + kLanes - 1) / kLanes * kLanes; x.size() < n;)
            x.push_back(kFar), y.push_back(kFar), z.push_back(kFar);
    }
    Carried at(const Field& field, const Vec3& m) const {
        const Poly6 w(field.embedded.support[field.root]);
        Carried sum;
        Lanes weight{};
        for (std::size_t k = 0; k < x.size(); k += kLanes) {
            const Lanes dx = load(&x[k]) - m.x(), dy = load(&y[k]) - m.y(), dz = load(&z[k]) - m.z();
            const Lanes q = positive(1 - w.h2_inv * (dx * dx + dy * dy + dz * dz)), a = q * q * q;
            weight += a;
            for (std::size_t l = 0; l < std::min(kLanes, element.size() - k); ++l)
                if (a[l] > 0) sum.add(a[l], field.solids.motions[element[k + l]]);
        }
        const Real total = sum_of(weight);
        if (!(total > 0)) sum.add(1, field.solids.motions[nearest(m)]);
        for (Lanes& p : sum.part) p /= total > 0 ? total : Real(1);
        return sum;
    }
    /// Beside a crack a piece may see no element within the support.
    Index nearest(const Vec3& m) const {
        std::size_t best = 0;
        const auto away = [&](std::size_t k) { return (Vec3(x[k], y[k], z[k]) - m).squaredNorm(); };
        for (std::size_t k = 1; k < element.size(); ++k)
            if (away(k) < away(best)) best = k;
        return element[best];
    }
};

/// The displaced disc, from the displacements of its middle and of its axes' ends.
Drawn displaced(const Field& field, const Disc& rest, const Carried& middle, const Carried& end1, const Carried& end2,
                std::int64_t id) {
    const Pose& pose = field.pose;
    const Vec3 shift = middle.shift(rest.place);
    Drawn d;
    d.now.place = (pose.turn * (rest.place + shift).cast<double>() + pose.place).cast<Real>();
    d.now.axis1 = pose.turn_of_axes * (rest.axis1 + end1.shift(rest.place + rest.axis1) - shift);
    d.now.axis2 = pose.turn_of_axes * (rest.axis2 + end2.shift(rest.place + rest.axis2) - shift);
    const Vec3 n = d.now.axis1.cross(d.now.axis2);
    const Real size = n.norm();
    d.normal = size > 0 ? Vec3(n / size) : Vec3(pose.turn_of_axes * field.embedded.rest.normal[field.root]);
    d.velocity = pose.turn_of_axes * middle.velocity();
    d.rest = field.embedded.first[field.root] + rest.place - field.embedded.rest.position[field.root];
    d.id = id;
    d.root = static_cast<Index>(field.root);
    return d;
}

Disc rest_disc(const EmbeddedSurface& embedded, std::size_t root) {
    return {embedded.rest.position[root], embedded.rest.axis1[root], embedded.rest.axis2[root]};
}

/// The displaced original surfel, by its stored weights.
Drawn displaced_root(const Field& field) {
    const EmbeddedSurface& embedded = field.embedded;
    Carried middle, end1, end2;
    for (std::size_t k = embedded.begin[field.root]; k < embedded.begin[field.root + 1]; ++k) {
        const SurfelWeight& w = embedded.weight[k];
        const AffineMotion& motion = field.solids.motions[w.element];
        middle.add(w.at, motion);
        end1.add(w.along1, motion);
        end2.add(w.along2, motion);
    }
    return displaced(field, rest_disc(embedded, field.root), middle, end1, end2, embedded.id(field.root));
}

/// Whether a disc splits, and the angle of its longest direction from the first axis.
struct Stretch {
    bool splits;
    Real angle;
};
Stretch stretch_of(const Drawn& d, Real radius2) {
    const Vec3 &a = d.now.axis1, &b = d.now.axis2;
    const Real aa = a.squaredNorm() / radius2, bb = b.squaredNorm() / radius2, ab = a.dot(b) / radius2;
    const Real mean = (aa + bb) / 2, half = std::sqrt(square((aa - bb) / 2) + square(ab));
    const Real longest = mean + half, shortest = mean - half;
    if (!(longest > kSplitStretch || (longest > Real(1.2) && longest > kSplitRatio * shortest))) return {false, 0};
    return {true, std::atan2(2 * ab, aa - bb) / 2};
}

/// Appends the surfel or its pieces: it is cut in two along its longest direction, into halves that overlap a little.
void draw(const Field& field, const PieceElements& near, const Disc& rest, const Drawn& d, int level,
          std::vector<Drawn>& out) {
    constexpr int kDeepest = 8;
    const Stretch stretch = stretch_of(d, field.embedded.rest.axis1[field.root].squaredNorm());
    if (level == kDeepest || !stretch.splits) return out.push_back(d);
    const Real c = std::cos(stretch.angle), s = std::sin(stretch.angle);
    const Vec3 along = c * rest.axis1 + s * rest.axis2, across = c * rest.axis2 - s * rest.axis1;
    for (const int side : {0, 1}) {
        const Disc half{rest.place + (static_cast<Real>(side) - Real(0.5)) * along, Real(0.6) * along, across};
        const std::int64_t id = 2 * d.id + field.embedded.family(field.root).shift + side;
        draw(field, near, half,
             displaced(field, half, near.at(field, half.place), near.at(field, half.place + half.axis1),
                       near.at(field, half.place + half.axis2), id),
             level + 1, out);
    }
}

void put(const Drawn& d, const EmbeddedSurface& embedded, std::int32_t body, std::size_t i, SurfaceState& surface) {
    surface.id[i] = d.id;
    surface.surfels.position[i] = d.now.place;
    surface.surfels.axis1[i] = d.now.axis1;
    surface.surfels.axis2[i] = d.now.axis2;
    surface.surfels.normal[i] = d.normal;
    surface.velocity[i] = d.velocity;
    surface.rest[i] = d.rest;
    surface.temperature[i] = embedded.temperature[d.root];
    surface.body[i] = body;
}

/// Surfels that are replaced by pieces: their places, and which of `pieces` follow in the place of each.
struct Splits {
    std::vector<Index> at;           // ascending
    std::vector<std::size_t> first;  // of each, then the end
};
/// Replaces surfels by their pieces in an array, from the end.
template <class T>
void expand(const Splits& splits, const std::vector<T>& pieces, std::vector<T>& array) {
    std::size_t from = array.size();
    array.resize(from - splits.at.size() + pieces.size(), array[0]);
    auto to = array.end();
    const auto iterator = [](auto& a, std::size_t k) { return a.begin() + static_cast<std::ptrdiff_t>(k); };
    for (std::size_t k = splits.at.size(); k-- > 0; from = splits.at[k]) {
        to = std::move_backward(iterator(array, splits.at[k] + 1), iterator(array, from), to);
        to = std::copy_backward(iterator(pieces, splits.first[k]), iterator(pieces, splits.first[k + 1]), to);
    }
}

}  // namespace

Vec3 displacement(const PointGrid& grid, const SolidBody& body, const Solids& solids, const Vec3& m, Real support) {
    return carried(grid, body, solids.motions, m, support).shift(m);
}

std::optional<Vec3> displacement_at(const EmbeddedSurface& embedded, const Solids& solids, std::size_t owner,
                                    const Vec3& m, Real support) {
    const Vec3 u = displacement(embedded.grid[owner], solids.bodies[owner], solids, m, support);
    return u.allFinite() ? std::optional(u) : std::nullopt;
}

void displace_embedded(const EmbeddedSurface& embedded, Solids& solids, SurfaceState& surface,
                       std::vector<Index>& source) {
    find_gradients(solids.elements, solids.gradients);
    complete_gradients(solids.elements, solids.gradients);
    find_motions(solids.elements, solids.gradients, solids.motions);
    const std::vector<Pose> poses(solids.bodies.begin(), solids.bodies.end());
    const auto field = [&](Index root) {
        return Field{embedded, solids, poses[static_cast<std::size_t>(embedded.owner[root])], root};
    };
    const auto body = [&](Index root) { return solids.bodies[static_cast<std::size_t>(embedded.owner[root])].id; };
    source.clear();
    for (Index root = 0; root < embedded.size(); ++root)
        if (solids.bodies[static_cast<std::size_t>(embedded.owner[root])].skin == Skin::embedded)
            source.push_back(root);
    const std::size_t count = source.size();
    resize_table(surface, count);
    surface.next_id = static_cast<std::int64_t>(embedded.size());
    std::vector<std::vector<Index>> split((count + kChunk - 1) / kChunk);
    parallel_chunks(count, [&](std::size_t begin, std::size_t end, std::size_t c) {
        for (std::size_t i = begin; i < end; ++i) {
            const Index root = source[i];
            const Drawn d = displaced_root(field(root));
            put(d, embedded, body(root), i, surface);
            if (stretch_of(d, embedded.rest.axis1[root].squaredNorm()).splits) split[c].push_back(Index(i));
        }
    });

    Splits splits{{}, {0}};
    for (const auto& part : split) splits.at.insert(splits.at.end(), part.begin(), part.end());
    if (splits.at.empty()) return;
    constexpr std::size_t kSplits = 32;  // of a chunk
    std::vector<std::vector<Drawn>> pieces((splits.at.size() + kSplits - 1) / kSplits);
    splits.first.resize(splits.at.size() + 1);
    parallel_chunks(
        splits.at.size(),
        [&](std::size_t begin, std::size_t end, std::size_t c) {
            PieceElements near;
            for (std::size_t k = begin; k < end; ++k) {
                const Field f = field(source[splits.at[k]]);
                near.find(f);
                draw(f, near, rest_disc(embedded, f.root), displaced_root(f), 0, pieces[c]);
                splits.first[k + 1] = pieces[c].size();
            }
        },
        kSplits);
    for (std::size_t k = kSplits; k < splits.at.size(); ++k) splits.first[k + 1] += splits.first[k / kSplits * kSplits];
    SurfaceState parts;
    std::vector<Index> roots;
    resize_table(parts, splits.first.back());
    roots.reserve(splits.first.back());
    for (const auto& part : pieces)
        for (const Drawn& d : part) {
            put(d, embedded, body(d.root), roots.size(), parts);
            roots.push_back(d.root);
        }
    for_each_pair(surface, parts, [&](auto& array, const auto& from) { expand(splits, from, array); });
    expand(splits, roots, source);
}

}  // namespace thixo
