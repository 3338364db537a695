#include <cmath>

#include "pipeline/base/log.h"
#include "pipeline/base/parallel.h"
#include "pipeline/geometry/point_surfels.h"
#include "sim/bonds/element_fit.h"
#include "sim/contact/contact.h"
#include "sim/contact/narrow.h"

namespace thixo {
namespace {

constexpr double kPerWidth = 3;          // samples along a particle's width
constexpr Real kOnSurface = Real(0.05);  // a sample of a sheet farther off the body lies past its edge, in spacings

double width_of(const SolidBody& body, const Elements& e) {
    return std::cbrt(static_cast<double>(e.volume[body.typical]));
}

/// Places of contact on one body, in the world at time 0.
struct Places {
    std::vector<Vec3> place, normal;
    double area = 0;  // of all samples together [m^2]
};

/// Samples of a shape of the scene, even over its surface.
Places places_on_shape(const Shape& shape, double width, const SurfaceSampling& sampling) {
    const SampledSurface sampled = sample_surface(shape, sampling);
    Places out;
    out.area = sampled.area;
    for (const Vec3& surfel : sampled.surfels.position) {
        const Real off = shape.distance(surfel);
        if (std::abs(off) > kOnSurface * static_cast<Real>(width)) continue;
        // Samples just past an edge are moved onto the body, where nothing lies before it.
        const Vec3 normal = shape.gradient(surfel, static_cast<Real>(width) / 64);
        out.place.push_back(surfel - off * normal);
        out.normal.push_back(normal);
    }
    return out;
}

/// Samples of a shape that surfels bound: its surfels in their order, thinned to the distance of other samples.
Places places_on_surfels(const PointSurfels& points, double width) {
    const SurfelCloud& cloud = points.surfels;
    const Real apart = static_cast<Real>(0.8 * width / kPerWidth);
    PointGrid grid;
    grid.build(cloud.position, apart);
    std::vector<std::uint8_t> selected(cloud.size(), 0);
    Places out;
    out.area = points.area;
    for (std::size_t k = 0; k < cloud.size(); ++k) {
        bool crowded = false;
        grid.for_each_neighbour(cloud.position[k], apart, [&](Index j, Real) {
            crowded = crowded || (selected[j] && cloud.normal[j].dot(cloud.normal[k]) > 0);
        });
        if (crowded) continue;
        selected[k] = 1;
        out.place.push_back(cloud.position[k]);
        out.normal.push_back(cloud.normal[k]);
    }
    return out;
}

/// Appends a body's samples.
void sample_body(std::int32_t number, const Solids& solids, std::uint64_t seed, ContactSamples& samples) {
    const SolidBody& body = solids.bodies[at(number)];
    const Elements& e = solids.elements;
    const double width = width_of(body, e);
    const auto surfels = body.scene_shape ? nullptr : body.shape->node().own_surfels();
    const Places places = surfels ? places_on_surfels(*surfels, width)
                                  : places_on_shape(*body.shape, width, contact_sampling(body, e, seed));
    const std::size_t first = samples.size(), count = places.place.size();
    for (const Vec3& x : places.place) samples.rest.push_back(x - body.origin);
    samples.normal.insert(samples.normal.end(), places.normal.begin(), places.normal.end());
    samples.owner.resize(samples.rest.size(), number);
    samples.area.resize(samples.rest.size(), static_cast<Real>(places.area / static_cast<double>(count)));
    const Real support = e.support[body.typical];
    PointGrid grid;
    grid.build(rest_places(body, e), support);
    const RestPlaces rest{e};
    const Mat3 unturned = Mat3::Identity();
    std::vector<ElementFit> fit(count);
    parallel_for(count, [&](std::size_t k) {
        fit_elements<RestPlaces>({body, e, rest, grid, unturned}, support, samples.rest[first + k], fit[k]);
    });
    for (const ElementFit& f : fit) {
        samples.weights.element.insert(samples.weights.element.end(), f.element.begin(), f.element.end());
        samples.weights.weight.insert(samples.weights.weight.end(), f.weight.begin(), f.weight.end());
        samples.weights.begin.push_back(samples.weights.element.size());
    }
}

/// Appends the old samples of a body.
void copy_samples(const ContactSamples& from, std::int32_t number, ContactSamples& samples) {
    for (Index k = from.first[at(number)]; k < from.first[at(number) + 1]; ++k) {
        samples.owner.push_back(number);
        samples.rest.push_back(from.rest[k]);
        samples.normal.push_back(from.normal[k]);
        samples.area.push_back(from.area[k]);
        for (std::size_t l = from.weights.begin[k]; l < from.weights.begin[k + 1]; ++l) {
            samples.weights.element.push_back(from.weights.element[l]);
            samples.weights.weight.push_back(from.weights.weight[l]);
        }
        samples.weights.begin.push_back(samples.weights.element.size());
    }
}

/// The greatest depth of one body's samples in another's rest shape, both in the world at time 0 [m].
Real deepest(const ContactSamples& samples, std::size_t of, const SolidBody& body, const SolidBody& in) {
    const auto box = in.shape->bounds();
    Real depth = 0;
    for (Index sample = samples.first[of]; sample < samples.first[of + 1]; ++sample) {
        const Vec3 x = samples.rest[sample] + body.origin;
        if (box && ((x.array() < box->lower.array()).any() || (x.array() > box->upper.array()).any())) continue;
        depth = std::max(depth, -in.shape->distance(x));
    }
    return depth;
}

/// Warns of bodies that overlap at the start. They are pushed apart slowly (add_contact_forces), which is seldom
/// wanted.
void warn_of_overlaps(const scene::Scene& scene, const Solids& solids, const ContactSamples& samples) {
    constexpr Real kTold = Real(0.1);  // in particle widths
    const auto source = [&](std::int32_t b) -> const scene::Body& {
        return scene.bodies[at(solids.bodies[at(b)].source)];
    };
    constexpr Real kFar = Real(1e18);
    std::vector<Box3> boxes;
    for (const SolidBody& body : solids.bodies)
        boxes.push_back(body.shape->bounds().value_or(Box3{Vec3::Constant(-kFar), Vec3::Constant(kFar)}));
    for (const auto& [a, b] : touching_pairs(boxes)) {
        const SolidBody &first = solids.bodies[at(a)], &second = solids.bodies[at(b)];
        const Real depth = std::max(deepest(samples, at(a), first, second), deepest(samples, at(b), second, first));
        if (!(depth > kTold * std::cbrt(solids.elements.volume[first.typical]))) continue;
        log_warning("{}: body '{}' starts {:.3g} m deep in body '{}'; they are pushed apart slowly: move one of them",
                    source(b).shape.where, source(b).name, depth, source(a).name);
    }
}

}  // namespace

SurfaceSampling contact_sampling(const SolidBody& body, const Elements& elements, std::uint64_t seed) {
    return {.count = 0, .spacing = width_of(body, elements) / kPerWidth, .seed = seed};
}

ContactSamples sample_bodies(const std::vector<std::uint8_t>& which, std::uint64_t seed, Solids& solids) {
    ContactSamples old = std::move(solids.contacts.samples), &samples = solids.contacts.samples;
    samples = {};
    samples.first.assign(1, 0);
    for (std::size_t b = 0; b < solids.bodies.size(); ++b) {
        const auto number = static_cast<std::int32_t>(b);
        // A single body without walls meets nothing but itself, element by element.
        const bool others = solids.bodies.size() > 1 || solids.contacts.beside_walls;
        const bool meets = others && solids.bodies[b].shape && !solids.bodies[b].empty() && !solids.bodies[b].endless;
        if (meets && which[b])
            sample_body(number, solids, seed, samples);
        else if (meets)
            copy_samples(old, number, samples);
        samples.first.push_back(static_cast<Index>(samples.size()));
    }
    solids.contacts.rates.assign(solids.bodies.size(), {});
    return old;
}

void make_contacts(const scene::Scene& scene, Solids& solids) {
    solids.contacts.beside_walls = !scene.world.boundaries.empty();
    sample_bodies(std::vector<std::uint8_t>(solids.bodies.size(), 1), scene.solver.seed, solids);
    if (solids.bodies.size() > 1) warn_of_overlaps(scene, solids, solids.contacts.samples);
}

}  // namespace thixo
