#include "sim/solid/embedded_surface.h"

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/kernels.h"
#include "pipeline/geometry/surface_sampling.h"
#include "sim/scene_shapes.h"

namespace thixo {
namespace {

constexpr int kEnough = 4;  // elements whose weights a surfel needs at least

std::vector<Vec3> places(const SolidBody& body, const Elements& e) {
    std::vector<Vec3> place;
    for (Index i = body.begin; i < body.end; ++i) place.push_back(xyz(e.rest[i]));
    return place;
}

/// The elements' support, or what reaches a few of them from all over the disc.
Real support_at(const PointGrid& grid, const Vec3& m, Real disc, Real usual) {
    std::vector<std::pair<Real, Index>> near;
    grid.nearest(m, kEnough, std::numeric_limits<Real>::max(), near);
    return std::max(usual, Real(1.2) * (std::sqrt(near.back().first) + disc));
}

struct Carried {
    Vec3 shift, velocity;
};
/// u and v at the place m of the material frame.
Carried carried(const PointGrid& grid, const SolidBody& body, const Solids& s, const Vec3& m, Real support) {
    const Poly6 w(support);
    Real weight = 0;
    Carried sum{Vec3::Zero(), Vec3::Zero()};
    const Elements& e = s.elements;
    grid.for_each_neighbour(m, support, [&](Index near, Real r2) {
        const Index j = body.begin + near;
        const Real a = w.value(r2);
        weight += a;
        sum.shift += a * (xyz(e.displacement[j]) + s.gradients[j] * (m - xyz(e.rest[j])));
        sum.velocity += a * xyz(e.velocity[j]);
    });
    return {sum.shift / weight, sum.velocity / weight};
}

}  // namespace

EmbeddedSurface make_embedded_surface(const scene::Scene& scene, const Solids& solids) {
    EmbeddedSurface out;
    for (std::size_t b = 0; b < solids.bodies.size(); ++b) {
        const SolidBody& body = solids.bodies[b];
        const scene::Body& source = scene.bodies[static_cast<std::size_t>(body.body)];
        SurfaceSampling sampling{.count = static_cast<std::size_t>(source.surfels), .seed = scene.solver.seed};
        if (source.surfels == 0) sampling.spacing = scene.surface.radius * scene.solver.spacing;
        const SampledSurface sampled = sample_surface(make_shape(scene, source.shape), sampling);
        const std::vector<Vec3> place = places(body, solids.elements);
        const Real usual = solids.elements.support[body.begin];
        // The grid's cells must hold the widest support.
        PointGrid near;
        near.build(place, usual);
        const Vec3 centre = body.place.cast<Real>();
        Real widest = usual;
        const SurfelCloud& cloud = sampled.surfels;
        for (std::size_t k = 0; k < cloud.size(); ++k) {
            const Vec3 m = cloud.position[k] - centre;
            const Real disc = std::max(cloud.axis1[k].norm(), cloud.axis2[k].norm());
            out.rest.position.push_back(m);
            out.rest.axis1.push_back(cloud.axis1[k]);
            out.rest.axis2.push_back(cloud.axis2[k]);
            out.rest.normal.push_back(cloud.normal[k]);
            out.owner.push_back(static_cast<std::int32_t>(b));
            out.sheet.push_back(sampled.sheet[k]);
            out.first.push_back(cloud.position[k]);
            out.support.push_back(support_at(near, m, disc, usual));
            out.temperature.push_back(static_cast<Real>(source.temperature));
            widest = std::max(widest, out.support.back());
        }
        out.trim.push_back(sampled.trim ? std::optional(trim_node(*sampled.trim)) : std::nullopt);
        out.grid.emplace_back().build(place, widest);
    }
    return out;
}

void displace_embedded(const EmbeddedSurface& embedded, Solids& solids, SurfaceState& surface) {
    const std::size_t n = embedded.size();
    find_gradients(solids.elements, solids.gradients);
    for_each_array(surface, [&]<class T>(const char*, std::vector<T>& array) {
        if constexpr (std::is_same_v<T, Vec3>)
            array.resize(n, Vec3::Zero());
        else
            array.resize(n);
    });
    surface.rest = embedded.first;
    surface.temperature = embedded.temperature;
    surface.next_id = static_cast<std::int64_t>(n);
    parallel_for(n, [&](std::size_t i) {
        const auto owner = static_cast<std::size_t>(embedded.owner[i]);
        const SolidBody& body = solids.bodies[owner];
        const PointGrid& grid = embedded.grid[owner];
        const Real h = embedded.support[i];
        const Mat3 turn = body.turn.cast<Real>();
        const Vec3 &m = embedded.rest.position[i], &a = embedded.rest.axis1[i], &b = embedded.rest.axis2[i];
        const Carried at = carried(grid, body, solids, m, h);
        const Vec3 t1 = turn * (a + carried(grid, body, solids, m + a, h).shift - at.shift);
        const Vec3 t2 = turn * (b + carried(grid, body, solids, m + b, h).shift - at.shift);
        surface.surfels.position[i] = (body.turn * (m + at.shift).cast<double>() + body.place).cast<Real>();
        surface.surfels.axis1[i] = t1;
        surface.surfels.axis2[i] = t2;
        const Vec3 n_now = t1.cross(t2);
        const Real size = n_now.norm();
        surface.surfels.normal[i] = size > 0 ? Vec3(n_now / size) : Vec3(turn * embedded.rest.normal[i]);
        surface.velocity[i] = turn * at.velocity;
        surface.id[i] = static_cast<std::int64_t>(i);
        surface.body[i] = body.body;
    });
}

}  // namespace thixo
