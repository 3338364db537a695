#include "sim/solid/solid_setup.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/geometry/point_grid.h"
#include "sim/scene_shapes.h"
#include "sim/solid/rest_shape.h"
#include "sim/solid/stable_step.h"

namespace thixo {
namespace {

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

/// Bodies are sampled finest at the surface; cells there are cut to all sizes, of which a typical one is the lattice's.
void choose_examples(const Elements& e, const Smoothing& smoothing, SolidBody& body) {
    const Real lattice = cube(smoothing.spacing / smoothing.support);
    const auto off = [&](Index i) { return std::abs(std::log(e.volume[i] / (lattice * cube(e.support[i])))); };
    body.typical = body.lightest = body.begin;
    for (Index i = body.begin + 1; i < body.end; ++i) {
        if (e.mass[i] < e.mass[body.lightest]) body.lightest = i;
        const Index best = body.typical;
        if (e.support[i] < e.support[best] || (e.support[i] == e.support[best] && off(i) < off(best))) body.typical = i;
    }
}

void add_body(const scene::Scene& scene, std::int32_t number, const Smoothing& smoothing, const Particles& particles,
              Solids& s) {
    const scene::Body& source = scene.bodies[static_cast<std::size_t>(number)];
    const auto material = std::ranges::find(scene.materials, source.material, &scene::Material::name);
    if (material == scene.materials.end() || !material->elastic.solid()) return;
    const std::vector<Index> order = elements_in_order(particles, number, smoothing.support);
    if (order.empty()) return;
    Elements& e = s.elements;
    SolidBody body{.body = number, .material = particles.material[order[0]], .begin = static_cast<Index>(e.size())};
    Vec3d centre(0, 0, 0);
    double mass = 0;
    for (const Index k : order) {
        centre += static_cast<double>(particles.mass[k]) * particles.position[k].cast<double>();
        mass += static_cast<double>(particles.mass[k]);
    }
    centre /= mass;
    body.place = centre;
    const Shape shape = make_shape(scene, scene.bodies[static_cast<std::size_t>(number)].shape);
    for (const Index k : order) {
        e.id.push_back(particles.id[k]);
        e.owner.push_back(static_cast<std::int32_t>(s.bodies.size()));
        e.rest.push_back(quad((particles.position[k].cast<double>() - centre).cast<Real>()));
        e.mass.push_back(particles.mass[k]);
        e.volume.push_back(particles.rest_volume[k]);
        e.support.push_back(particles.has.spacing ? smoothing.support * (particles.spacing[k] / smoothing.spacing)
                                                  : smoothing.support);
        e.depth.push_back(std::max(-shape.distance(particles.position[k]), Real(0)));
        e.displacement.push_back(quad(Vec3::Zero()));
        e.velocity.push_back(quad(particles.velocity[k]));
        e.acceleration.push_back(Vec3::Zero());
        e.plastic.push_back({});
        const auto id = static_cast<std::size_t>(particles.id[k]);
        if (s.element_of.size() <= id) s.element_of.resize(id + 1, kNone);
        s.element_of[id] = static_cast<Index>(e.size() - 1);
    }
    body.end = static_cast<Index>(e.size());
    choose_examples(e, smoothing, body);
    s.bodies.push_back(body);
}

Grip make_grip(const scene::Scene& scene, const scene::Handle& handle, const Solids& s) {
    Grip grip;
    grip.motion = motion_of(handle.motion);
    grip.force = handle.force;
    grip.start = handle.start;
    grip.stop = handle.stop;
    const Shape region = make_shape(scene, handle.region);
    for (const SolidBody& body : s.bodies) {
        if (scene.bodies[static_cast<std::size_t>(body.body)].name != handle.body) continue;
        for (Index i = body.begin; i < body.end; ++i) {
            const Vec3 x = (xyz(s.elements.rest[i]).cast<double>() + body.place).cast<Real>();
            if (region.distance(x) > 0) continue;
            grip.elements.push_back(i);
            grip.mass += static_cast<double>(s.elements.mass[i]);
        }
    }
    if (grip.elements.empty())
        throw InputError(
            "{}: handle '{}' holds no particle of body '{}'; move its region to where the body is, or enlarge it",
            handle.region.where, handle.name, handle.body);
    return grip;
}

}  // namespace

Solids make_solids(const scene::Scene& scene, const Smoothing& smoothing, const Particles& particles) {
    Solids s;
    for (std::size_t b = 0; b < scene.bodies.size(); ++b)
        add_body(scene, static_cast<std::int32_t>(b), smoothing, particles, s);
    if (s.empty()) return s;
    if (scene.handles.size() > 255)
        throw InputError("the scene has {} handles; 255 are possible", scene.handles.size());
    s.contacts = make_contacts(scene, s);
    find_rest_neighbours(s.bodies, s.elements, hang_together_in_shapes(s));
    measure_moments(s.elements);
    for (const scene::Handle& h : scene.handles) s.grips.push_back(make_grip(scene, h, s));
    return s;
}

}  // namespace thixo
