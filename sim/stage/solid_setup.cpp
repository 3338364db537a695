#include "sim/stage/solid_setup.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/base/log.h"
#include "pipeline/base/parallel.h"
#include "pipeline/geometry/match_moments.h"
#include "pipeline/geometry/point_grid.h"
#include "sim/bonds/members.h"
#include "sim/bonds/rest_shape.h"
#include "sim/contact/contact.h"
#include "sim/solid/stable_step.h"
#include "sim/space/endless.h"
#include "sim/space/scene_shapes.h"
#include "sim/surface/skin_sampling.h"

namespace thixo {
namespace {

constexpr double kRounding = 2e-5;  // of places in a body, in its sizes
constexpr double kCoarse = 0.5;     // part of the right change of volumes: below it bending is several per cent off
constexpr double kSlender = 0.1;    // second moment across over that along a body that bends
constexpr double kThread = 1e-9;    // of the largest second moment: the least that a body without extent is given

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

void add_body(const scene::Scene& scene, std::int32_t number, const Smoothing& smoothing, const Periodic& periodic,
              const Particles& particles, Solids& s) {
    const scene::Body& source = scene.bodies[static_cast<std::size_t>(number)];
    const auto material = std::ranges::find(scene.materials, source.material, &scene::Material::name);
    if (material == scene.materials.end() || !material->elastic.solid()) return;
    const std::vector<Index> order = elements_in_order(particles, number, smoothing.support);
    if (order.empty()) return;
    Elements& e = s.elements;
    SolidBody body{.id = number, .source = number, .frame = number, .material = particles.material[order[0]]};
    Vec3d centre(0, 0, 0);
    double mass = 0;
    for (const Index k : order) {
        centre += static_cast<double>(particles.mass[k]) * particles.position[k].cast<double>();
        mass += static_cast<double>(particles.mass[k]);
    }
    centre /= mass;
    body.place = centre;
    body.origin = centre.cast<Real>();
    body.endless = periodic.any();
    body.shape = make_shape(scene, source.shape);
    if (body.endless) body.shape = endless(*body.shape, periodic);
    for (const Index k : order) {
        const Index i = append_element(e, particles.id[k], static_cast<std::int32_t>(s.bodies.size()));
        e.rest[i] = quad((particles.position[k].cast<double>() - centre).cast<Real>());
        e.mass[i] = particles.mass[k];
        e.volume[i] = e.quadrature[i] = particles.rest_volume[k];
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

/// What the strain of an element stands for in a body that bends: the moments by which it adds to the body's stiffness.
/// In the field u_a = x_a x_b, matter along axis a is strained by x_b. The stencil finds
///     H_aa = x_b + sum_j w_ij (A+ r)_a r_a r_b
/// Inside, the sum is zero. At a surface it sees neighbours on one side alone, and stands for a place a third of a
/// spacing deeper. The second moments of b and c are means over the axes a across both. How far the body reaches
/// along a weighs them, for it bends along its long sides.
PointMoments moments_of_strain(const Elements& e, Index i, const Mat3d& axes, const Vec3d& reach2) {
    const Mat3d inverse = axes.transpose() * matrix(e.bonds.moment[i].inverse).cast<double>() * axes;
    const Vec3d x = axes.transpose() * xyz(e.rest[i]).cast<double>();
    Mat3d place = x.transpose().replicate<3, 1>();  // row a: x_b as axis a finds it
    for (std::size_t k = e.bonds.begin[i]; k < e.bonds.begin[i + 1]; ++k) {
        const Vec3d r = axes.transpose() * bond_vector(e, i, k).cast<Real>().cast<double>();
        place += static_cast<double>(e.bonds.weight[k]) * (inverse * r).cwiseProduct(r) * r.transpose();
    }
    PointMoments out;
    for (int b = 0; b < 3; ++b)
        for (int c = 0; c < 3; ++c) {
            double weights = 0;
            for (int a = 0; a < 3; ++a) {
                if (a == b || a == c) continue;
                weights += reach2[a];
                out.second(b, c) += reach2[a] * place(a, b) * place(a, c);
                if (b == c) out.first[b] += reach2[a] * place(a, b);
            }
            out.second(b, c) /= weights;
            if (b == c) out.first[b] /= weights;
        }
    return {axes * out.first, axes * out.second * axes.transpose(),
            outer_freedom(static_cast<double>(e.depth[i] / std::cbrt(e.volume[i])))};
}

/// Sets the volumes by which elements integrate stress: with them a body is as stiff in bending as its shape. By the
/// volumes of matter a plate of n layers is too soft by about 3.4/n^2. Matter that melts keeps its own volumes, for its stencils do not
/// stay.
void weigh_elements(const scene::Scene& scene, const Periodic& periodic, Solids& s) {
    Elements& e = s.elements;
    const Mat3d section = onto_section(periodic);
    for (const SolidBody& body : s.bodies) {
        const scene::Body& source = scene.bodies[static_cast<std::size_t>(body.source)];
        const auto material = std::ranges::find(scene.materials, source.material, &scene::Material::name);
        if (material->melting.any()) continue;
        const std::size_t count = body.elements.size();
        ShapeMoments shape;
        std::vector<Real> volume(count);
        for (std::size_t k = 0; k < count; ++k) {
            const Index i = body.elements[k];
            const double v = static_cast<double>(volume[k] = e.volume[i]);
            const Vec3d m = section * xyz(e.rest[i]).cast<double>();
            shape += {v, v * m, v * m * m.transpose()};
        }
        const Eigen::SelfAdjointEigenSolver<Mat3d> principal(shape.second);
        const Vec3d reach2 = principal.eigenvalues().cwiseMax(kThread * principal.eigenvalues().maxCoeff());
        std::vector<PointMoments> points(count);
        parallel_for(count, [&](std::size_t k) {
            points[k] = moments_of_strain(e, body.elements[k], principal.eigenvectors(), reach2);
            points[k].first = section * points[k].first;
            points[k].second = section * points[k].second * section;
        });
        const double part = match_moments(points, shape, volume);
        // An endless body has no extent along periodic axes, and does not bend about others.
        const double least = reach2[std::lround(3 - section.trace())];
        if (part < kCoarse && least < kSlender * reach2.maxCoeff())
            log_warning("{}: body '{}' is so few particles thick that it bends too easily; lower solver.spacing",
                        source.shape.where, source.name);
        for (std::size_t k = 0; k < count; ++k) e.quadrature[body.elements[k]] = volume[k];
    }
}

}  // namespace

Solids make_solids(const scene::Scene& scene, const Smoothing& smoothing, const Periodic& periodic,
                   const Particles& particles) {
    Solids s;
    s.elements.hardens =
        std::ranges::any_of(scene.materials, [](const scene::Material& m) { return m.elastic.hardening > 0; });
    s.elements.breaks = std::ranges::any_of(scene.bodies, [&](const scene::Body& body) {
        const auto material = std::ranges::find(scene.materials, body.material, &scene::Material::name);
        const bool cut = std::ranges::find(scene.blades, body.name, &scene::Blade::body) != scene.blades.end();
        return material != scene.materials.end() && material->elastic.solid() && (material->fracture.any() || cut);
    });
    for (std::size_t b = 0; b < scene.bodies.size(); ++b)
        add_body(scene, static_cast<std::int32_t>(b), smoothing, periodic, particles, s);
    if (s.empty()) return s;
    if (scene.handles.size() > 255)
        throw InputError("the scene has {} handles; 255 are possible", scene.handles.size());
    s.next_body = static_cast<std::int32_t>(scene.bodies.size() + scene.emitters.size());
    make_contacts(scene, s);
    find_rest_neighbours(s.bodies, s.elements, hang_together_in_shapes(s), periodic);
    measure_moments(s.elements);
    weigh_elements(scene, periodic, s);
    for (const scene::Handle& h : scene.handles) s.handles.push_back(make_handle(scene, h, s));
    return s;
}

}  // namespace thixo
