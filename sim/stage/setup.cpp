#include "sim/stage/setup.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/contract/scene_extent.h"
#include "pipeline/geometry/match_moments.h"
#include "pipeline/geometry/shapes.h"
#include "pipeline/geometry/volume_sampling.h"
#include "sim/bonds/members.h"
#include "sim/liquid/tension.h"
#include "sim/phase/phases.h"
#include "sim/solid/laws.h"
#include "sim/space/endless.h"
#include "sim/space/sampling.h"
#include "sim/space/scene_shapes.h"
#include "sim/stage/probes.h"
#include "sim/stage/solid_setup.h"
#include "sim/stage/strategy.h"

namespace thixo {
namespace {

constexpr Real kWallRoom = Real(0.1);               // spacings between a wall and the first particles
constexpr Real kBodyRoom = Real(0.7);               // spacings between the particles of two bodies
constexpr double kMomentCell = 0.25;                // spacings; of the cells that a shape's moments are summed over
constexpr double kSlowest = 0.1;                    // m/s
constexpr std::size_t kMostParticles = 2147483647;  // indices of particles and their ghosts are of 32 bits

template <class T>
int index_of(const std::vector<T>& list, const std::string& name, const char* what) {
    for (std::size_t k = 0; k < list.size(); ++k)
        if (list[k].name == name) return static_cast<int>(k);
    throw InputError("there is no {} named '{}'", what, name);
}

std::vector<Mould> make_moulds(const scene::Scene& scene) {
    std::vector<Mould> moulds;
    for (const scene::Mould& m : scene.surface.moulds)
        moulds.push_back({make_shape(scene, m.shape), static_cast<Real>(m.weight), static_cast<Real>(m.reach)});
    return moulds;
}

/// A bound on the speed of a motion at `reach` [m] from the axes that it turns about [m/s]. It is twice the largest
/// mean speed between two keys: smooth motions are at most that much faster in the middle.
double fastest_of(const scene::Scene& scene, const std::vector<scene::Key>& keys, double reach) {
    const RigidMotion motion = motion_of(scene, keys);
    double fastest = 0;
    for (std::size_t k = 1; k < keys.size(); ++k) {
        const Quatd from = rotation_from_degrees(keys[k - 1].rotate), to = rotation_from_degrees(keys[k].rotate);
        const Vec3d way = motion.pose(keys[k].time).translation - motion.pose(keys[k - 1].time).translation;
        const double distance = way.norm() + from.angularDistance(to) * reach;
        fastest = std::max(fastest, 2 * distance / (keys[k].time - keys[k - 1].time));
    }
    return fastest;
}

/// From the scene's zero to the farthest corner of a shape's box [m]; 0 where it has none.
double reach_of(const Shape& shape) {
    const auto box = shape.bounds();
    return box ? static_cast<double>(box->lower.cwiseAbs().cwiseMax(box->upper.cwiseAbs()).norm()) : 0;
}

double fastest_of(const scene::Scene& scene) {
    double fastest = 0;
    for (const scene::Body& b : scene.bodies) {
        const auto bounds = make_shape(scene, b.shape).bounds();
        const double reach = bounds ? 0.5 * static_cast<double>((bounds->upper - bounds->lower).norm()) : 0;
        const double turning = b.angular_velocity.norm() + b.velocity_gradient.matrix().norm();
        fastest = std::max(fastest, b.velocity.norm() + turning * reach);
    }
    for (const scene::Emitter& e : scene.emitters) {
        const Opening opening = opening_of(scene, e);
        const double reach = e.position.norm() + opening.radius;
        fastest = std::max(fastest, flow_speed(e, opening.area) + fastest_of(scene, e.motion, reach));
    }
    for (const scene::Boundary& b : scene.world.boundaries)
        if (b.motion.size() > 1)
            fastest = std::max(fastest, fastest_of(scene, b.motion, reach_of(make_shape(scene, b.shape))));
    for (const scene::Handle& h : scene.handles)
        if (h.motion.size() > 1)
            fastest = std::max(fastest, fastest_of(scene, h.motion, reach_of(make_shape(scene, h.region))));
    return fastest;
}

/// The height matter can fall through along gravity [m].
double drop_height(const scene::Scene& scene) {
    const double g = scene.world.gravity.norm();
    if (g == 0) return 0;
    const Vec3d up = -scene.world.gravity / g;
    double top = -std::numeric_limits<double>::infinity(), own = top, bottom = -top;
    const auto extent = [&](const Shape& shape, double& lowest, double& highest) {
        const auto box = shape.bounds();
        if (!box) return;
        for (int c = 0; c < 8; ++c) {
            const Vec3 corner(c & 1 ? box->upper.x() : box->lower.x(), c & 2 ? box->upper.y() : box->lower.y(),
                              c & 4 ? box->upper.z() : box->lower.z());
            const double h = up.dot(corner.cast<double>());
            lowest = std::min(lowest, h);
            highest = std::max(highest, h);
        }
    };
    double body_bottom = bottom;
    for (const scene::Body& b : scene.bodies) extent(make_shape(scene, b.shape), body_bottom, top);
    for (const scene::Emitter& e : scene.emitters) top = std::max(top, up.dot(e.position));
    for (const scene::Boundary& b : scene.world.boundaries) {
        if (const auto plane = scene::placed_plane(b.shape); plane && !b.inside && up.dot(plane->normal) > 0.5)
            bottom = std::min(bottom, up.dot(plane->on));
        else
            extent(make_shape(scene, b.shape), bottom, own);
    }
    // Without walls nothing stops the fall and only the matter's own height makes pressure.
    bottom = std::min(bottom, body_bottom);
    return std::isfinite(top) && std::isfinite(bottom) ? std::max(0.0, top - bottom) : 0;
}

/// Throws InputError where a body reaches beyond a periodic face: it would lose that part.
void refuse_beyond_faces(const scene::Body& body, const Shape& shape, const Vec3d& origin, const Periodic& periodic,
                         Real spacing) {
    const auto box = shape.bounds();
    for (int a = 0; a < 3; ++a) {
        const Periodic::Axis& axis = periodic.axis[static_cast<std::size_t>(a)];
        if (!axis.on || !box) continue;
        if (box->lower[a] < axis.from - spacing / 2 || box->upper[a] > axis.to + spacing / 2)
            throw InputError(
                "{}: body '{}' reaches from {} to {} m, beyond the periodic faces {} and {} m of axis {}; "
                "cut it there",
                body.shape.where, body.name, origin[a] + static_cast<double>(box->lower[a]),
                origin[a] + static_cast<double>(box->upper[a]), origin[a] + static_cast<double>(axis.from),
                origin[a] + static_cast<double>(axis.to), "xyz"[a]);
    }
}

/// Throws InputError where a solid ends between periodic faces: its ends would have to meet its own images.
void refuse_ends(const scene::Body& body, const Shape& shape, const std::vector<Vec3>& sites, const Simulation& sim) {
    const Periodic& periodic = sim.problem.periodic;
    if (periodic.any() && !goes_through(shape, sites, sim.problem.smoothing.spacing, periodic))
        throw InputError(
            "{}: body '{}' does not go on from face to face of the periodic axes with one section; other solids in a "
            "periodic domain are not supported yet",
            body.shape.where, body.name);
}

void refuse_overlap(const scene::Body& body, const std::vector<Vec3>& sites, const Simulation& sim) {
    for (const Vec3& x : sites)
        if (wall_distance(sim.walls, x) < 0)
            throw InputError("{}: body '{}' starts inside a wall at {} m; move it out of the wall", body.shape.where,
                             body.name, place_text(sim.problem.scene, x));
}

/// Places that stand for one volume each [m^3].
SampledVolume equal_sites(std::vector<Vec3> places, double volume, Real spacing) {
    const std::size_t count = places.size();
    SampledVolume sites;
    sites.position = std::move(places);
    sites.volume.assign(count, static_cast<Real>(volume));
    sites.spacing.assign(count, spacing);
    return sites;
}

/// Particles on a hexagonal lattice that is fitted to the shape. They have its volume, but for the parts that are not
/// free.
SampledVolume pack(const Shape& shape, const std::function<bool(const Vec3&)>& free, const Simulation& sim) {
    const Real d = sim.problem.smoothing.spacing;
    FittedPacking packing = fit_packing(shape, d, free, sim.problem.periodic);
    return equal_sites(std::move(packing.position), packing.volume, d);
}

/// The particles of a solid on another lattice than the hexagonal one (dissertation 5.7).
SampledVolume sample_cells(const scene::Body& body, const Shape& shape, Real spacing) {
    const bool octree = body.sampling.lattice == scene::Lattice::octree;
    return sample_volume(shape, {.lattice = octree ? Lattice::octree : Lattice::uniform,
                                 .spacing = static_cast<double>(spacing),
                                 .levels = body.sampling.levels});
}

/// A solid's particles on a hexagonal lattice, in the shape's own frame: the same however the body is turned.
SampledVolume pack_turned(const scene::Body& body, const Shape& shape, const Simulation& sim) {
    const Real d = sim.problem.smoothing.spacing;
    if (sim.problem.periodic.any() || body.shape.rotate.isZero()) return pack_solid(shape, d, sim.problem.periodic);
    scene::Shape own = body.shape;
    own.rotate = own.translate = Vec3d::Zero();
    SampledVolume sites = pack_solid(make_shape(sim.problem.scene, own), d);
    const Quatd turn = rotation_from_degrees(body.shape.rotate);
    for (Vec3& x : sites.position) x = (turn * x.cast<double>() + body.shape.translate).cast<Real>();
    return sites;
}

/// The particles of matter that melts: equal ones, for a liquid's pressure is that of equal particles. Where no skins are
/// made, their volume is not summed.
SampledVolume sample_melting(const Shape& shape, SkinSetup skins, const Simulation& sim) {
    const Real d = sim.problem.smoothing.spacing;
    std::vector<Vec3> places = pack_shape(
        shape, d, [](const Vec3&) { return true; }, sim.problem.periodic);
    const double volume =
        skins == SkinSetup::make && !places.empty()
            ? thixo::volume(shape, kMomentCell * static_cast<double>(d)) / static_cast<double>(places.size())
            : cube(static_cast<double>(d));
    return equal_sites(std::move(places), volume, d);
}

/// A solid's particles. Their volumes have the moments of the shape, so that its mass and its inertia are right. Where no
/// skins are made, moments are not summed.
SampledVolume sample_solid(const scene::Body& body, const Shape& shape, SkinSetup skins, const Simulation& sim) {
    const Real d = sim.problem.smoothing.spacing;
    SampledVolume sites = body.sampling.lattice == scene::Lattice::hexagonal ? pack_turned(body, shape, sim)
                                                                             : sample_cells(body, shape, d);
    if (sites.position.empty() || skins != SkinSetup::make) return sites;
    const Periodic& periodic = sim.problem.periodic;
    std::vector<Vec3> places;  // in the section, of an endless body
    std::vector<double> freedom;
    for (std::size_t k = 0; k < sites.position.size(); ++k) {
        places.push_back(in_section(sites.position[k], periodic));
        freedom.push_back(outer_freedom(static_cast<double>(-shape.distance(places.back()) / sites.spacing[k])));
    }
    const ShapeMoments whole = moments(shape, kMomentCell * static_cast<double>(d));
    match_moments(places, freedom, section_moments(whole, *shape.bounds(), periodic), sites.volume);
    return sites;
}

Vec3d centre_of_mass(const SampledVolume& sites) {
    Vec3d sum(0, 0, 0);
    double volume = 0;
    for (std::size_t k = 0; k < sites.position.size(); ++k) {
        sum += static_cast<double>(sites.volume[k]) * sites.position[k].cast<double>();
        volume += static_cast<double>(sites.volume[k]);
    }
    return sum / volume;
}

/// The bodies whose particles are placed, with their boxes. Of thousands of bodies only a few are near a new one.
class PlacedBodies {
  public:
    /// Positions of all particles that may be within `reach` [m] of the shape.
    std::vector<Vec3> near(const Shape& shape, Real reach, const Simulation& sim) const {
        const auto box = shape.bounds();
        std::vector<Vec3> found;
        for (const Placed& b : list_) {
            if (box && ((b.lower.array() > box->upper.array() + reach).any() ||
                        (b.upper.array() < box->lower.array() - reach).any()))
                continue;
            const auto from = sim.particles.position.begin();
            found.insert(found.end(), from + static_cast<std::ptrdiff_t>(b.first),
                         from + static_cast<std::ptrdiff_t>(b.last));
        }
        return found;
    }
    /// The particles from `first` on are a body's.
    void add(std::size_t first, const Particles& particles) {
        Placed b{first, particles.size(), particles.position[first], particles.position[first]};
        for (std::size_t i = first; i < b.last; ++i) {
            b.lower = b.lower.cwiseMin(particles.position[i]);
            b.upper = b.upper.cwiseMax(particles.position[i]);
        }
        list_.push_back(b);
    }

  private:
    struct Placed {
        std::size_t first, last;
        Vec3 lower, upper;
    };
    std::vector<Placed> list_;
};

void add_body(const scene::Body& body, int number, SkinSetup skins, PlacedBodies& placed, Simulation& sim) {
    const scene::Scene& scene = sim.problem.scene;
    const Real d = sim.problem.smoothing.spacing;
    const int material = index_of(scene.materials, body.material, "material");
    const ResolvedMaterial& matter = sim.problem.materials[static_cast<std::size_t>(material)];
    const double melt = matter.melt_fraction(body.temperature);
    const bool solid = melt < 1;
    const Shape shape = make_shape(scene, body.shape);
    refuse_beyond_faces(body, shape, scene.origin, sim.problem.periodic, d);
    PointGrid others;
    if (!solid) others.build(placed.near(shape, kBodyRoom * d, sim), d);
    const auto free = [&](const Vec3& x) {
        if (wall_distance(sim.walls, x) < kWallRoom * d) return false;
        bool taken = false;
        others.for_each_neighbour(x, kBodyRoom * d, [&](Index, Real) { taken = true; });
        return !taken;
    };
    const SampledVolume sites = named_in_scene(body.shape, "body", body.name, [&] {
        if (!solid) return pack(shape, free, sim);
        return matter.melting.any() ? sample_melting(shape, skins, sim) : sample_solid(body, shape, skins, sim);
    });
    const std::size_t count = sites.position.size();
    if (count == 0)
        throw InputError(
            "{}: body '{}' holds no particle at a spacing of {} m; lower solver.spacing or move it out of the wall",
            body.shape.where, body.name, d);
    if (solid) refuse_overlap(body, sites.position, sim);
    if (solid) refuse_ends(body, shape, sites.position, sim);
    const Vec3d centre = centre_of_mass(sites);
    const Mat3d gradient = body.velocity_gradient.matrix();
    const std::size_t first = sim.particles.size();
    if (first + count > kMostParticles)
        throw InputError("{}: with body '{}' the scene has {} particles, and {} are possible; raise solver.spacing",
                         body.shape.where, body.name, first + count, kMostParticles);
    resize_table(sim.particles, first + count);
    Particles& p = sim.particles;
    for (std::size_t k = 0; k < count; ++k) {
        const std::size_t i = first + k;
        p.id[i] = sim.next_id++;
        p.position[i] = sim.problem.periodic.wrapped(sites.position[k]);
        if (p.has.surface) p.surface_position[i] = p.position[i];
        const Vec3d from_centre = sites.position[k].cast<double>() - centre;
        p.velocity[i] =
            (body.velocity + body.angular_velocity.cross(from_centre) + gradient * from_centre).cast<Real>();
        p.acceleration[i] = sim.problem.outside.gravity;
        p.rest_volume[i] = sites.volume[k];
        if (p.has.spacing) p.spacing[i] = sites.spacing[k];
        p.density[i] = matter.density;
        p.mass[i] = p.density[i] * p.rest_volume[i];
        p.temperature[i] = body.temperature;
        p.material[i] = material;
        p.body[i] = number;
        p.melt[i] = static_cast<Real>(melt);
        p.phase[i] = !matter.keeps_shape(melt) ? Phase::liquid : melt < 1 ? Phase::solid : Phase::viscoelastic;
    }
    placed.add(first, p);
}

}  // namespace

double expected_speed(const scene::Scene& scene) {
    if (scene.solver.expected_speed > 0) return scene.solver.expected_speed;
    const double fall2 = 2 * scene.world.gravity.norm() * drop_height(scene);
    double speed2 = square(fastest_of(scene)) + fall2;
    const double support = scene.solver.support * scene.solver.spacing;
    for (const scene::Material& m : scene.materials) {
        const double tension = m.melting.any() ? m.melting.liquid.surface_tension : m.surface_tension;
        speed2 = std::max(speed2, 56.0 / 3.0 * tension / (m.density * support));
    }
    return std::max(kSlowest, std::sqrt(speed2));
}

Simulation make_simulation(const scene::Scene& in_world, SkinSetup skins) {
    warn_of_meshes(in_world);
    const scene::Scene scene = near_origin(in_world);
    const Smoothing smoothing(static_cast<Real>(scene.solver.spacing), static_cast<Real>(scene.solver.support));
    const double speed = expected_speed(scene);
    // Walls and the problem are made before what holds them: g++ 12 destroys the members of a nested initialiser twice
    // where a later one throws.
    const Strategy strategy = strategy_of(scene.solver);
    Walls walls = make_walls(scene, smoothing, strategy);
    Problem problem{.scene = scene,
                    .strategy = strategy,
                    .replay = {},
                    .smoothing = smoothing,
                    .tension = TensionScale(smoothing, strategy),
                    .materials = resolve_materials(scene, static_cast<Real>(speed), strategy),
                    .heat = {},
                    .moulds = make_moulds(scene),
                    .outside = outside_of(scene.world),
                    .periodic = make_periodic(scene.world, smoothing.support),
                    .expected_speed = speed,
                    .emitters = {}};
    Simulation sim{.problem = std::move(problem), .walls = std::move(walls)};
    sim.problem.heat = make_heat(scene, sim.problem.materials);
    calm_surfaces(strategy_of(scene.solver), smoothing, sim.problem.materials);
    choose_viscosity_solver(scene.solver, smoothing, speed, sim.problem.materials);
    sim.clock.frame = scene.frames.first;
    sim.particles.has = {.surface = scene.surface.enabled,
                         .implicit_pressure = strategy.incompressible,
                         .implicit_viscosity = std::ranges::any_of(
                             sim.problem.materials, [](const ResolvedMaterial& m) { return m.implicit_viscosity > 0; }),
                         .spacing = std::ranges::any_of(scene.bodies, [](const scene::Body& b) {
                             return b.sampling.lattice == scene::Lattice::octree;
                         })};
    PlacedBodies placed;
    for (std::size_t b = 0; b < scene.bodies.size(); ++b)
        add_body(scene.bodies[b], static_cast<int>(b), skins, placed, sim);
    sim.probes = make_probes(scene, sim.particles);
    sim.solids = make_solids(scene, smoothing, sim.problem.periodic, sim.particles);
    make_phases(scene, sim.problem.materials, smoothing, sim.particles, sim.solids);
    locate_particles(sim.particles, sim.solids);
    if (scene.surface.enabled && skins == SkinSetup::make) sim.embedded = make_embedded_surface(scene, sim.solids);
    make_breaking(scene, sim.problem.materials, sim.embedded, sim.particles, sim.solids);
    cut_painted_cracks(scene, matter_of(sim));
    for (std::size_t e = 0; e < scene.emitters.size(); ++e) {
        const int material = index_of(scene.materials, scene.emitters[e].material, "material");
        EmitterLayout layout = lay_out_emitter(
            scene, scene.emitters[e], sim.problem.materials[static_cast<std::size_t>(material)], smoothing.spacing);
        layout.material = material;
        layout.body = static_cast<int>(scene.bodies.size() + e);
        sim.problem.emitters.push_back(std::move(layout));
        sim.emitters.push_back({.next = flow_time_after(scene.emitters[e], scene.emitters[e].start, 0)});
    }
    return sim;
}

}  // namespace thixo
