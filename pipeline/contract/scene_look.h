// The look: what the renderer reads of the scene file.
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/base/math.h"
#include "pipeline/contract/scene_key.h"
#include "pipeline/contract/scene_simulation.h"

namespace thixo::scene {

/// One instant of a camera's path.
struct CameraKey {
    double time = 0;                             // s
    Vec3d position{0, -3, 1}, look_at{0, 0, 0};  // m
    double fov = 0;                              // degrees; 0: the camera's
};
template <class V>
void visit(V& v, CameraKey& k) {
    v.key("time", k.time, "s", required(), "instant; ascending in the list");
    v.key("position", k.position, "m", required(), "the eye");
    v.key("look_at", k.look_at, "m", required(), "point in the middle of the picture");
    v.key("fov", k.fov, "degrees", between(0, 170), "horizontal field of view; 0: that of the camera");
}

struct Camera {
    Vec3d position{0, -3, 1}, look_at{0, 0, 0}, up{0, 0, 1};
    double fov = 40;            // degrees, horizontal
    double aperture = 0;        // m, lens radius
    double focus_distance = 0;  // m; 0: distance to look_at
    std::vector<Key> motion;    // moves the camera rigidly about its own position
    // Takes the place of position and look_at.
    std::vector<CameraKey> path;
    // About look_at [degrees/s].
    double orbit = 0;
    // Frames, from the frame's own time. Both the same: nothing is blurred.
    double shutter_open = 0, shutter_close = 0;
};
template <class V>
void visit(V& v, Camera& c) {
    v.key("position", c.position, "m", any(), "the eye");
    v.key("look_at", c.look_at, "m", any(), "point in the middle of the picture");
    v.key("up", c.up, "", direction(), "direction that is up in the picture");
    v.key("fov", c.fov, "degrees", between(0.1, 170), "horizontal field of view");
    v.key("aperture", c.aperture, "m", at_least(0), "radius of the lens; 0: everything is sharp");
    v.key("focus_distance", c.focus_distance, "m", at_least(0), "distance that is sharp; 0: the distance of look_at");
    v.key("shutter_open", c.shutter_open, "frames", between(-1, 1),
          "when the shutter opens, from the frame's own time; moving things are blurred until it closes");
    v.key("shutter_close", c.shutter_close, "frames", between(-1, 1),
          "when the shutter closes; -0.25 to 0.25 is half a frame, as in film; both the same: nothing is blurred");
    v.list(
        "path", c.path,
        "where the camera is and what it looks at, smoothly from key to key; takes the place of position and look_at");
    v.list("motion", c.motion, "moves the camera rigidly about its own position");
    v.key("orbit", c.orbit, "degrees/s", between(-3600, 3600),
          "the camera goes round look_at, about `up`, from its place at 0 s; counterclockwise as seen from above, "
          "the side that `up` points to");
}

enum class LightType { sun, sky, area, environment, point, spot };
template <>
struct Words<LightType> {
    static constexpr std::array<std::string_view, 6> list{"sun", "sky", "area", "environment", "point", "spot"};
};
struct Light {
    std::string name;
    LightType type = LightType::sky;
    std::string group;      // of lights that share a pass; empty: the light alone
    Vec3d colour{1, 1, 1};  // linear Rec.709
    // sun: irradiance [W/m^2]; sky, area: radiance [W/(m^2 sr)]; point, spot: intensity [W/sr]; environment: factor
    double strength = 1;
    // sun, spot: where the light goes; area: the side it shines to. At most one of the two is there (light_direction).
    std::optional<Vec3d> direction;
    std::optional<Vec3d> look_at;  // area, spot: the point that it shines at [m]
    double angle = 0.53;           // sun: angular diameter [degrees]
    double cone = 40;              // spot: from side to side [degrees]
    double softness = 0.2;         // spot: part of the half cone in which it fades [1]
    Vec3d position{0, 0, 3};       // area: centre; point, spot: place [m]
    Vec2d size{1, 1};              // area: edge lengths [m]
    Vec3d horizon{1, 1, 1};        // sky: colour factor at the horizon
    Vec3d ground{0.3, 0.3, 0.3};   // sky: colour factor below the horizon
    std::string file;              // environment: the picture
    std::string content;           // hash of the file's bytes, filled in when the look is read
    double rotation = 0;           // environment: about z [degrees]
};
template <class V>
void visit(V& v, Light& l) {
    v.key("type", l.type, "", required(),
          "sun: parallel light; sky: light from all sides; area: a rectangle that shines; environment: a picture of "
          "light from all sides; point: a lamp without size; spot: one that shines into a cone");
    v.key("group", l.group, "", any(),
          "lights of one group share a pass of look.output.passes.lights; none: the light has its own");
    v.key("colour", l.colour, kColour, at_least(0), "colour, linear Rec.709; of an environment a factor");
    v.key(
        "strength", l.strength, "W/m^2, W/(m^2 sr), W/sr", at_least(0),
        "sun: irradiance; sky and area: radiance; point and spot: intensity, the irradiance a metre away; environment: "
        "what the picture's values are times");
    v.key("direction", l.direction, "", direction(),
          "sun and spot: where the light goes; area: the side it shines to; left out: down");
    v.key("look_at", l.look_at, "m", any(), "area and spot: point that it shines at; takes the place of `direction`");
    v.key("angle", l.angle, "degrees", between(0, 90), "sun: angular diameter; the real sun's is 0.53");
    v.key("cone", l.cone, "degrees", between(1, 180), "spot: the whole angle of its cone, from dark to dark");
    v.key("softness", l.softness, "1", between(0, 1), "spot: the outer part of the cone in which the light fades");
    v.key("position", l.position, "m", any(), "area: centre; point and spot: place");
    v.key("size", l.size, "m", above(0), "area: edge lengths");
    v.key("horizon", l.horizon, kColour, at_least(0), "sky: colour factor at the horizon");
    v.key("ground", l.ground, kColour, at_least(0), "sky: colour factor below the horizon");
    v.file("file", l.file, any(),
           "environment: EXR or Radiance HDR, twice as wide as high: longitude from left to right, latitude from top "
           "to bottom; its middle is the direction +x, +y a quarter to the left");
    v.key("content", l.content, "", any(),
          "hash of the file's bytes, filled in when the scene is read; where given, the file must match");
    v.key("rotation", l.rotation, "degrees", any(), "environment: turned about z, to the left seen from inside");
}

/// Where a light goes, not a unit vector: towards `look_at`, along `direction`, or down. Only lights with a place look
/// at something.
inline Vec3d light_direction(const Light& l) {
    const bool placed = l.type == LightType::area || l.type == LightType::spot;
    return placed && l.look_at ? Vec3d(*l.look_at - l.position) : l.direction.value_or(Vec3d(0, 0, -1));
}

/// The group of what camera rays see where there is no sky: of no light.
inline constexpr const char* kBackgroundGroup = "background";
inline const std::string& group_of(const Light& l) { return l.group.empty() ? l.name : l.group; }

enum class AppearanceType { diffuse, plastic, conductor, dielectric };
template <>
struct Words<AppearanceType> {
    static constexpr std::array<std::string_view, 4> list{"diffuse", "plastic", "conductor", "dielectric"};
};
enum class ColourBy { none, temperature, speed, vertices };
template <>
struct Words<ColourBy> {
    static constexpr std::array<std::string_view, 4> list{"none", "temperature", "speed", "vertices"};
};
enum class Space { world, rest };
template <>
struct Words<Space> {
    static constexpr std::array<std::string_view, 2> list{"world", "rest"};
};

struct ColourStop {
    double at = 0;  // of the attribute
    Vec3d colour{0.8, 0.8, 0.8};
};
template <class V>
void visit(V& v, ColourStop& c) {
    v.key("at", c.at, "degC or m/s", required(), "value of the attribute; ascending in the list");
    v.key("colour", c.colour, kColour, required(between(0, 1)), "colour there; between two stops it is mixed");
}

enum class Mapping { planar, box, cylinder, uv };
template <>
struct Words<Mapping> {
    static constexpr std::array<std::string_view, 4> list{"planar", "box", "cylinder", "uv"};
};
struct ImageTexture {
    std::string file;     // empty: none
    std::string content;  // hash of the file's bytes, filled in when the look is read
    Mapping mapping = Mapping::planar;
    Axis axis = Axis::z;    // planar: projected along it; cylinder: wound about it
    Vec3d origin{0, 0, 0};  // m, of the picture's lower left corner
    Vec2d size{1, 1};       // m, of one picture; uv: in uv
};
template <class V>
void visit(V& v, ImageTexture& t) {
    v.file("file", t.file, any(),
           "PNG or JPEG (sRGB), EXR or Radiance HDR (linear, from 0 to 1), repeated without end; none: no picture");
    v.key("content", t.content, "", any(),
          "hash of the file's bytes, filled in when the scene is read; where given, the file must match");
    v.key(
        "mapping", t.mapping, "", any(),
        "planar: projected along `axis`; box: along the axis nearest to the normal; cylinder: wound once about `axis`; "
        "uv: by the texture coordinates of a mesh");
    v.key("axis", t.axis, "", any(),
          "planar: projected along it (right and up in the picture are y z, x z or x y); cylinder: wound about it");
    v.key("origin", t.origin, "m", any(),
          "place of the lower left corner, in the space of `space`; cylinder: of its foot on the axis");
    v.key("size", t.size, "m", above(0),
          "width and height of one picture; uv: in uv; cylinder: the height alone counts");
}

struct Bumps {
    double amplitude = 0;  // m
    double scale = 0.01;   // m
    int octaves = 4;
};
template <class V>
void visit(V& v, Bumps& b) {
    v.key("amplitude", b.amplitude, "m", at_least(0), "height of the largest bumps; 0: none");
    v.key("scale", b.scale, "m", above(0), "width of the largest bumps");
    v.key("octaves", b.octaves, "", between(1, 16),
          "layers of noise, each half as wide and half as high as the one before");
}

/// Light that a surface gives by itself, to all sides, beside what it scatters.
struct Glow {
    double strength = 0;    // W/(m^2 sr)
    Vec3d colour{1, 1, 1};  // linear Rec.709
    double black_body = 0;  // degC; 0: every place glows alike
};
/// From here on a black body may be told to have `strength`. Matter begins to be seen in the dark at 525 degC.
inline constexpr double kColdestGlow = 400;  // degC
template <class V>
void visit(V& v, Glow& g) {
    v.key("strength", g.strength, "W/(m^2 sr)", at_least(0),
          "radiance, times `colour` in red, green and blue; 0: it does not glow");
    v.key("colour", g.colour, kColour, at_least(0), "colour, linear Rec.709; with `black_body` a factor of its colour");
    v.key("black_body", g.black_body, "degC", between(0, 1e5),
          "temperature at which the luminance is `strength`, from 400 on: the light of every place then has colour and "
          "luminance of a black body of the temperature there (Planck). What is cooler is redder and darker. 0: all "
          "places glow alike");
}

struct Appearance {
    std::string name;
    AppearanceType type = AppearanceType::diffuse;
    Vec3d colour{0.8, 0.8, 0.8};   // albedo, or reflectance at normal incidence of a conductor
    Vec3d colour2{0.3, 0.3, 0.3};  // second colour of a checker
    double checker = 0;            // m, edge of a checker field in xy; 0: plain
    Space space = Space::world;
    ColourBy colour_by = ColourBy::none;
    std::vector<ColourStop> colour_map;
    ImageTexture image;
    std::string inside;  // appearance of fresh faces of cracks; empty: this one
    Bumps bumps;
    Glow glow;
    double roughness = 0;  // GGX alpha; 0: smooth
    double ior = 1.5;
    Vec3d absorption{0, 0, 0};  // 1/m, dielectric
    int priority = 0;           // nested dielectrics: the higher wins where two overlap
};
template <class V>
void visit(V& v, Appearance& a) {
    v.key("type", a.type, "", any(),
          "diffuse: matt; plastic: matt under a clear coat; "
          "conductor: metal; dielectric: water, glass");
    v.key("colour", a.colour, kColour, between(0, 1),
          "albedo, linear Rec.709; of a conductor its reflectance at normal incidence");
    v.key("colour2", a.colour2, kColour, between(0, 1), "second colour of a checker");
    v.key("checker", a.checker, "m", at_least(0), "edge of the fields of a checker in xy; 0: plain");
    v.key("space", a.space, "", any(),
          "of checker and image; world: they stand still; rest: they move with the material");
    v.key("colour_by", a.colour_by, "", any(),
          "attribute that `colour_map` colours by; vertices: the colours of a mesh's vertices, `colour` where it has "
          "none; none: `colour`");
    v.list("colour_map", a.colour_map, "colours of the values of `colour_by`");
    v.block("image", a.image, "picture in place of `colour`");
    v.reference("inside", a.inside, Refers::appearance, any(),
                "appearance of what a crack lays open; left out: the same as outside");
    v.block("bumps", a.bumps, "fractal noise in the material that roughens the look of the surface");
    v.block(
        "glow", a.glow,
        "light that the surface gives by itself, beside what it scatters; of no dielectric. Paths meet it by chance "
        "alone: what glows small and bright lights other things with much noise");
    v.key("roughness", a.roughness, "1", between(0, 1), "GGX alpha; 0: smooth");
    v.key("ior", a.ior, "1", between(1, 4), "index of refraction of plastic and dielectric; water 1.33, glass 1.5");
    v.key("absorption", a.absorption, "1/m", at_least(0),
          "dielectric: loss of red, green and blue along the way inside");
    v.key("priority", a.priority, "", between(-1000, 1000), "nested dielectrics: the higher wins where two overlap");
}

/// The group of all that glows.
inline constexpr const char* kGlowGroup = "glow";
inline bool glows(const Appearance& a) { return a.glow.strength > 0; }

enum class ViewTransform { srgb, filmic };
template <>
struct Words<ViewTransform> {
    static constexpr std::array<std::string_view, 2> list{"srgb", "filmic"};
};
/// Passes that are written only where they are asked for: they cost time or much room.
struct Passes {
    bool position = false, motion = false, body = false, sheet = false, cryptomatte = false, lights = false;
};
template <class V>
void visit(V& v, Passes& p) {
    v.key("position", p.position, "", any(), "true: P.X/Y/Z, where in the world [m]");
    v.key("motion", p.motion, "", any(),
          "true: motion.X/Y, the way to the next frame in pixels to the right and up, and motion.Z/W, that to the "
          "frame before");
    v.key("body", p.body, "", any(), "true: body, the id of the body in the cache; -1 where there is none");
    v.key("sheet", p.sheet, "", any(),
          "true: sheet, the number of the face of the body; of cracks from 1048576 on; -1 on meshes and where there is "
          "none");
    v.key("cryptomatte", p.cryptomatte, "", any(),
          "true: CryptoObject and CryptoMaterial, mattes by the names of bodies and boundaries and of appearances");
    v.key("lights", p.lights, "", any(),
          "true: light_<group>.R/G/B, what each group of lights gives to the picture, and what glows; `thixo relight` "
          "mixes them");
}

struct Output {
    int width = 960, height = 540;
    int samples = 64;
    double noise = 0;
    int max_bounces = 12;
    double exposure = 0;  // stops, PNG and film only
    ViewTransform view = ViewTransform::filmic;
    bool straight_shadows = true;  // shadow rays go straight through smooth dielectrics (a documented bias)
    double clamp = 20;             // indirect radiance of one sample is limited to this; 0: no limit
    bool transparent_background = false;
    bool denoise = false;
    bool film = true;  // encode an mp4
    Passes passes;
};
template <class V>
void visit(V& v, Output& o) {
    v.key("width", o.width, "pixels", between(1, 32768), "width of the picture");
    v.key("height", o.height, "pixels", between(1, 32768), "height of the picture");
    v.key("samples", o.samples, "", between(1, 1000000), "light paths per pixel; with `noise`, at most");
    v.key("noise", o.noise, "1", between(0, 1),
          "visible noise at which a tile of 16 x 16 pixels has enough samples, as a part of white on a display; 0.01 "
          "is clean; "
          "0: every pixel gets all samples");
    v.key("max_bounces", o.max_bounces, "", between(0, 1000), "longest path, in hits; total reflections do not count");
    v.key("exposure", o.exposure, "stops", between(-50, 50), "brightness of PNG and film; EXR is untouched");
    v.key("view", o.view, "", any(), "view transform of PNG and film");
    v.key("straight_shadows", o.straight_shadows, "", any(),
          "true: light goes straight through smooth dielectrics to a shaded point, which is brighter and less noisy "
          "than true caustics");
    v.key("clamp", o.clamp, "W/(m^2 sr)", at_least(0), "limit of the indirect radiance of one sample; 0: no limit");
    v.key("transparent_background", o.transparent_background, "", any(), "true: alpha 0 where nothing is hit");
    v.key("denoise", o.denoise, "", any(),
          "true: takes the noise from the picture, which stays in the EXR as noisy.R/G/B; needs 2 samples");
    v.key("film", o.film, "", any(), "true: encode an mp4 of all frames");
    v.block("passes", o.passes, "channels of the EXR beside those that are always there");
}

struct Look {
    Camera camera;
    std::vector<Light> lights;
    std::vector<Appearance> appearances;
    Vec3d background{0.8, 0.85, 0.9};  // seen by camera rays where no light's environment is
    Output output;
};
/// Whether anything in it glows.
inline bool glows(const Look& look) {
    return std::ranges::any_of(look.appearances, [](const Appearance& a) { return glows(a); });
}
template <class V>
void visit(V& v, Look& l) {
    v.block("camera", l.camera,
            "the camera; without position and look_at it sees the whole scene from in front and above");
    v.named("lights", l.lights, "lights; left out: a sky and a sun, which go once a look file names lights; {}: none");
    v.named("appearances", l.appearances,
            "how surfaces look; materials, bodies and boundaries refer to them by name. What has none gets one: thin "
            "liquids "
            "like water, thick ones and solids coloured, boundaries grey");
    v.key("background", l.background, kColour, at_least(0), "radiance the camera sees where there is no sky");
    v.block("output", l.output, "the pictures");
}

}  // namespace thixo::scene
