#include <cmath>

#include "pipeline/base/log.h"
#include "pipeline/base/parallel.h"
#include "pipeline/geometry/surface_sampling.h"
#include "sim/bonds/element_fit.h"
#include "sim/contact/contact.h"
#include "sim/contact/narrow.h"
#include "sim/state/solids.h"

namespace thixo {
namespace {

constexpr double kPerWidth = 3;          // samples along a particle's width
constexpr Real kOnSurface = Real(0.05);  // samples of sheets that reach past the body's edges are off it, in spacings

void sample_body(std::int32_t number, const Solids& solids, std::uint64_t seed, ContactSamples& s) {
    const SolidBody& body = solids.bodies[static_cast<std::size_t>(number)];
    const Elements& e = solids.elements;
    const Shape& shape = *body.shape;
    const double width = std::cbrt(static_cast<double>(e.volume[body.typical]));
    const SampledSurface sampled = sample_surface(shape, {.count = 0, .spacing = width / kPerWidth, .seed = seed});
    const std::size_t first = s.size();
    for (const Vec3& surfel : sampled.surfels.position) {
        const Real off = shape.distance(surfel);
        if (std::abs(off) > kOnSurface * static_cast<Real>(width)) continue;
        // Those just past an edge come onto it, where nothing is before the body.
        const Vec3 normal = shape.gradient(surfel, static_cast<Real>(width) / 64);
        s.owner.push_back(number);
        s.rest.push_back(surfel - off * normal - body.origin);
        s.normal.push_back(normal);
    }
    s.area.resize(s.size(), static_cast<Real>(sampled.area / static_cast<double>(s.size() - first)));
    const Real support = e.support[body.typical];
    const std::vector<Vec3> place = rest_places(body, e);
    PointGrid grid;
    grid.build(place, support);
    std::vector<ElementFit> fit(s.size() - first);
    parallel_for(fit.size(), [&](std::size_t k) {
        fit_elements(body, e, RestPlaces{e}, grid, Mat3::Identity(), support, s.rest[first + k], fit[k]);
    });
    for (const ElementFit& f : fit) {
        s.weights.element.insert(s.weights.element.end(), f.element.begin(), f.element.end());
        s.weights.weight.insert(s.weights.weight.end(), f.weight.begin(), f.weight.end());
        s.weights.begin.push_back(s.weights.element.size());
    }
}

/// The deepest place of one body's samples in another's shape, both at rest in the world [m].
Real deepest(const ContactSamples& samples, std::size_t of, const SolidBody& body, const SolidBody& in) {
    const auto box = in.shape->bounds();
    Real depth = 0;
    for (Index s = samples.first[of]; s < samples.first[of + 1]; ++s) {
        const Vec3 x = samples.rest[s] + body.origin;
        if (box && ((x.array() < box->lower.array()).any() || (x.array() > box->upper.array()).any())) continue;
        depth = std::max(depth, -in.shape->distance(x));
    }
    return depth;
}

/// Two bodies that start in one another are pushed apart slowly (press_contacts), which is seldom what is wanted.
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

Contacts make_contacts(const scene::Scene& scene, const Solids& solids) {
    Contacts c;
    c.rates.resize(solids.bodies.size());
    c.samples.first.assign(1, 0);
    for (std::size_t b = 0; b < solids.bodies.size(); ++b) {
        // One body alone meets nothing but itself, element by element.
        if (solids.bodies.size() > 1) sample_body(static_cast<std::int32_t>(b), solids, scene.solver.seed, c.samples);
        c.samples.first.push_back(static_cast<Index>(c.samples.size()));
    }
    if (solids.bodies.size() > 1) warn_of_overlaps(scene, solids, c.samples);
    return c;
}

}  // namespace thixo
