#include "sim/contact/narrow.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "pipeline/base/parallel.h"
#include "sim/bonds/element_fit.h"
#include "sim/bonds/gradients.h"
#include "sim/contact/contact.h"

namespace thixo {
namespace {

constexpr Real kSteepest = 3;           // largest change of the distance per distance in the world
constexpr Real kInside = Real(0.1);     // how far ahead of a sample the face it meets is looked for, in widths
constexpr Real kSameFace = Real(0.99);  // cosine between its normals at that depth and at half of it
// In widths: the shape of a body that has split is that of its surfels, and is good to this beside its new edges. Pieces
// that part at rest would otherwise push each other.
constexpr Real kRoomAtCuts = Real(0.1);
constexpr Real kFacing = Real(0.2);  // least cosine between one surface's normal and minus the other's

/// The outward normal of the surface at a sample, J^-T n of the element with the largest weight. It is not a unit
/// vector.
Vec3 normal_of(const View& view, Index sample) {
    const ContactSamples& samples = view.solids.contacts.samples;
    std::size_t host = samples.weights.begin[sample];
    for (std::size_t k = host; k < samples.weights.begin[sample + 1]; ++k)
        if (samples.weights.weight[k] > samples.weights.weight[host]) host = k;
    const Mat3 j = Mat3::Identity() + gradient_of(view.solids.elements, samples.weights.element[host]);
    const Vec3& n = samples.normal[sample];
    const Vec3 turned =
        j.col(1).cross(j.col(2)) * n.x() + j.col(2).cross(j.col(0)) * n.y() + j.col(0).cross(j.col(1)) * n.z();
    return view.poses[at(samples.owner[sample])].turn * turned;
}

void take_weights(const ContactSamples& samples, Index sample, Found& to) {
    const auto first = static_cast<std::ptrdiff_t>(samples.weights.begin[sample]),
               last = static_cast<std::ptrdiff_t>(samples.weights.begin[sample + 1]);
    to.element.assign(samples.weights.element.begin() + first, samples.weights.element.begin() + last);
    to.weight.assign(samples.weights.weight.begin() + first, samples.weights.weight.begin() + last);
    to.middle = to.element.size();
}

/// The node of a sample at x with a body, where the body's surface is nearer than the margin or has been passed.
std::optional<Found> meet(const View& view, Index sample, const Vec3& x, std::int32_t partner, ElementFit& fit) {
    const Contacts& c = view.solids.contacts;
    const Elements& e = view.solids.elements;
    const SolidBody& body = view.solids.bodies[at(partner)];
    const Real width = view.extents[at(partner)].width, margin = kContactMargin * width;
    if (!near_matter(view.solids, body, c.grid[at(partner)], x)) return std::nullopt;
    fit_elements<std::vector<Vec3>>({body, e, c.place, c.grid[at(partner)], view.poses[at(partner)].turn},
                                    e.support[body.typical], x, fit);
    const Vec3 m = fit.material + body.origin;
    const Shape& shape = *body.shape;
    const Real d = shape.distance(m) + (body.scene_shape ? Real(0) : kRoomAtCuts * width);
    if (!(d < 2 * margin)) return std::nullopt;
    // The sample meets the partner's face that lies before its own. About an edge the distance alone knows no face. An
    // oblique plane, or that of the side that slides past, would block sliding. Where even that face is not clear, an
    // edge meets the sample's own face, and the plane is that of this face.
    const Vec3 own = normal_of(view, sample), inwards = fit.slope * own;
    const Vec3 ahead = kInside * width * inwards.normalized();
    const Vec3 face = shape.gradient(m + ahead, width / 64), before = shape.gradient(m + ahead / 2, width / 64);
    const bool clear = face.dot(before) > kSameFace;
    const Vec3 slope =
        clear ? Vec3(fit.slope.transpose() * face) : Vec3(-own.normalized() * inwards.norm() / own.norm());
    const Real steep = slope.norm();
    if (!(steep > Real(1e-3))) return std::nullopt;
    // A gap is of first order: where matter is compressed or stretched more than this, the gap says nothing.
    const Real steepness = std::clamp(steep, 1 / kSteepest, kSteepest);
    if (!(d < margin * steepness)) return std::nullopt;
    // Surfaces meet face to face. Beyond the middle of a thin body the way out leads to its far side, and is no
    // contact.
    if (slope.dot(own) > -kFacing * steep * own.norm()) return std::nullopt;
    const ContactSamples& samples = c.samples;
    Found out;
    out.sample = sample;
    out.owner = samples.owner[sample];
    out.partner = partner;
    out.gap = d / steepness;
    out.steepness = steepness;
    out.normal = slope / steep;
    out.area = samples.area[sample] / 2;
    take_weights(samples, sample, out);
    out.element.insert(out.element.end(), fit.element.begin(), fit.element.end());
    for (const Real w : fit.weight) out.weight.push_back(-w);
    return out;
}

/// The part of a sample's area that meets a wall with this normal. A side that stands on the wall has none. What faces
/// the wall has all of it, so that contact has an energy.
Real facing_part(const View& view, Index sample, const Vec3& normal) {
    return std::clamp(-normal_of(view, sample).normalized().dot(normal) / kFacing, Real(0), Real(1));
}

/// The part of an element that meets others as a solid: its surface, or, where matter melts off, all its solid matter.
Real solid_share(const View& view, Index i, Real width) {
    const Elements& e = view.solids.elements;
    if (!view.solids.softening.any) return e.depth[i] > width ? Real(0) : Real(1);
    return e.solidity(i);
}

/// The part of its rest width that an element has along a direction in the world. Matter that has flowed is as thin as it
/// was drawn. With the whole width a neck would burst once a crack parts what stands side by side in it.
Real thinned(const View& view, Index i, const Vec3& direction) {
    const Elements& e = view.solids.elements;
    if (!(norm(e.plastic[i]) > 0)) return 1;
    const Mat3 j = Mat3::Identity() + gradient_of(e, i);
    const Vec3 own = view.poses[at(e.owner[i])].turn.transpose() * direction;
    return std::min((j.transpose() * own).norm(), Real(1));
}

/// Whether two elements are neighbours in the rest shape, and no crack hides one from the other.
bool neighbours(const Bonds& bonds, Index i, Index j) {
    for (std::size_t k = bonds.begin[i]; k < bonds.begin[i + 1]; ++k)
        if (bonds.neighbour[k] == j) return bonds.visibility.empty() || bonds.visibility[k] > 0;
    return false;
}

}  // namespace

void find_samples(const View& view, std::int32_t owner, std::int32_t partner, Real explained,
                  std::vector<Found>& found) {
    const ContactSamples& samples = view.solids.contacts.samples;
    const Elements& e = view.solids.elements;
    const Box3& box = view.extents[at(partner)].box;
    const Real reach = view.reach(partner), wide = reach + 2 * e.support[view.solids.bodies[at(owner)].typical];
    const Index first = samples.first[at(owner)];
    const std::size_t count = samples.first[at(owner) + 1] - first;
    std::vector<Vec3> place(count);
    std::vector<std::uint8_t> near(count);
    parallel_for(count, [&](std::size_t k) {
        const Index sample = first + static_cast<Index>(k);
        // Most samples lie with an element that is far away.
        near[k] = holds(box, wide, view.solids.contacts.place[samples.weights.element[samples.weights.begin[sample]]]);
        if (!near[k]) return;
        place[k] = view.place_of(sample);
        near[k] = holds(box, reach, place[k]);
    });
    std::vector<Index> candidates;
    for (std::size_t k = 0; k < count; ++k)
        if (near[k]) candidates.push_back(static_cast<Index>(k));
    std::vector<std::optional<Found>> met(candidates.size());
    parallel_chunks(
        candidates.size(),
        [&](std::size_t begin, std::size_t end, std::size_t) {
            ElementFit fit;
            for (std::size_t k = begin; k < end; ++k)
                met[k] = meet(view, first + candidates[k], place[candidates[k]], partner, fit);
        },
        32);
    for (auto& m : met) {
        if (!m) continue;
        m->explained = explained;
        found.push_back(std::move(*m));
    }
}

Real find_samples_at_wall(const View& view, std::int32_t owner, const Walls& walls, std::size_t wall, Real explained,
                          std::vector<Found>& found) {
    constexpr Real kRoom = Real(1.5);  // a sample's way from its first element over that at rest, without stretch
    const Contacts& c = view.solids.contacts;
    const ContactSamples& samples = c.samples;
    const Wall& of = walls.list[wall];
    const Real margin = kContactMargin * view.extents[at(owner)].width;
    const Real room = kRoom * static_cast<Real>(std::sqrt(std::max(1.0, view.solids.stretch2)));
    const Index first = samples.first[at(owner)];
    const std::size_t count = samples.first[at(owner) + 1] - first;
    std::vector<Real> apart(count);
    std::vector<Found> met(count);
    parallel_chunks(
        count,
        [&](std::size_t begin, std::size_t end, std::size_t) {
            WallMap::Cursor cursor;
            for (std::size_t k = begin; k < end; ++k) {
                const Index sample = first + static_cast<Index>(k),
                            near = samples.weights.element[samples.weights.begin[sample]];
                Vec3 n;
                // Most samples lie with an element that is far away.
                const Real way = room * (samples.rest[sample] - xyz(view.solids.elements.rest[near])).norm();
                apart[k] = of.map.distance(of.to_wall(c.place[near]), n, cursor) - way;
                if (apart[k] > margin) continue;
                const Vec3 x = view.place_of(sample);
                Found& f = met[k];
                apart[k] = f.gap = of.map.distance(of.to_wall(x), n, cursor);
                if (!(f.gap < margin)) continue;
                f.normal = of.turn * n;
                f.area = samples.area[sample] * facing_part(view, sample, f.normal);
                if (!(f.area > 0)) continue;
                f.sample = sample;
                f.place = x;
                f.anchor = of.to_wall(x);
            }
        },
        256);
    Real nearest = std::numeric_limits<Real>::max();
    for (std::size_t k = 0; k < count; ++k) {
        nearest = std::min(nearest, std::max(apart[k], margin));
        if (met[k].sample == kNone) continue;
        met[k].owner = owner;
        met[k].partner = partner_of_wall(wall);
        met[k].explained = explained;
        take_weights(samples, met[k].sample, met[k]);
        found.push_back(std::move(met[k]));
    }
    return nearest;
}

void find_elements(const View& view, std::int32_t owner, std::int32_t partner, Real explained,
                   std::vector<Found>& found) {
    const Contacts& c = view.solids.contacts;
    const Elements& e = view.solids.elements;
    const SolidBody &body = view.solids.bodies[at(owner)], &other = view.solids.bodies[at(partner)];
    const Real width = (view.extents[at(owner)].width + view.extents[at(partner)].width) / 2;
    const std::size_t count = body.size();
    std::vector<std::vector<Index>> near(count);
    parallel_for(count, [&](std::size_t k) {
        const Index i = body.elements[k];
        if (!(solid_share(view, i, width) > 0)) return;
        c.grid[at(partner)].for_each_neighbour(c.place[i], (1 + kContactMargin) * width, [&](Index number, Real) {
            const Index j = other.elements[number];
            if (owner == partner && (j <= i || neighbours(e.bonds, i, j))) return;
            if (solid_share(view, j, width) > 0) near[k].push_back(j);
        });
    });
    for (std::size_t k = 0; k < count; ++k)
        for (const Index j : near[k]) {
            const Index i = body.elements[k];
            const Vec3 between = c.place[i] - c.place[j];
            const Real distance = between.norm();
            if (!(distance > 0)) continue;
            Found f;
            f.owner = owner;
            f.partner = partner;
            f.normal = between / distance;
            f.gap = distance - width * (thinned(view, i, f.normal) + thinned(view, j, f.normal)) / 2;
            f.area = square(width) * std::min(solid_share(view, i, width), solid_share(view, j, width));
            f.explained = explained;
            f.first = i;
            f.second = j;
            // Matter that melts or has frozen anew has contact without friction.
            f.slides = owner == partner && !view.solids.softening.any;
            f.element = {i, j};
            f.weight = {1, -1};
            f.middle = 1;
            found.push_back(std::move(f));
        }
}

}  // namespace thixo
