// The blocks of the scene file that the simulation reads.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/base/math.h"
#include "pipeline/contract/scene_heat.h"
#include "pipeline/contract/scene_key.h"
#include "pipeline/contract/scene_motion.h"
#include "pipeline/contract/scene_shapes.h"
#include "pipeline/contract/scene_solids.h"

namespace thixo::scene {

struct Frames {
    int first = 1, last = 48;
    double fps = 24;  // 1/s
};
template <class V>
void visit(V& v, Frames& f) {
    v.key("first", f.first, "", between(0, 999999), "number of the first frame, the state at time 0");
    v.key("last", f.last, "", between(0, 999999), "number of the last frame");
    v.key("fps", f.fps, "1/s", between(0.001, 1e6), "frames a second");
}

struct Boundary {
    std::string name;
    Shape shape;
    bool inside = false;  // true: the shape is the room, matter stays inside it; false: it is an obstacle
    bool no_slip = false;
    double contact_angle = 180;  // degrees
    bool isothermal = false;
    double temperature = 20;  // degC
    std::vector<Key> motion;
    std::string look;  // appearance; empty: the boundary's name
    bool visible = true;
};
template <class V>
void visit(V& v, Boundary& b) {
    v.shape("shape", b.shape, required(), "the solid, or with `inside` the room");
    v.key("inside", b.inside, "", any(), "true: matter stays inside the shape; false: the shape is an obstacle");
    v.key("contact_angle", b.contact_angle, "degrees", between(0, 180),
          "angle in the liquid where its surface meets the wall: 0 wets it, 180 does not stick at all");
    v.key("no_slip", b.no_slip, "", any(),
          "true: fluid sticks to the surface; false: it slides along it; left out: true where the scene has a liquid "
          "of 1 "
          "Pa s or more, as thick as syrup");
    v.key("isothermal", b.isothermal, "", any(), "true: its surface is kept at `temperature`; false: it takes no heat");
    v.key("temperature", b.temperature, "degC", between(-273.15, 1e5), "temperature of an isothermal boundary");
    v.list("motion", b.motion, "moves the boundary");
    v.reference("look", b.look, Refers::appearance, any(), "appearance; left out: the one of the boundary's own name");
    v.key("visible", b.visible, "", any(), "false: not drawn");
}

enum class Axis { x, y, z };
template <>
struct Words<Axis> {
    static constexpr std::array<std::string_view, 3> list{"x", "y", "z"};
};

struct PeriodicAxis {
    Axis axis = Axis::x;
    double from = 0, to = 0;  // m
};
template <class V>
void visit(V& v, PeriodicAxis& p) {
    v.key("axis", p.axis, "", required(), "the axis along which the domain repeats itself");
    v.key("from", p.from, "m", required(between(-1e6, 1e6)), "place of the lower face");
    v.key("to", p.to, "m", required(between(-1e6, 1e6)), "place of the upper face, at least two supports farther");
}

struct World {
    Vec3d gravity{0, 0, -9.81};  // m/s^2
    std::vector<Boundary> boundaries;
    std::vector<PeriodicAxis> periodic;
    std::vector<HeatSource> heat_sources;
};
template <class V>
void visit(V& v, World& w) {
    v.key("gravity", w.gravity, "m/s^2", between(-1e4, 1e4), "acceleration of free fall");
    v.named("boundaries", w.boundaries, "walls, floors and vessels");
    v.list("periodic", w.periodic,
           "periodic axes: what leaves through one face comes back through the other; boundaries are not repeated; one "
           "solid may go on from face to face with one section, as in plane strain (leapfrog steps, no melting, no "
           "cracks)");
    v.named("heat_sources", w.heat_sources, "where heat is made");
}

struct Material {
    std::string name;
    double density = 1000;       // kg/m^3, at rest
    double viscosity = 0.001;    // Pa s, dynamic
    double surface_tension = 0;  // N/m
    double stiffness = 0;        // Pa, k_gas of the `eos` solver; 0: from the expected speed (1 % compression)
    double gamma = 1;            // exponent of the `eos` solver
    Thermal thermal;
    Elastic elastic;
    Melting melting;
    Fracture fracture;
    std::string look;  // appearance; empty: the material's name
};
template <class V>
void visit(V& v, Material& m) {
    v.key("density", m.density, "kg/m^3", above_to(0, 1e6), "density at rest");
    v.key("viscosity", m.viscosity, "Pa s", between(0, 1e9),
          "dynamic viscosity; water 0.001, honey about 5; in a solid it damps changes of shape");
    v.key("surface_tension", m.surface_tension, "N/m", between(0, 1e3),
          "surface tension; water against air 0.072. With `dfsph` the viscosity is then at least "
          "0.03 sqrt(tension density spacing), which brings drops to rest");
    v.key("stiffness", m.stiffness, "Pa", between(0, 1e12),
          "resistance to compression of the `eos` solver; 0: from the expected speed, for 1 % compression");
    v.key("gamma", m.gamma, "1", between(1, 10), "exponent of the equation of state");
    visit(v, m.thermal);
    visit(v, m.elastic);
    v.block("melting", m.melting, "a solid that melts and freezes: its two ends");
    v.block("fracture", m.fracture, "a solid that breaks: when cracks begin in it, and how they run");
    v.reference("look", m.look, Refers::appearance, any(), "appearance; left out: the one of the material's own name");
}

enum class Lattice { hexagonal, uniform, octree };
template <>
struct Words<Lattice> {
    static constexpr std::array<std::string_view, 3> list{"hexagonal", "uniform", "octree"};
};

/// Where the particles of a body stand at the start (dissertation 5.7).
struct Sampling {
    Lattice lattice = Lattice::hexagonal;
    int levels = 2;  // of an octree: cells inside are up to 2^levels spacings wide
};
template <class V>
void visit(V& v, Sampling& s) {
    v.key(
        "lattice", s.lattice, "", any(),
        "hexagonal: the closest packing; uniform: cubes; octree: cubes of the size `solver.spacing` at the surface and "
        "wider ones inside. The last two are for solids that do not melt, an octree for scenes without liquids");
    v.key("levels", s.levels, "", between(0, 8), "octree: cells deep inside are up to 2^levels spacings wide");
}

/// A velocity that varies linearly: row a holds the derivatives of component a along x, y and z.
struct VelocityGradient {
    Vec3d x{0, 0, 0}, y{0, 0, 0}, z{0, 0, 0};  // 1/s
    Mat3d matrix() const {
        Mat3d g;
        g << x.transpose(), y.transpose(), z.transpose();
        return g;
    }
};
template <class V>
void visit(V& v, VelocityGradient& g) {
    constexpr auto kRange = between(-1e6, 1e6);
    v.key("x", g.x, "1/s", kRange, "change of the velocity along x with the place: [dvx/dx, dvx/dy, dvx/dz]");
    v.key("y", g.y, "1/s", kRange, "the same of the velocity along y");
    v.key("z", g.z, "1/s", kRange, "the same of the velocity along z");
}

struct Body {
    std::string name, material;
    Shape shape;
    Vec3d velocity{0, 0, 0};             // m/s
    Vec3d angular_velocity{0, 0, 0};     // rad/s about the shape's centre of mass
    VelocityGradient velocity_gradient;  // about the shape's centre of mass
    std::string look;                    // appearance; empty: the material's
    double temperature = 20;             // degC
    int surfels = 0;                     // about so many on a solid; 0: by surface.radius
    Sampling sampling;
    std::vector<PaintedCrack> cracks;
};
template <class V>
void visit(V& v, Body& b) {
    v.reference("material", b.material, Refers::material, required(), "what the body is made of");
    v.shape("shape", b.shape, required(), "the room it fills at the start");
    v.key("velocity", b.velocity, "m/s", between(-1e6, 1e6), "velocity at the start");
    v.key("angular_velocity", b.angular_velocity, "rad/s", between(-1e6, 1e6),
          "spin at the start, about the centre of mass");
    v.block("velocity_gradient", b.velocity_gradient,
            "linear flow at the start, about the centre of mass: stretching, shear or spin. It adds to `velocity`, "
            "which is that of the centre");
    v.reference("look", b.look, Refers::appearance, any(), "appearance; left out: the material's");
    v.key("temperature", b.temperature, "degC", between(-273.15, 1e5), "temperature at the start");
    v.key("surfels", b.surfels, "", between(0, 10'000'000),
          "number of surfels on the surface of a solid, about; 0: discs of the size surface.radius asks for");
    v.block("sampling", b.sampling, "where its particles stand");
    v.list("cracks", b.cracks, "cracks that it has from the start: lines on its surface, cut inwards");
}

/// An instant at which an emitter is turned on or off.
struct Switch {
    double time = 0;  // s
    bool on = true;
};
template <class V>
void visit(V& v, Switch& s) {
    v.key("time", s.time, "s", required(at_least(0)), "instant; ascending in the list");
    v.key("on", s.on, "", required(), "true: it flows from then on; false: it rests");
}

/// Where in its shape an emitter's matter begins.
enum class SourceForm { cut, surface, volume };
template <>
struct Words<SourceForm> {
    static constexpr std::array<std::string_view, 3> list{"cut", "surface", "volume"};
};

struct Emitter {
    std::string name, material;
    Vec3d position{0, 0, 0}, direction{0, 0, -1};
    double radius = 0.05;                 // m, of the disc
    Shape shape;                          // no kind: a disc
    SourceForm source = SourceForm::cut;  // with a shape
    double speed = 1;                     // m/s; 0: by the rate
    double rate = 0;                      // m^3/s; 0: by the speed
    double start = 0, stop = 1e9;         // s
    std::vector<Switch> switches;
    double jitter = 0;        // in spacings, random offset in the disc's plane
    double temperature = 20;  // degC
    std::vector<Key> motion;  // moves the emitter
};
template <class V>
void visit(V& v, Emitter& e) {
    v.reference("material", e.material, Refers::material, required(), "what flows out");
    v.key("position", e.position, "m", any(), "centre of the opening that the fluid leaves");
    v.key("direction", e.direction, "", direction(), "direction of the flow; any length");
    v.key("radius", e.radius, "m", above(0), "radius of the disc; with `shape` it has no effect");
    v.shape("shape", e.shape, any(),
            "a source of another form, a mesh too, as `source` says. It stands in the scene, not in the emitter's "
            "frame, and moves with `motion`");
    v.key("source", e.source, "", any(),
          "cut: the opening is where `shape` meets the plane through `position` across `direction`; surface: matter "
          "leaves the whole surface of `shape` along its normals, at `speed` or `rate`; volume: `shape` fills with "
          "matter by `rate`, which starts with `speed` along `direction`");
    v.key("speed", e.speed, "m/s", between(0, 1e4), "speed of the flow; 0, or left out beside `rate`: by `rate`");
    v.key("rate", e.rate, "m^3/s", between(0, 1e9), "volume that flows out, in place of `speed`; 0: by `speed`");
    v.key("start", e.start, "s", at_least(0), "time the flow starts");
    v.key("stop", e.stop, "s", at_least(0), "time the flow stops");
    v.list("switches", e.switches, "turns the flow off and on again between `start` and `stop`");
    v.key("jitter", e.jitter, "spacings", between(0, 0.5), "random shift of each particle in the disc's plane");
    v.key("temperature", e.temperature, "degC", between(-273.15, 1e5), "temperature of what flows out");
    v.list("motion", e.motion, "moves the emitter");
}

enum class Pressure { eos, dfsph };
template <>
struct Words<Pressure> {
    static constexpr std::array<std::string_view, 2> list{"eos", "dfsph"};
};

enum class Viscosity { automatic, explicit_force, implicit_solve };
template <>
struct Words<Viscosity> {
    static constexpr std::array<std::string_view, 3> list{"automatic", "explicit", "implicit"};
};

enum class SolidSteps { leapfrog, implicit_euler };
template <>
struct Words<SolidSteps> {
    static constexpr std::array<std::string_view, 2> list{"leapfrog", "implicit"};
};

struct TimeStep {            // fixed = 0: adaptive
    double fixed = 0;        // s
    double maximum = 0.005;  // s
    double cfl = 0.4;        // 1; with dfsph in spacings
};
template <class V>
void visit(V& v, TimeStep& t) {
    v.key("fixed", t.fixed, "s", between(0, 1), "step of constant size; 0: adaptive");
    v.key("maximum", t.maximum, "s", above_to(0, 1), "largest adaptive step");
    v.key("cfl", t.cfl, "1", above_to(0, 1),
          "part of its support a signal may cross in one adaptive step; with dfsph, spacings a particle may move");
}

struct Solver {
    double spacing = 0.01;  // m, between particles at rest
    double support = 2;     // kernel support h in spacings
    Pressure pressure = Pressure::eos;
    double density_tolerance = 0.0005;      // 1, mean over particles
    double divergence_tolerance = 0.00002;  // 1, mean over particles, in one step
    int iterations = 100;                   // of one pressure solve, at most
    double expected_speed = 0;  // m/s, for the automatic stiffness; 0: from the scene's height, speeds and gravity
    double artificial_viscosity = 0.15;  // Monaghan's alpha, 1
    Viscosity viscosity = Viscosity::automatic;
    double viscosity_tolerance = 1e-3;  // 1
    SolidSteps solids = SolidSteps::leapfrog;
    double solids_tolerance = 1e-3;  // 1
    TimeStep time_step;
    std::uint64_t seed = 1;
    int checkpoint_every = 10;  // frames
};
template <class V>
void visit(V& v, Solver& s) {
    // Within these, the square of a particle's volume is a normal single-precision number.
    v.key("spacing", s.spacing, "m", between(1e-6, 1e6),
          "distance of neighbouring particles at rest: the detail of the simulation");
    v.key("support", s.support, "spacings", between(1.2, 6), "support radius of the kernels");
    v.key("pressure", s.pressure, "", any(),
          "pressure solver; eos: equation of state, slightly compressible; dfsph: implicit, incompressible");
    v.key("density_tolerance", s.density_tolerance, "1", above_to(0, 0.1),
          "relative density error that `dfsph` leaves, mean over the particles");
    v.key("divergence_tolerance", s.divergence_tolerance, "1", above_to(0, 0.1),
          "relative density change in one step that the divergence solve of `dfsph` leaves, mean over the particles");
    v.key("iterations", s.iterations, "", between(1, 100000),
          "iterations of one pressure solve of `dfsph`, at most; reaching them is counted in stats.jsonl");
    v.key("expected_speed", s.expected_speed, "m/s", between(0, 1e6),
          "largest speed to expect, for the automatic stiffness; 0: from the scene's height, speeds and gravity");
    v.key("artificial_viscosity", s.artificial_viscosity, "1", between(0, 10), "Monaghan's alpha; damps shocks");
    v.key("viscosity", s.viscosity, "", any(),
          "solver of the viscosity; implicit: a linear system, no limit to the step; explicit: with `eos` it brakes "
          "what spins freely; automatic: implicit where the "
          "explicit force would set the step");
    v.key("viscosity_tolerance", s.viscosity_tolerance, "1", inside(0, 1),
          "part of the momentum that the implicit viscosity's solve may leave as residual");
    v.key(
        "solids", s.solids, "", any(),
        "steps of solids; leapfrog: explicit, as short as stiffness asks for; implicit: Euler backwards, of the length "
        "of time_step, for stiff bodies; damps what vibrates faster than the step");
    v.key("solids_tolerance", s.solids_tolerance, "1", inside(0, 1),
          "part of the forces that a step of implicit solids may leave unbalanced");
    v.block("time_step", s.time_step, "time steps");
    v.key("seed", s.seed, "", at_least(0), "seed of all random numbers");
    v.key("checkpoint_every", s.checkpoint_every, "frames", between(1, 999999), "frames between two checkpoints");
}

/// The external potential: a shape that the surfaces of liquids are drawn to.
struct Mould {
    std::string name;
    Shape shape;
    double weight = 1;  // 1
    double reach = 0;   // m
};
template <class V>
void visit(V& v, Mould& m) {
    v.shape("shape", m.shape, required(), "draws surfels near its surface, from outside and from within, to it");
    v.key("weight", m.weight, "1", between(0, 1e6),
          "weight beside those of the other potentials; where they add up to more than 1 each counts by its part");
    v.key("reach", m.reach, "m", required(above(0)), "how far from its surface it draws");
}

struct Surface {
    bool enabled = true;
    double radius = 0.5;                              // surfel radius r_s in spacings
    double support = 3;                               // surfel support h_s in surfel radii
    double iso = 0.5;                                 // iso-value of the colour field
    double guide = 0.2, attract = 0.1, smooth = 0.6;  // weights of the potentials
    int iterations = 6;                               // at most, per update
    std::vector<Mould> moulds;
};
template <class V>
void visit(V& v, Surface& s) {
    v.key("enabled", s.enabled, "", any(), "false: no surface, particles only");
    v.key("radius", s.radius, "spacings", between(0.05, 5), "radius of a surfel");
    v.key("support", s.support, "surfel radii", between(1, 10), "how far a surfel looks for its neighbours");
    v.key("iso", s.iso, "1", inside(0, 1), "value of the colour field that the guiding surface takes");
    v.key("guide", s.guide, "1", between(0, 1), "weight of the potential that draws surfels to the guiding surface");
    v.key("attract", s.attract, "1", between(0, 1), "weight of the potential that draws surfels to the particles");
    v.key("smooth", s.smooth, "1", between(0, 1), "weight of the smoothing potential");
    v.key("iterations", s.iterations, "", between(1, 1000), "deformation steps of one update, at most");
    v.named("moulds", s.moulds, "shapes that the surfaces of liquids and of what has melted take on");
}

}  // namespace thixo::scene
