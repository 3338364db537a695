#include "pipeline/base/log.h"
#include "pipeline/base/parallel.h"
#include "pipeline/geometry/surface_sampling.h"
#include "sim/scene_shapes.h"
#include "sim/solid/contact.h"
#include "sim/solid/element_fit.h"
#include "sim/solid/solids.h"

namespace thixo {
namespace {

constexpr double kPerWidth = 3;          // samples along a particle's width
constexpr Real kOnSurface = Real(0.05);  // samples of sheets that reach past the body's edges are off it, in spacings

void sample_body(std::int32_t number, const Solids& solids, std::uint64_t seed, Contacts& c) {
    const SolidBody& body = solids.bodies[static_cast<std::size_t>(number)];
    const Elements& e = solids.elements;
    const Shape& shape = c.shape[static_cast<std::size_t>(number)];
    const double width = std::cbrt(static_cast<double>(e.volume[body.typical]));
    const SampledSurface sampled = sample_surface(shape, {.count = 0, .spacing = width / kPerWidth, .seed = seed});
    ContactSamples& s = c.samples;
    const Vec3 origin = c.origin[static_cast<std::size_t>(number)];
    const std::size_t first = s.size();
    for (const Vec3& surfel : sampled.surfels.position) {
        const Real off = shape.distance(surfel);
        if (std::abs(off) > kOnSurface * static_cast<Real>(width)) continue;
        // Those just past an edge come onto it, where nothing is before the body.
        const Vec3 normal = shape.gradient(surfel, static_cast<Real>(width) / 64);
        s.owner.push_back(number);
        s.rest.push_back(surfel - off * normal - origin);
        s.normal.push_back(normal);
    }
    s.area.resize(s.size(), static_cast<Real>(sampled.area / static_cast<double>(s.size() - first)));
    const Real support = e.support[body.typical];
    std::vector<Vec3> place(e.size());
    for (Index i = body.begin; i < body.end; ++i) place[i] = xyz(e.rest[i]);
    PointGrid grid;
    grid.build(std::span(place).subspan(body.begin, body.end - body.begin), support);
    std::vector<ElementFit> fit(s.size() - first);
    parallel_for(fit.size(), [&](std::size_t k) {
        fit_elements(body, e, place, grid, Mat3::Identity(), support, s.rest[first + k], fit[k]);
    });
    for (const ElementFit& f : fit) {
        s.weights.element.insert(s.weights.element.end(), f.element.begin(), f.element.end());
        s.weights.weight.insert(s.weights.weight.end(), f.weight.begin(), f.weight.end());
        s.weights.begin.push_back(s.weights.element.size());
    }
}

/// Two bodies that start in one another are pushed apart slowly (press_contacts), which is seldom what is wanted.
void warn_of_overlaps(const scene::Scene& scene, const Solids& solids, const Contacts& c) {
    constexpr Real kTold = Real(0.1);  // in particle widths
    const auto source = [&](std::size_t b) -> const scene::Body& {
        return scene.bodies[static_cast<std::size_t>(solids.bodies[b].body)];
    };
    const std::size_t count = solids.bodies.size();
    for (std::size_t a = 0; a < count; ++a)
        for (std::size_t b = a + 1; b < count; ++b) {
            const auto deepest = [&](std::size_t of, std::size_t in) {
                const auto box = c.shape[in].bounds();
                Real depth = 0;
                for (Index s = c.samples.first[of]; s < c.samples.first[of + 1]; ++s) {
                    const Vec3 x = c.samples.rest[s] + c.origin[of];
                    if (box && ((x.array() < box->lower.array()).any() || (x.array() > box->upper.array()).any()))
                        continue;
                    depth = std::max(depth, -c.shape[in].distance(x));
                }
                return depth;
            };
            const Real depth = std::max(deepest(a, b), deepest(b, a));
            if (!(depth > kTold * std::cbrt(solids.elements.volume[solids.bodies[a].typical]))) continue;
            log_warning(
                "{}: body '{}' starts {:.3g} m deep in body '{}'; they are pushed apart slowly: move one of them",
                source(b).shape.where, source(b).name, depth, source(a).name);
        }
}

}  // namespace

HangTogether hang_together_in_shapes(const Solids& solids) {
    constexpr Real kOutside = Real(0.25);
    return [&solids](std::size_t b, Index i, Index j) {
        const Elements& e = solids.elements;
        if (solids.phases.any && solids.phases.refrozen[b]) return true;
        const Vec3 from = xyz(e.rest[i]), way = xyz(e.rest[j]) - from;
        const Real outside = kOutside * std::cbrt(e.volume[i]);
        // Distance changes by no more than the way does: most lie too deep for that.
        if (e.depth[i] + e.depth[j] + 2 * outside >= way.norm()) return true;
        const Shape& shape = solids.contacts.shape[b];
        for (const Real part : {Real(0.5), Real(0.25), Real(0.75)})
            if (shape.distance(from + part * way + solids.contacts.origin[b]) > outside) return false;
        return true;
    };
}

Contacts make_contacts(const scene::Scene& scene, const Solids& solids) {
    Contacts c;
    c.rates.resize(solids.bodies.size());
    for (const SolidBody& body : solids.bodies) {
        c.shape.push_back(make_shape(scene, scene.bodies[static_cast<std::size_t>(body.body)].shape));
        c.origin.push_back(body.place.cast<Real>());
    }
    c.samples.first.assign(1, 0);
    for (std::size_t b = 0; b < solids.bodies.size(); ++b) {
        // One body alone meets nothing but itself, element by element.
        if (solids.bodies.size() > 1) sample_body(static_cast<std::int32_t>(b), solids, scene.solver.seed, c);
        c.samples.first.push_back(static_cast<Index>(c.samples.size()));
    }
    warn_of_overlaps(scene, solids, c);
    return c;
}

}  // namespace thixo
