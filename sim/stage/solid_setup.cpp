#include "sim/stage/solid_setup.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/geometry/point_grid.h"
#include "sim/bonds/members.h"
#include "sim/bonds/rest_shape.h"
#include "sim/contact/contact.h"
#include "sim/solid/stable_step.h"
#include "sim/space/scene_shapes.h"
#include "sim/surface/skin_sampling.h"

namespace thixo {
namespace {

constexpr double kRounding = 2e-5;  // of places in a body, in its sizes

/// Particles of one body in the order of their elements.
std::vector<Index> elements_in_order(const Particles& particles, std::int32_t body, Real support) {
    std::vector<Index> members;
    std::vector<Vec3> place;
    std::vector<std::int64_t> id;
    for (Index k = 0; k < particles.size(); ++k) {
        if (particles.body[k] != body) continue;
        members.push_back(k);
        place.push_back(particles.position[k]);
        id.push_back(particles.id[k]);
    }
    std::vector<Index> order = PointGrid::sort_order(place, id, support);
    for (Index& k : order) k = members[k];
    return order;
}

/// Throws InputError where surfels or contact samples would find no surface on the body: it is too thin for them. Only
/// thin bodies are looked at, whose elements all lie near the surface.
void refuse_thin(const scene::Scene& scene, const scene::Body& source, const SolidBody& body, const Elements& e) {
    const auto box = body.shape->bounds();
    if (!box) return;
    const SurfaceSampling skin = skin_sampling(scene, source);
    const double size = static_cast<double>((box->upper - box->lower).norm());
    // Of so many surfels, at least: no surface in the box is larger than two squares of its diagonal.
    const double apart = skin.count > 0 ? size * std::sqrt(2 / static_cast<double>(skin.count)) : skin.spacing;
    double deepest = 0;
    for (const Index i : body.elements) deepest = std::max(deepest, static_cast<double>(e.depth[i]));
    if (deepest > kThinnest * std::max(apart, scene.solver.spacing) + kRounding * size) return;
    if (scene.surface.enabled) sample_surface(*body.shape, skin);
    if (scene.bodies.size() > 1) sample_surface(*body.shape, contact_sampling(body, e, scene.solver.seed));
}

void add_body(const scene::Scene& scene, std::int32_t number, const Smoothing& smoothing, const Particles& particles,
              Solids& s) {
    const scene::Body& source = scene.bodies[static_cast<std::size_t>(number)];
    const auto material = std::ranges::find(scene.materials, source.material, &scene::Material::name);
    if (material == scene.materials.end() || !material->elastic.solid()) return;
    const std::vector<Index> order = elements_in_order(particles, number, smoothing.support);
    if (order.empty()) return;
    Elements& e = s.elements;
    SolidBody body{.id = number, .source = number, .material = particles.material[order[0]]};
    Vec3d centre(0, 0, 0);
    double mass = 0;
    for (const Index k : order) {
        centre += static_cast<double>(particles.mass[k]) * particles.position[k].cast<double>();
        mass += static_cast<double>(particles.mass[k]);
    }
    centre /= mass;
    body.place = centre;
    body.origin = centre.cast<Real>();
    body.shape = make_shape(scene, source.shape);
    for (const Index k : order) {
        const Index i = append_element(e, particles.id[k], static_cast<std::int32_t>(s.bodies.size()));
        e.rest[i] = quad((particles.position[k].cast<double>() - centre).cast<Real>());
        e.mass[i] = particles.mass[k];
        e.volume[i] = particles.rest_volume[k];
        e.support[i] =
            particles.has.spacing ? smoothing.support * (particles.spacing[k] / smoothing.spacing) : smoothing.support;
        e.depth[i] = std::max(-body.shape->distance(particles.position[k]), Real(0));
        e.velocity[i] = quad(particles.velocity[k]);
        body.elements.push_back(i);
        number_element(particles.id[k], i, s);
    }
    choose_examples(e, smoothing, body);
    named_in_scene(source.shape, "body", source.name, [&] { refuse_thin(scene, source, body, e); });
    s.bodies.push_back(std::move(body));
}

Handle make_handle(const scene::Scene& scene, const scene::Handle& given, const Solids& s) {
    Handle handle;
    handle.motion = motion_of(scene, given.motion);
    handle.force = given.force;
    handle.start = given.start;
    handle.stop = given.stop;
    const Shape region = make_shape(scene, given.region);
    for (const SolidBody& body : s.bodies) {
        if (scene.bodies[static_cast<std::size_t>(body.source)].name != given.body) continue;
        for (const Index i : body.elements) {
            const Vec3 x = (xyz(s.elements.rest[i]).cast<double>() + body.place).cast<Real>();
            if (region.distance(x) > 0) continue;
            handle.elements.push_back(i);
            handle.mass += static_cast<double>(s.elements.mass[i]);
        }
    }
    if (handle.elements.empty())
        throw InputError(
            "{}: handle '{}' holds no particle of body '{}'; move its region to where the body is, or enlarge it",
            given.region.where, given.name, given.body);
    return handle;
}

}  // namespace

Solids make_solids(const scene::Scene& scene, const Smoothing& smoothing, const Particles& particles) {
    Solids s;
    s.elements.hardens =
        std::ranges::any_of(scene.materials, [](const scene::Material& m) { return m.elastic.hardening > 0; });
    s.elements.breaks = std::ranges::any_of(scene.bodies, [&](const scene::Body& body) {
        const auto material = std::ranges::find(scene.materials, body.material, &scene::Material::name);
        const bool cut = std::ranges::find(scene.blades, body.name, &scene::Blade::body) != scene.blades.end();
        return material != scene.materials.end() && material->elastic.solid() && (material->fracture.any() || cut);
    });
    for (std::size_t b = 0; b < scene.bodies.size(); ++b)
        add_body(scene, static_cast<std::int32_t>(b), smoothing, particles, s);
    if (s.empty()) return s;
    if (scene.handles.size() > 255)
        throw InputError("the scene has {} handles; 255 are possible", scene.handles.size());
    s.next_body = static_cast<std::int32_t>(scene.bodies.size() + scene.emitters.size());
    make_contacts(scene, s);
    find_rest_neighbours(s.bodies, s.elements, hang_together_in_shapes(s));
    measure_moments(s.elements);
    for (const scene::Handle& h : scene.handles) s.handles.push_back(make_handle(scene, h, s));
    return s;
}

}  // namespace thixo
