#include "sim/stage/frame_output.h"

#include <algorithm>

#include "pipeline/base/log.h"
#include "pipeline/base/parallel.h"
#include "pipeline/contract/scene_walk.h"
#include "pipeline/geometry/mesh_io.h"
#include "sim/fracture/fragments.h"
#include "sim/fracture/shown.h"
#include "sim/loop/step.h"
#include "sim/space/scene_shapes.h"
#include "sim/stage/boundary_mesh.h"
#include "sim/stage/shortfalls.h"
#include "sim/surface/volume.h"

namespace thixo {
namespace {

template <class T, class F>
std::vector<T> collect(std::size_t n, F&& f) {
    std::vector<T> out(n);
    parallel_for(n, [&](std::size_t i) { out[i] = f(i); });
    return out;
}
std::vector<Vec3f> floats(const std::vector<Vec3>& a) {
    return collect<Vec3f>(a.size(), [&](std::size_t i) -> Vec3f { return a[i].template cast<float>(); });
}
template <std::floating_point T>
std::vector<float> floats(const std::vector<T>& a) {
    return collect<float>(a.size(), [&](std::size_t i) { return static_cast<float>(a[i]); });
}

/// How near matter is to breaking: of scenes where some can break or be cut.
void add_stress(const Simulation& sim, PointSet& points) {
    if (!sim.solids.elements.breaks) return;
    const ShownStress shown = shown_stress(sim.solids);
    const auto add = [&](const char* name, const std::vector<float>& values) {
        points.add(name, collect<float>(points.count, [&](std::size_t i) {
                       const Index e = sim.solids.element(sim.particles.id[i]);
                       return e == kNone ? 0.0f : values[e];
                   }));
    };
    add("load", shown.load);
    add("von_mises", shown.von_mises);
}

PointSet particle_points(const Simulation& sim) {
    const Particles& p = sim.particles;
    const std::size_t n = p.size();
    PointSet points;
    points.count = n;
    points.origin = sim.problem.scene.origin;
    points.add("P", floats(p.position));
    points.add("v", collect<Vec3f>(n, [&](std::size_t i) {
                   const Quad& v = sim.sweep.motion[i];
                   return Vec3f(static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z));
               }));
    points.add("id", p.id);
    const Real spacing = sim.problem.smoothing.spacing;
    points.add("pscale", collect<float>(n, [&](std::size_t i) {
                   return static_cast<float>((p.has.spacing ? p.spacing[i] : spacing) / 2);
               }));
    points.add("density", floats(p.density));
    points.add("pressure",
               collect<float>(n, [&](std::size_t i) { return static_cast<float>(shown_pressure(sim, i)); }));
    points.add("temperature", floats(p.temperature));
    points.add("body", p.body);
    points.add("material", p.material);
    points.add("kind", collect<std::int32_t>(n, [&](std::size_t i) { return is_elastic(p.phase[i]) ? 1 : 0; }));
    if (sim.solids.softening.any) points.add("phase", floats(p.melt));  // 0 solid, 1 liquid
    add_stress(sim, points);
    return points;
}

PointSet surfel_points(const Simulation& sim) {
    const SurfaceState& surface = sim.surface;
    PointSet points;
    points.count = surface.size();
    points.origin = sim.problem.scene.origin;
    points.add("P", floats(surface.surfels.position));
    points.add("N", floats(surface.surfels.normal));
    points.add("t1", floats(surface.surfels.axis1));
    points.add("t2", floats(surface.surfels.axis2));
    points.add("id", surface.id);
    points.add(
        "pscale", collect<float>(surface.size(), [&](std::size_t i) {
            return static_cast<float>(std::max(surface.surfels.axis1[i].norm(), surface.surfels.axis2[i].norm()));
        }));
    points.add("body", surface.body);
    points.add("rest", floats(surface.rest));
    points.add("v", floats(surface.velocity));
    points.add("temperature", floats(surface.temperature));
    const EmbeddedSurface& embedded = sim.embedded;
    if (embedded.size() > 0)
        points.add("sheet", collect<std::int32_t>(surface.size(), [&](std::size_t i) {
                       return i < sim.embedded_source.size() ? embedded.sheet[sim.embedded_source[i]] : 0;
                   }));
    return points;
}

/// The scene's body that a body of the frame comes from; none of an emitter's.
std::optional<std::size_t> source_of(const Simulation& sim, std::int32_t body) {
    const std::size_t bodies = sim.problem.scene.bodies.size();
    if (static_cast<std::size_t>(body) < bodies) return static_cast<std::size_t>(body);
    const auto piece = std::ranges::find(sim.solids.bodies, body, &SolidBody::id);
    if (piece == sim.solids.bodies.end() || piece->source < 0) return std::nullopt;
    return static_cast<std::size_t>(piece->source);
}

void add_colours(const Simulation& sim, const ColouredShapes& coloured, PointSet& points) {
    const Vec3f none(-1, -1, -1);
    if (std::ranges::none_of(coloured, [](const auto& shape) { return shape.has_value(); })) return;
    points.add("Cd", collect<Vec3f>(points.count, [&](std::size_t i) -> Vec3f {
                   const auto body = source_of(sim, sim.surface.body[i]);
                   if (!body || !coloured[*body]) return none;
                   const std::optional<Vec3f> colour = coloured[*body]->node().colour(sim.surface.rest[i]);
                   // Interpolation may leave a zero below zero, which would stand for none.
                   return colour ? Vec3f(colour->cwiseMax(0.0f)) : none;
               }));
}

/// Discs reach past the lips of a crack by about their radius: beyond three of these it trims nothing [m].
float reach_of_cracks(const Solids& solids, const SolidBody& body) {
    const auto own = std::ranges::find(solids.breaking, body.frame, &Breaking::frame);
    return own == solids.breaking.end() ? 0 : static_cast<float>(3 * own->surfel);
}

std::vector<FrameBody> frame_bodies(const Simulation& sim) {
    const scene::Scene& scene = sim.problem.scene;
    std::vector<FrameBody> bodies;
    const auto add = [&](const std::string& name, const std::string& material, int parent) {
        bodies.push_back({.id = static_cast<int>(bodies.size()), .parent = parent, .name = name, .material = material});
    };
    for (const scene::Body& b : scene.bodies) add(b.name, b.material, -1);
    for (const scene::Emitter& e : scene.emitters) add(e.name, e.material, -1);
    std::vector<std::optional<TrimNode>> of_source(scene.bodies.size());
    const std::vector<std::vector<std::int32_t>> sheets = sheets_of(sim.embedded, sim.solids.bodies.size());
    for (std::size_t b = 0; b < sim.solids.bodies.size(); ++b) {
        const SolidBody& body = sim.solids.bodies[b];
        if (!body.shaped()) continue;
        const auto source = static_cast<std::size_t>(body.source);
        if (body.parent < 0)
            of_source[source] = b < sim.embedded.trim.size() ? sim.embedded.trim[b] : std::nullopt;
        else
            add(scene.bodies[source].name, scene.bodies[source].material, body.parent);
        if (body.skin == Skin::embedded)
            bodies[static_cast<std::size_t>(body.id)].trim =
                trim_of_fragment(body.frame == body.source ? of_source[source] : std::nullopt, body, sheets[b],
                                 reach_of_cracks(sim.solids, body));
    }
    return bodies;
}

FrameObstacle frame_obstacle(const DrawnBoundary& b, const Vec3d& origin, double time) {
    FrameObstacle o;
    o.name = b.name;
    o.look = b.look;
    o.asset = b.asset;
    const RigidPose pose = b.motion.pose(time);
    const RigidVelocity velocity = b.motion.velocity(time);
    const Mat3d turn = pose.rotation.toRotationMatrix();
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) o.transform[static_cast<std::size_t>(4 * r + c)] = turn(r, c);
        o.transform[static_cast<std::size_t>(4 * r + 3)] = origin[r] + pose.translation[r];
        o.velocity[static_cast<std::size_t>(r)] = velocity.linear[r];
        o.angular_velocity[static_cast<std::size_t>(r)] = velocity.angular[r];
    }
    return o;
}

std::vector<FrameFront> frame_fronts(const Simulation& sim) {
    std::vector<FrameFront> fronts;
    for (const ShownFront& shown : shown_fronts(sim.solids)) {
        FrameFront& front = fronts.emplace_back();
        front.closed = shown.closed;
        for (const Vec3& x : shown.nodes) {
            const Vec3d at = sim.problem.scene.origin + x.cast<double>();
            front.nodes.push_back({at.x(), at.y(), at.z()});
        }
    }
    return fronts;
}

struct Sums {
    double mass = 0, kinetic = 0, potential = 0, volume = 0, error = 0;
    Vec3d momentum{0, 0, 0}, angular{0, 0, 0};
    Sums operator+(const Sums& b) const {
        return {mass + b.mass,   kinetic + b.kinetic,   potential + b.potential, volume + b.volume,
                error + b.error, momentum + b.momentum, angular + b.angular};
    }
};

FrameTotals totals(const Simulation& sim) {
    const Particles& p = sim.particles;
    const Vec3d gravity = sim.problem.scene.world.gravity;
    const Sums sum = parallel_sum<Sums>(
        p.size(),
        [&](std::size_t i) {
            const double m = p.mass[i];
            const Vec3d x = sim.problem.scene.origin + p.position[i].cast<double>();
            const Quad& q = sim.sweep.motion[i];
            const Vec3d v(q.x, q.y, q.z);
            const double rest_density = p.mass[i] / p.rest_volume[i];
            return Sums{m,
                        0.5 * m * v.squaredNorm(),
                        -m * gravity.dot(x),
                        p.rest_volume[i],
                        std::max(p.density[i] / rest_density - 1, 0.0),
                        m * v,
                        m * x.cross(v)};
        },
        Sums{});
    FrameTotals t;
    t.mass = sum.mass;
    t.kinetic_energy = sum.kinetic;
    t.potential_energy = sum.potential;
    t.particle_volume = sum.volume;
    t.density_error = p.size() > 0 ? sum.error / static_cast<double>(p.size()) : 0;
    for (std::size_t a = 0; a < 3; ++a) {
        t.momentum[a] = sum.momentum[static_cast<Eigen::Index>(a)];
        t.angular_momentum[a] = sum.angular[static_cast<Eigen::Index>(a)];
    }
    const Real radius = static_cast<Real>(sim.problem.scene.surface.radius) * sim.problem.smoothing.spacing;
    if (sim.embedded.size() > 0) {
        // Sheets reach past their edges. The volume of matter that has not begun to melt is that of its elements.
        const double unmolten = parallel_sum(p.size(), [&](std::size_t i) {
            const Index e = sim.solids.element(p.id[i]);
            if (e == kNone) return 0.0;
            return sim.solids.owner(e).skin == Skin::embedded ? static_cast<double>(p.mass[i] / p.density[i]) : 0.0;
        });
        t.surface_volume = unmolten + surface_volume(sim.mixed_surface.animated, p, sim.walls, radius);
    } else if (sim.surface.size() > 0) {
        t.surface_volume = surface_volume(sim.surface, p, sim.walls, radius);
    }
    return t;
}

}  // namespace

void tell_of_hidden_colours(const scene::Scene& scene, const std::string& path, const std::string& look) {
    for (const scene::Appearance& a : scene.look.appearances)
        if (a.name == look && a.colour_by == scene::ColourBy::none && a.image.file.empty())
            log_info("{}: its mesh has colours, which look.appearances.{} does not show; colour_by: vertices does",
                     path, look);
}

std::vector<DrawnBoundary> store_boundaries(const scene::Scene& scene, CacheWriter& cache) {
    std::vector<DrawnBoundary> drawn;
    for (const scene::Boundary& b : scene.world.boundaries) {
        if (!b.visible) continue;
        const auto mesh = boundary_mesh(scene, b);
        if (mesh && !mesh->colours.empty()) tell_of_hidden_colours(scene, "world.boundaries." + b.name, b.look);
        if (mesh)
            drawn.push_back({b.name, b.look.empty() ? b.name : b.look, cache.add_asset(write_ply(*mesh)),
                             motion_of(scene, b.motion)});
    }
    return drawn;
}

ColouredShapes coloured_shapes(const scene::Scene& scene) {
    constexpr int kAcross = 8;  // places that are looked at, along an axis
    ColouredShapes shapes;
    for (const scene::Body& b : scene.bodies) {
        shapes.emplace_back();
        if (!scene::holds_mesh(scene, b.shape)) continue;
        Shape shape = make_shape(scene, b.shape);
        const auto box = shape.bounds();
        for (int k = 0; box && k < cube(kAcross) && !shapes.back(); ++k) {
            const Vec3 at(Real(k % kAcross), Real(k / kAcross % kAcross), Real(k / square(kAcross)));
            const Vec3 x = box->lower + (box->upper - box->lower).cwiseProduct(at) / Real(kAcross - 1);
            if (shape.node().colour(x)) shapes.back() = shape;
        }
        const auto of = std::ranges::find(scene.materials, b.material, &scene::Material::name);
        if (shapes.back() && of != scene.materials.end())
            tell_of_hidden_colours(scene, "bodies." + b.name, b.look.empty() ? of->look : b.look);
    }
    return shapes;
}

Frame make_frame(const Simulation& sim, const std::vector<DrawnBoundary>& boundaries, const ColouredShapes& coloured) {
    Frame frame;
    frame.number = sim.clock.frame;
    frame.time = sim.clock.time;
    frame.spacing = sim.problem.scene.solver.spacing;
    frame.particles = particle_points(sim);
    frame.surfels = surfel_points(sim);
    add_colours(sim, coloured, frame.surfels);
    frame.bodies = frame_bodies(sim);
    for (const DrawnBoundary& b : boundaries)
        frame.obstacles.push_back(frame_obstacle(b, sim.problem.scene.origin, sim.clock.time));
    frame.fronts = frame_fronts(sim);
    frame.totals = totals(sim);
    frame.shortfalls = find_shortfalls(sim);
    return frame;
}

}  // namespace thixo
