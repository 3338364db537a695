// The scene file in memory. SI units, degrees Celsius, z up. Every key is declared once, beside its struct.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "pipeline/base/math.h"

namespace thixo::scene {

struct Key {  // one instant of a rigid motion
    double time = 0;            // s
    Vec3d position{0, 0, 0};    // m
    Vec3d rotate{0, 0, 0};      // degrees about x, then y, then z
};

// ---- shapes -------------------------------------------------------------------------------------------------------------------
struct Shape;
struct Sphere { double radius = 0.5; };
struct Ellipsoid { Vec3d radii{0.5, 0.5, 0.5}; };
struct BoxShape { Vec3d size{1, 1, 1}; double rounding = 0; };
struct Cylinder { double radius = 0.5, height = 1; double rounding = 0; };       // axis z, centred
struct RoundedCone { double radius1 = 0.5, radius2 = 0.25, height = 1; };        // two spheres and their hull, axis z from the origin
struct Capsule { Vec3d from{0, 0, 0}, to{0, 0, 1}; double radius = 0.25; };
struct Torus { double radius = 0.5, tube = 0.1; };                               // axis z
struct Plane { Vec3d normal{0, 0, 1}; double offset = 0; };                      // solid where normal.x < offset
struct Revolve { std::vector<Vec2d> profile; };                                  // closed polygon (r >= 0, z) turned about z
struct MeshFile { std::string file; double scale = 0; double height = 0; };      // file units carry no size: one of scale, height
struct ShapeList { std::vector<Shape> shapes; double smooth = 0; };              // smooth: blending radius [m]
struct Union : ShapeList {};
struct Intersection : ShapeList {};
struct Difference : ShapeList {};                                                // the first less all others
struct NamedShape { std::string name; };                                         // an entry of `shapes`

struct Shape {
    std::variant<std::monostate, Sphere, Ellipsoid, BoxShape, Cylinder, RoundedCone, Capsule, Torus, Plane, Revolve, MeshFile, Union,
                 Intersection, Difference, NamedShape>
        kind;
    double scale = 1;                // applied first
    Vec3d rotate{0, 0, 0};           // degrees about x, then y, then z; applied second
    Vec3d translate{0, 0, 0};        // m; applied last
    double offset = 0;               // m, grows (> 0) or shrinks the shape
    double shell = 0;                // m, > 0: a hollow shell of this thickness, inwards from the surface
    std::string where;               // file:line:column, for messages
};

// ---- simulation blocks (read by sim) --------------------------------------------------------------------------------------------
struct Frames { int first = 1, last = 48; double fps = 24; };

struct Boundary {
    std::string name;
    Shape shape;
    bool inside = false;             // true: the shape is the room, matter stays inside it; false: it is an obstacle
    bool no_slip = false;
    std::vector<Key> motion;
    std::string look;                // appearance; empty: the boundary's name
    bool visible = true;
};

struct World {
    Vec3d gravity{0, 0, -9.81};      // m/s^2
    std::vector<Boundary> boundaries;
};

struct Material {
    std::string name;
    double density = 1000;           // kg/m^3, at rest
    double viscosity = 0.001;        // Pa s, dynamic
    double surface_tension = 0;      // N/m
    double stiffness = 0;            // Pa, k_gas of the `eos` solver; 0: from the expected speed (1 % compression)
    double gamma = 1;                // exponent of the `eos` solver
    std::string look;                // appearance; empty: the material's name
};

struct Body {
    std::string name, material;
    Shape shape;
    Vec3d velocity{0, 0, 0};         // m/s
    Vec3d angular_velocity{0, 0, 0}; // rad/s about the shape's centre of mass
    double temperature = 20;         // degC
};

struct Emitter {
    std::string name, material;
    Vec3d position{0, 0, 0}, direction{0, 0, -1};
    double radius = 0.05;            // m, of the disc
    double speed = 1;                // m/s
    double start = 0, stop = 1e9;    // s
    double jitter = 0;               // in spacings, random offset in the disc's plane
    double temperature = 20;         // degC
    std::vector<Key> motion;         // moves the emitter
};

enum class Pressure { eos };
struct TimeStep { double fixed = 0; double maximum = 0.005; double cfl = 0.4; };   // s, s, 1; fixed = 0: adaptive
struct Solver {
    double spacing = 0.01;           // m, between particles at rest
    double support = 2;              // kernel support h in spacings
    Pressure pressure = Pressure::eos;
    double expected_speed = 0;       // m/s, for the automatic stiffness; 0: from the scene's height, speeds and gravity
    double artificial_viscosity = 0.05;  // Monaghan's alpha, 1
    TimeStep time_step;
    std::uint64_t seed = 1;
    int checkpoint_every = 10;       // frames
};

struct Surface {
    bool enabled = true;
    double radius = 0.5;             // surfel radius r_s in spacings
    double support = 3;              // surfel support h_s in surfel radii
    double iso = 0.5;                // iso-value of the colour field
    double guide = 0.2, attract = 0.1, smooth = 0.6;  // weights of the potentials
    int iterations = 6;              // at most, per update
};

// ---- look (read by render) -------------------------------------------------------------------------------------------------------
struct Camera {
    Vec3d position{0, -3, 1}, look_at{0, 0, 0}, up{0, 0, 1};
    double fov = 40;                 // degrees, horizontal
    double aperture = 0;             // m, lens radius
    double focus_distance = 0;       // m; 0: distance to look_at
    std::vector<Key> motion;         // moves the camera rigidly about its own position
};

enum class LightType { sun, sky, area };
struct Light {
    std::string name;
    LightType type = LightType::sky;
    Vec3d colour{1, 1, 1};           // linear Rec.709
    double strength = 1;             // sun: irradiance [W/m^2]; sky, area: radiance [W/(m^2 sr)]
    Vec3d direction{0, 0, -1};       // sun: where the light goes; area: the side it shines to
    double angle = 0.53;             // sun: angular diameter [degrees]
    Vec3d position{0, 0, 3};         // area: centre [m]
    Vec2d size{1, 1};                // area: edge lengths [m]
    Vec3d horizon{1, 1, 1};          // sky: colour factor at the horizon
    Vec3d ground{0.3, 0.3, 0.3};     // sky: colour factor below the horizon
};

enum class AppearanceType { diffuse, plastic, conductor, dielectric };
struct Appearance {
    std::string name;
    AppearanceType type = AppearanceType::diffuse;
    Vec3d colour{0.8, 0.8, 0.8};     // albedo, or reflectance at normal incidence of a conductor
    Vec3d colour2{0.3, 0.3, 0.3};    // second colour of a checker
    double checker = 0;              // m, edge of a checker field in world xy; 0: plain
    double roughness = 0;            // GGX alpha; 0: smooth
    double ior = 1.5;
    Vec3d absorption{0, 0, 0};       // 1/m, dielectric
    int priority = 0;                // nested dielectrics: the higher wins where two overlap
};

enum class ViewTransform { srgb, filmic };
struct Output {
    int width = 960, height = 540;
    int samples = 64;
    int max_bounces = 12;
    double exposure = 0;             // stops, PNG and film only
    ViewTransform view = ViewTransform::filmic;
    bool straight_shadows = true;    // shadow rays go straight through smooth dielectrics (a documented bias)
    double clamp = 20;               // indirect radiance of one sample is limited to this; 0: no limit
    bool transparent_background = false;
    bool film = true;                // encode an mp4
};

struct Look {
    Camera camera;
    std::vector<Light> lights;
    std::vector<Appearance> appearances;
    Vec3d background{0.8, 0.85, 0.9};   // seen by camera rays where no light's environment is
    Output output;
};

struct Scene {
    std::string name;
    std::string title;
    Frames frames;
    std::vector<std::pair<std::string, Shape>> shapes;   // named sub-shapes
    World world;
    std::vector<Material> materials;
    std::vector<Body> bodies;
    std::vector<Emitter> emitters;
    Solver solver;
    Surface surface;
    Look look;
};

}  // namespace thixo::scene
