#include "sim/stage/estimate.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/base/parallel.h"
#include "sim/fracture/crack_parts.h"
#include "sim/sources/emitter.h"
#include "sim/space/scene_shapes.h"
#include "sim/stage/boundary_mesh.h"
#include "sim/stage/setup.h"
#include "sim/stage/shortfalls.h"

namespace thixo {
namespace {

/// Area of a shape's surface [m^2], by cells of the edge `cell` about it, each with the distance d of its middle:
///     sum max(0, 1 - |d|/cell) cell^2
double area_of(const Shape& shape, double spacing) {
    const auto box = shape.bounds();
    if (!box) return 0;
    constexpr double kAlongCube = 32, kAlongAxis = 1e4;  // cells, at most
    const Vec3d size = (box->upper - box->lower).cast<double>();
    // In proportion to the box: long, thin bodies would vanish in cells that only their length decides.
    const double of_cube = std::cbrt(size.cwiseMax(spacing).prod());
    const double cell = std::max({spacing / 2, of_cube / kAlongCube, size.maxCoeff() / kAlongAxis});
    const Vec3d from = box->lower.cast<double>() - Vec3d::Constant(1.5 * cell);
    std::array<std::size_t, 3> n{};
    for (std::size_t a = 0; a < 3; ++a)
        n[a] = static_cast<std::size_t>(std::ceil(size[static_cast<Eigen::Index>(a)] / cell)) + 3;
    const double near = parallel_sum(n[0] * n[1] * n[2], [&](std::size_t k) {
        const Vec3d at(static_cast<double>(k % n[0]) + 0.5, static_cast<double>(k / n[0] % n[1]) + 0.5,
                       static_cast<double>(k / (n[0] * n[1])) + 0.5);
        return std::max(0.0, 1 - std::abs(static_cast<double>(shape.distance((from + cell * at).cast<Real>()))) / cell);
    });
    return near * square(cell);
}

/// A surfel has a square of the spacing as its own; those beyond edges are not counted.
double surfels_of(const scene::Scene& scene, const SolidBody& body) {
    const scene::Body& source = scene.bodies[static_cast<std::size_t>(body.source)];
    const double apart = scene.surface.radius * scene.solver.spacing;
    return source.surfels > 0 ? source.surfels : area_of(*body.shape, scene.solver.spacing) / square(apart);
}
double surfels_on(const scene::Scene& scene, const Simulation& sim) {
    if (!scene.surface.enabled) return 0;
    double surfels = 0;
    for (const SolidBody& body : sim.solids.bodies)
        if (body.shape && !body.empty()) surfels += surfels_of(scene, body);
    return surfels;
}

/// The least area that a plane across the longest side of a body's box shares with it, in the middle half of that side
/// [m^2].
double section_of(const Shape& shape) {
    const auto box = shape.bounds();
    if (!box) return 0;
    constexpr int kSlices = 16, kAcross = 64;
    const Vec3 size = box->upper - box->lower;
    int along = 0;
    size.maxCoeff(&along);
    const int u = (along + 1) % 3, v = (along + 2) % 3;
    const double cell = static_cast<double>(size[u]) * static_cast<double>(size[v]) / square(kAcross);
    double least = 1e300;
    for (int k = 0; k < kSlices; ++k) {
        const double inside = parallel_sum(std::size_t{kAcross} * kAcross, [&](std::size_t c) {
            Vec3 x = box->lower;
            x[along] += size[along] * (Real(0.25) + Real(0.5) * (static_cast<Real>(k) + Real(0.5)) / kSlices);
            x[u] += size[u] * (static_cast<Real>(c % kAcross) + Real(0.5)) / kAcross;
            x[v] += size[v] * (static_cast<Real>(c / kAcross) + Real(0.5)) / kAcross;
            return shape.distance(x) < 0 ? 1.0 : 0.0;
        });
        if (inside > 0) least = std::min(least, inside * cell);
    }
    return least < 1e300 ? least : 0;
}

/// The area of the cracks of a scene body, one side of each [m^2].
double painted_area(const Cracks& cracks, std::int32_t source) {
    const CrackTriangles& t = cracks.triangles;
    return parallel_sum(t.size(), [&](std::size_t k) {
        if (frame_of(cracks, static_cast<Index>(k)) != source) return 0.0;
        const Vec3 &a = cracks.vertex[t.a[k]], &b = cracks.vertex[t.b[k]], &c = cracks.vertex[t.c[k]];
        return 0.5 * static_cast<double>((b - a).cross(c - a).norm());
    });
}

/// The surfels of cracks (Size::cut, Size::shattered).
void count_faces(const scene::Scene& scene, const Simulation& sim, Size& size) {
    if (!scene.surface.enabled) return;
    for (const Breaking& breaking : sim.solids.breaking) {
        const auto body = std::ranges::find(sim.solids.bodies, breaking.source, &SolidBody::source);
        const double volume =
            static_cast<double>(sim.solids.elements.volume[body->typical]) * static_cast<double>(body->size());
        const double area = area_of(breaking.shape, scene.solver.spacing), row = breaking.row;
        // The radius of a surfel is the distance to the next one.
        const double surfel = std::sqrt(area / surfels_of(scene, *body));
        // A triangle has two sides of a row. The discs on each of its faces are about as large as surfels (lay_sheets).
        const double reach = std::sqrt(5.0) / 3 * row, parts = std::ceil(reach / surfel);
        const double per_area = 2 * square(parts) / (square(row) / 2);
        // A cut runs on from what is painted.
        size.cut += per_area * std::max(section_of(breaking.shape), painted_area(sim.solids.cracks, breaking.source));
        // Fronts nearer to each other than one and a half rows meet (crack_events.h).
        size.shattered += per_area * volume / (1.5 * row);
    }
}

}  // namespace

Size final_size(const scene::Scene& scene, const Simulation& at_start) {
    double count = static_cast<double>(at_start.particles.size());
    const double end = (scene.frames.last - scene.frames.first) / scene.frames.fps;
    for (const scene::Emitter& e : scene.emitters) {
        const double area = opening_of(scene, e).area;
        count += flow_seconds(e, end) * flow_rate(e, area) / cube(scene.solver.spacing);
    }
    return {count, static_cast<double>(at_start.embedded.size())};
}

double memory_of(const Size& size) {
    // Bytes per particle: its arrays (150), sweeps and grid (190), neighbours (60 indices of 4), a checkpoint in memory
    // (150); a surfel of a liquid's in five particles. A solid's surfel, with the weights it is moved by, takes 1500.
    constexpr double kProgram = 6e7, kParticle = 730, kSurfel = 1500;
    return kProgram + kParticle * size.particles + kSurfel * (size.surfels + size.cut);
}

Estimate estimate_run(const scene::Scene& in_world) {
    const scene::Scene scene = near_origin(in_world);
    for (const scene::Boundary& b : scene.world.boundaries)
        if (b.visible) require_drawable(scene, b);
    // What emitters release is counted. Only small ones are laid out: one with many sites cannot be too thin for any.
    constexpr double kManySites = 1e5;
    scene::Scene sampled = scene;
    std::erase_if(sampled.emitters, [&](const scene::Emitter& e) {
        return sites_of_opening(opening_of(scene, e).area, scene.solver.spacing) > kManySites;
    });
    const Simulation sim = make_simulation(sampled, SkinSetup::leave_out);
    Size size = final_size(scene, sim);
    size.surfels = surfels_on(scene, sim);
    count_faces(scene, sim, size);
    return {size, expect_shortfalls(sim)};
}

}  // namespace thixo
