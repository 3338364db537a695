// What the scene file says of bodies that keep a shape: their materials' elastic keys, and handles that hold them.
#pragma once

#include <string>
#include <vector>

#include "pipeline/base/math.h"
#include "pipeline/contract/scene_key.h"
#include "pipeline/contract/scene_motion.h"
#include "pipeline/contract/scene_shapes.h"

namespace thixo::scene {

struct MaterialChange {
    double time = 0;       // s, when it is complete
    double duration = 0;   // s, before that
    std::string material;  // whose elastic values hold from then on
};
template <class V>
void visit(V& v, MaterialChange& c) {
    v.key("time", c.time, "s", required(at_least(0)), "instant from which the new values hold; ascending in the list");
    v.key("duration", c.duration, "s", at_least(0),
          "time before it in which the values go over, linearly; 0: a switch");
    v.reference("material", c.material, Refers::material, required(),
                "material whose elastic values, viscosity and friction are taken over; density and look stay");
}

/// Three planes of symmetry, as wood or fibres have them. Axes 1, 2, 3 are x, y, z of the body's shape, turned.
struct Orthotropic {
    Vec3d youngs_modulus{0, 0, 0};       // E1, E2, E3 [Pa]; 0: isotropic
    Vec3d shear_modulus{0, 0, 0};        // G12, G23, G31 [Pa]
    Vec3d poisson_ratio{0.3, 0.3, 0.3};  // nu12, nu23, nu31 [1]
    Vec3d rotate{0, 0, 0};               // deg
    bool any() const { return !youngs_modulus.isZero(); }
};
template <class V>
void visit(V& v, Orthotropic& o) {
    v.key("youngs_modulus", o.youngs_modulus, "Pa", between(0, 1e13),
          "E1, E2, E3 along the three axes; zeros: isotropic");
    v.key("shear_modulus", o.shear_modulus, "Pa", between(0, 1e13), "G12, G23, G31");
    v.key("poisson_ratio", o.poisson_ratio, "1", between(-10, 10),
          "nu12, nu23, nu31: how much axis b narrows when a is stretched, for ab = 12, 23, 31");
    v.key("rotate", o.rotate, "deg", between(-1e6, 1e6),
          "turns the axes 1, 2, 3 from x, y, z of the body's own shape, about x, then y, then z");
}

/// Which part of the elastic strain beyond the yield surface becomes permanent.
enum class Flow { total, deviatoric };
template <>
struct Words<Flow> {
    static constexpr std::array<std::string_view, 2> list{"total", "deviatoric"};
};

struct Elastic {
    double youngs_modulus = 0;          // E [Pa]; 0: a liquid
    double poisson_ratio = 0.3;         // nu [1]
    double volume_stiffness = 0;        // k_v [Pa]
    double zero_energy = 0.1;           // 1
    double yield_strain = 0;            // k_yield [1]
    double creep = 0;                   // k_creep [1/s]
    double hardening = 0;               // k_hardening [1]
    Flow flow = Flow::total;            // what becomes permanent
    double maximum_plastic_strain = 0;  // 1; 0: no limit
    double friction = 0.3;              // Coulomb's mu [1]
    double contact_damping = 0.5;       // of critical [1]
    double contact_stiffness = 0;       // Pa/m; 0: (lambda + 2 mu)/spacing
    Orthotropic orthotropic;
    std::vector<MaterialChange> changes;
    bool solid() const { return youngs_modulus > 0; }
};
/// Keys of a material, beside those every material has.
template <class V>
void visit(V& v, Elastic& e) {
    v.key("youngs_modulus", e.youngs_modulus, "Pa", between(0, 1e13),
          "stiffness E; above 0 the material is a solid that keeps its shape. Jelly 1e4, soft rubber 1e6");
    v.key(
        "poisson_ratio", e.poisson_ratio, "1", {.low = -1, .high = 0.5, .open_low = true, .open_high = true},
        "how much a stretched solid narrows; 0.5 would be no compression at all: write 0.49, or add volume_stiffness");
    v.key("volume_stiffness", e.volume_stiffness, "Pa", between(0, 1e13),
          "k_v, additional resistance of a solid to a change of volume; left out: E, which keeps hard impacts from "
          "turning particles inside out");
    v.key("zero_energy", e.zero_energy, "1", between(0, 10),
          "stiffness, in parts of E, against the zigzag of neighbouring particles that strain does not see");
    v.key("yield_strain", e.yield_strain, "1", between(0, 1e3),
          "elastic strain above which a solid with `creep` deforms for good");
    v.key("creep", e.creep, "1/s", between(0, 1e9),
          "rate at which strain above `yield_strain` becomes permanent, down to `yield_strain`; 0: never");
    v.key("hardening", e.hardening, "1", between(0, 1e3),
          "how much `yield_strain` grows by the strain that has become permanent, linearly; 0: never");
    v.key(
        "flow", e.flow, "", any(),
        "what becomes permanent; total: all of the strain, the volume too, as of snow and foam; deviatoric: the shape "
        "alone, as of metals and gum. Its stress at yield stays as it is drawn out, so that bars neck before they "
        "tear");
    v.key("maximum_plastic_strain", e.maximum_plastic_strain, "1", between(0, 1e3),
          "permanent strain is no larger than this; 0: no limit");
    v.key("friction", e.friction, "1", between(0, 100),
          "coefficient of Coulomb friction of a solid with walls; two solids "
          "rub with the geometric mean of theirs");
    v.key(
        "contact_damping", e.contact_damping, "1", between(0, 2),
        "part of critical damping where a solid meets a wall or another solid; 0: it bounces as its own waves let it");
    v.key("contact_stiffness", e.contact_stiffness, "Pa/m", between(0, 1e18),
          "pressure per depth with which a solid's surface resists what enters it; 0: as stiff as the layer of matter "
          "that a particle is. Higher needs shorter steps");
    v.block(
        "orthotropic", e.orthotropic,
        "a solid that is not equally stiff in all directions; contact and zero_energy go by \"youngs_modulus\" still");
    v.list("changes", e.changes, "changes of a solid's material while the scene runs");
}

/// A part of a body that is weaker or stronger than the rest of it.
struct Score {
    Shape region;
    double factor = 1;  // of the strength [1]
};
template <class V>
void visit(V& v, Score& s) {
    v.shape("region", s.region, required(), "the part, where the body stands at the start");
    v.key("factor", s.factor, "1", required(above_to(0, 1e6)), "strength of the part over that of the material");
}

/// The strength at a temperature.
struct StrengthAt {
    double temperature = 0;  // degC
    double factor = 1;       // of the strength [1]
};
template <class V>
void visit(V& v, StrengthAt& s) {
    v.key("temperature", s.temperature, "degC", required(between(-273.15, 1e5)), "ascending in the list");
    v.key("factor", s.factor, "1", required(above_to(0, 1e6)), "strength at this temperature over `strength`");
}

/// How a solid breaks (dissertation 5.6).
struct Fracture {
    double strength = 0;   // Pa; 0: it never breaks
    double arrest = 0.5;   // part of the strength [1]
    double speed = 0;      // m/s; 0: a quarter of sqrt(E/rho)
    double opacity = 1;    // kappa [1]
    double history = 0.5;  // k_hist over a particle's width [1]
    double scatter = 0;    // part of the strength [1]
    std::vector<Score> scores;
    std::vector<StrengthAt> by_temperature;
    bool any() const { return strength > 0; }
};
template <class V>
void visit(V& v, Fracture& f) {
    v.key("strength", f.strength, "Pa", between(0, 1e13),
          "tension at which a crack begins; 0: the material never breaks. Plaster 1e6, glass 5e7");
    v.key("arrest", f.arrest, "1", between(0, 1),
          "a crack rests where the tension at it is below this part of the strength");
    v.key("speed", f.speed, "m/s", between(0, 1e5),
          "speed of a crack where the tension is just the strength; 0: a quarter of sqrt(youngs_modulus/density)");
    v.key("opacity", f.opacity, "1", {.low = 0, .high = 10, .open_low = true},
          "kappa: how far behind its front a crack parts the matter fully, in supports of a particle; large is tough");
    v.key("history", f.history, "1", between(0, 1),
          "part of its direction that a crack keeps over a particle's width; 1: it runs straight");
    v.key("scatter", f.scatter, "1", {.low = 0, .high = 1, .open_high = true},
          "particles differ in strength by up to this part of it, either way");
    v.list("scores", f.scores, "parts that are weaker or stronger, such as a scored line");
    v.list(
        "by_temperature", f.by_temperature,
        "the strength at some temperatures; linear in between, the same beyond the first and last. Left out: it does "
        "not depend on the temperature");
}

struct CrackPoint {
    Vec3d at{0, 0, 0};  // m
};
template <class V>
void visit(V& v, CrackPoint& p) {
    v.key("at", p.at, "m", required(), "a point on the surface of the body, where it stands at the start");
}

/// A picture whose dark lines are cracks. It hangs in front of the body, and is projected onto it.
struct CrackImage {
    std::string file;        // empty: none
    std::string content;     // hash of the file's bytes, filled in when the scene is loaded
    Vec3d origin{0, 0, 0};   // of its lower left corner [m]
    Vec3d across{1, 0, 0};   // from there to its lower right corner [m]
    Vec3d up{0, 1, 0};       // and to its upper left corner [m]
    double threshold = 0.5;  // grey below which a pixel is of a line, 0 black, 1 white
};
template <class V>
void visit(V& v, CrackImage& i) {
    v.file("file", i.file, any(), "PNG with dark lines on light ground; none: no picture");
    v.key("content", i.content, "", any(),
          "hash of the file's bytes, filled in when the scene is read; where given, the file must match");
    v.key("origin", i.origin, "m", any(), "place of the picture's lower left corner, in front of the body");
    v.key("across", i.across, "m", any(), "from there to its lower right corner");
    v.key("up", i.up, "m", any(),
          "from there to its upper left corner. Lines are projected against `across` x `up`, which points to who looks "
          "at the picture");
    v.key("threshold", i.threshold, "1", {.low = 0, .high = 1, .open_low = true, .open_high = true},
          "a pixel that is darker is of a line; 0 is black, 1 white, by its brightness as stored");
}

/// Cracks that a body has from the start: cuts along a line on its surface, or along the lines of a picture (dissertation
/// 5.6.6).
struct PaintedCrack {
    std::vector<CrackPoint> points;
    CrackImage image;     // in place of points
    double depth = 0;     // m
    double strength = 1;  // of what its front runs through, over that of the material [1]
};
template <class V>
void visit(V& v, PaintedCrack& c) {
    v.list("points", c.points, "the line on the surface, at least two points; it ends where it began: a ring");
    v.block("image", c.image, "a picture in place of `points`: each of its lines is a crack");
    v.key("depth", c.depth, "m", required(above(0)), "how deep it is cut, straight inwards");
    v.key("strength", c.strength, "1", above_to(0, 1e6),
          "strength of what its front runs through, over that of the material");
}

/// What a material is when it has melted; its other values stay.
struct LiquidEnd {
    double viscosity = 0.001;    // Pa s
    double surface_tension = 0;  // N/m
    double youngs_modulus = 0;   // E [Pa]; 0: a liquid
    double poisson_ratio = 0.3;  // nu [1]
    double yield_strain = 0;     // k_yield [1]
    double creep = 100;          // k_creep [1/s]
};
template <class V>
void visit(V& v, LiquidEnd& e) {
    v.key("viscosity", e.viscosity, "Pa s", between(0, 1e9), "dynamic viscosity");
    v.key("surface_tension", e.surface_tension, "N/m", between(0, 1e3), "surface tension");
    v.key("youngs_modulus", e.youngs_modulus, "Pa", between(0, 1e13),
          "stiffness E that is left: above 0 the liquid is viscoelastic; 0: it keeps no shape at all");
    v.key("poisson_ratio", e.poisson_ratio, "1", {.low = -1, .high = 0.5, .open_low = true, .open_high = true},
          "Poisson's ratio");
    v.key("yield_strain", e.yield_strain, "1", between(0, 1e3), "elastic strain above which it flows");
    v.key("creep", e.creep, "1/s", between(0, 1e9), "rate at which strain above `yield_strain` is forgotten");
}

/// The two ends of a material that melts (dissertation 6.5). The material's own keys hold up to `from`, and those of
/// `liquid` hold from `to` on. In between every parameter a goes over linearly (6.16):
///
///     a = a_from + b (a_to - a_from),   b = (T - from)/(to - from)   [1]
struct Melting {
    double from = 0, to = 0;  // degC; to = from: it does not melt
    LiquidEnd liquid;
    bool any() const { return to > from; }
    /// Melt fraction b [1] at a temperature [degC].
    double fraction(double temperature) const {
        const double b = (temperature - from) / (to - from);
        return b < 0 ? 0 : b > 1 ? 1 : b;
    }
};
template <class V>
void visit(V& v, Melting& m) {
    v.key("from", m.from, "degC", between(-273.15, 1e5),
          "up to this temperature the material is the solid its own keys describe");
    v.key("to", m.to, "degC", between(-273.15, 1e5),
          "from this temperature on it is as `liquid` says; between the two its values go over linearly. Not above "
          "`from`: it never melts");
    v.block("liquid", m.liquid, "what it is when it has melted");
}

/// Holds, moves or pulls a part of a body.
struct Handle {
    std::string name, body;
    Shape region;
    std::vector<Key> motion;
    Vec3d force{0, 0, 0};          // N, of the whole region
    double start = 0, stop = 1e9;  // s
};
template <class V>
void visit(V& v, Handle& h) {
    v.reference("body", h.body, Refers::body, required(), "the solid that is held");
    v.shape("region", h.region, required(), "the part of it: particles that are in this shape at the start");
    v.list("motion", h.motion, "moves the part; left out, and without a force: it is held where it is");
    v.key("force", h.force, "N", between(-1e12, 1e12),
          "pulls at the part with this force, shared by mass, in place of holding it");
    v.key("start", h.start, "s", at_least(0),
          "time from which it acts; a part that has moved is carried on from where it is");
    v.key("stop", h.stop, "s", at_least(0), "time at which it lets go");
}

struct EdgePoint {
    Vec3d at{0, 0, 0};  // m
};
template <class V>
void visit(V& v, EdgePoint& p) {
    v.key("at", p.at, "m", required(), "a point of the edge, as it stands without its motion");
}

/// An edge that moves through a body and cuts it (dissertation 5.6.6). It pushes nothing aside.
struct Blade {
    std::string name, body;
    std::vector<EdgePoint> edge;
    Vec3d direction{0, 0, -1};  // of the cut
    std::vector<Key> motion;
    double start = 0, stop = 1e9;  // s
};
template <class V>
void visit(V& v, Blade& b) {
    v.reference("body", b.body, Refers::body, required(), "the solid that is cut, with all its pieces");
    v.list("edge", b.edge, "the cutting edge: at least two points, a line through all of them");
    v.key("direction", b.direction, "", direction(),
          "the way in which the edge cuts, as it stands without its motion. Drawn back, it cuts nothing");
    v.list("motion", b.motion, "moves the edge; left out: it rests, and cuts what moves onto it");
    v.key("start", b.start, "s", at_least(0), "time from which it cuts");
    v.key("stop", b.stop, "s", at_least(0), "time at which it stops cutting");
}

}  // namespace thixo::scene
