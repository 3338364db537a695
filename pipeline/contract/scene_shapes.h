// Shapes of the scene file: one key names the kind, modifiers stand beside it.
#pragma once

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "pipeline/base/math.h"
#include "pipeline/contract/scene_key.h"

namespace thixo::scene {

struct Shape;

struct Sphere {
    double radius = 0.5;  // m
};
template <class V>
void visit(V& v, Sphere& s) {
    v.key("radius", s.radius, "m", above(0), "radius; the centre is the origin");
}

struct Ellipsoid {
    Vec3d radii{0.5, 0.5, 0.5};  // m
};
template <class V>
void visit(V& v, Ellipsoid& s) {
    v.key("radii", s.radii, "m", above(0), "half-axes along x, y, z; the centre is the origin");
}

struct BoxShape {
    Vec3d size{1, 1, 1};  // m
    double rounding = 0;  // m
};
template <class V>
void visit(V& v, BoxShape& s) {
    v.key("size", s.size, "m", above(0), "edge lengths along x, y, z; the centre is the origin");
    v.key("rounding", s.rounding, "m", at_least(0), "radius of the rounded edges, at most half the shortest edge");
}

struct Cylinder {                     // axis z, centred
    double radius = 0.5, height = 1;  // m
    double rounding = 0;              // m
};
template <class V>
void visit(V& v, Cylinder& s) {
    v.key("radius", s.radius, "m", above(0), "radius about the z axis");
    v.key("height", s.height, "m", above(0), "whole height; the centre is the origin");
    v.key("rounding", s.rounding, "m", at_least(0),
          "radius of the rounded rims, at most the radius and half the height");
}

struct RoundedCone {                                   // two spheres and their hull, axis z from the origin
    double radius1 = 0.5, radius2 = 0.25, height = 1;  // m
};
template <class V>
void visit(V& v, RoundedCone& s) {
    v.key("radius1", s.radius1, "m", above(0), "radius of the sphere at the origin");
    v.key("radius2", s.radius2, "m", above(0), "radius of the sphere at (0, 0, height)");
    v.key("height", s.height, "m", above(0), "distance of the two centres");
}

struct Capsule {
    Vec3d from{0, 0, 0}, to{0, 0, 1};  // m
    double radius = 0.25;              // m
};
template <class V>
void visit(V& v, Capsule& s) {
    v.key("from", s.from, "m", any(), "centre of the first end");
    v.key("to", s.to, "m", any(), "centre of the second end");
    v.key("radius", s.radius, "m", above(0), "radius");
}

struct Torus {                        // axis z
    double radius = 0.5, tube = 0.1;  // m
};
template <class V>
void visit(V& v, Torus& s) {
    v.key("radius", s.radius, "m", above(0), "radius of the ring about the z axis");
    v.key("tube", s.tube, "m", above(0), "radius of the tube, at most the ring's");
}

struct Plane {  // solid where n.x < offset, n = normal/|normal|
    Vec3d normal{0, 0, 1};
    double offset = 0;  // m
};
template <class V>
void visit(V& v, Plane& s) {
    v.key("normal", s.normal, "", direction(), "direction away from the solid half-space; any length");
    v.key("offset", s.offset, "m", any(), "distance of the plane from the origin along its normal");
}

struct Revolve {                 // closed polygon (r >= 0, z) turned about z
    std::vector<Vec2d> profile;  // m
};
template <class V>
void visit(V& v, Revolve& s) {
    v.key("profile", s.profile, "m", required(),
          "closed polygon of points [r, z] with r >= 0, turned about the z axis");
}

struct SweepPoint {
    Vec3d at{0, 0, 0};    // m
    double radius = 0.1;  // m
};
template <class V>
void visit(V& v, SweepPoint& p) {
    v.key("at", p.at, "m", required(), "a point of the curve");
    v.key("radius", p.radius, "m", above(0), "radius there");
}
struct Sweep {  // a ball along a smooth curve
    std::vector<SweepPoint> points;
    bool closed = false;
};
template <class V>
void visit(V& v, Sweep& s) {
    v.list("points", s.points, "points the curve runs through, at least two (closed: three)");
    v.key("closed", s.closed, "", any(), "true: the curve runs back to its first point");
}

/// Which point of a mesh comes to the origin.
enum class Place { file, base, centre };
template <>
struct Words<Place> {
    static constexpr std::array<std::string_view, 3> list{"file", "base", "centre"};
};

struct MeshFile {  // file units carry no size: one of scale, height
    std::string file;
    double scale = 0;   // m per file unit; 0: from height
    double height = 0;  // m; 0: from scale
    Place place = Place::file;
    std::string content;   // hash of the file's bytes, filled in when the scene is loaded
    Vec3d shift{0, 0, 0};  // m, after the scale; no key, see scene_origin.h
};
template <class V>
void visit(V& v, MeshFile& s) {
    v.file("file", s.file, required(),
           "closed triangle mesh (OBJ, PLY or STL), or a closed surface of points with normals (PLY)");
    v.key("scale", s.scale, "m", at_least(0), "length of one unit of the file; 0: from height");
    v.key("height", s.height, "m", at_least(0), "extent along z after reading; 0: from scale");
    v.key("place", s.place, "", any(),
          "what comes to the origin: the file's own origin, the middle of the lowest face of its box, or the box's "
          "centre");
    v.key("content", s.content, "", any(),
          "hash of the file's bytes, filled in when the scene is read; where given, the file must match");
}

struct ShapeList {
    std::vector<Shape> shapes;
    double smooth = 0;  // blending radius [m]
};
struct Union : ShapeList {};
struct Intersection : ShapeList {};
struct Difference : ShapeList {};  // the first less all others
struct Mirror : ShapeList {        // the shapes and their image
    Vec3d normal{1, 0, 0};
    double offset = 0;  // m
};
struct Repeat : ShapeList {  // copies in a row, in a ring or on a stair
    int count = 2;
    Vec3d step{0, 0, 0};  // m
    double turn = 0;      // degrees about z
};
struct Twist : ShapeList {
    double rate = 90;  // degrees/m
};
struct Bend : ShapeList {
    double angle = 45;  // degrees
};
struct Noise : ShapeList {
    double amplitude = 0.01, scale = 0.1;  // m
    int octaves = 4;
};
struct NamedShape {  // an entry of `shapes`
    std::string name;
};
template <class V>
void visit(V& v, ShapeList& s) {
    v.shapes("shapes", s.shapes, required(), "the shapes that are combined");
    v.key("smooth", s.smooth, "m", at_least(0), "blending radius where two of them meet; 0: a sharp edge");
}
template <class V>
void visit(V& v, Mirror& s) {
    visit(v, static_cast<ShapeList&>(s));
    v.key("normal", s.normal, "", direction(), "direction across the mirror; any length");
    v.key("offset", s.offset, "m", any(), "distance of the mirror from the origin along its normal");
}
template <class V>
void visit(V& v, Repeat& s) {
    visit(v, static_cast<ShapeList&>(s));
    v.key("count", s.count, "", between(1, 10000), "number of copies, the first one in place");
    v.key("step", s.step, "m", any(), "shift from a copy to the next");
    v.key("turn", s.turn, "degrees", any(), "turn about z from a copy to the next, before the shift");
}
template <class V>
void visit(V& v, Twist& s) {
    visit(v, static_cast<ShapeList&>(s));
    v.key("rate", s.rate, "degrees/m", any(), "turn about z over a metre of height");
}
template <class V>
void visit(V& v, Bend& s) {
    visit(v, static_cast<ShapeList&>(s));
    v.key("angle", s.angle, "degrees", between(-180, 180),
          "bends the z axis, from the lowest to the highest point, into an arc of this angle towards x");
}
template <class V>
void visit(V& v, Noise& s) {
    visit(v, static_cast<ShapeList&>(s));
    v.key("amplitude", s.amplitude, "m", any(), "about how far the surface is raised and pressed in");
    v.key("scale", s.scale, "m", above(0), "width of the largest bumps");
    v.key("octaves", s.octaves, "", between(1, 12),
          "layers of bumps, each half as wide and half as high as the one before");
}
template <class V>
void visit(V& v, NamedShape& s) {
    v.reference("name", s.name, Refers::shape, required(), "an entry of the top-level block `shapes`");
}

struct Shape {
    std::variant<std::monostate, Sphere, Ellipsoid, BoxShape, Cylinder, RoundedCone, Capsule, Torus, Plane, Revolve,
                 Sweep, MeshFile, Union, Intersection, Difference, Mirror, Repeat, Twist, Bend, Noise, NamedShape>
        kind;
    double scale = 1;          // applied first
    Vec3d rotate{0, 0, 0};     // degrees about x, then y, then z; applied second
    Vec3d translate{0, 0, 0};  // m; applied last
    double offset = 0;         // m, grows (> 0) or shrinks the shape
    double shell = 0;          // m, > 0: a hollow shell of this thickness, inwards from the surface
    std::string where;         // file:line:column, for messages
};
/// The modifiers; the kinds are for_each_shape_kind's.
template <class V>
void visit(V& v, Shape& s) {
    v.key("scale", s.scale, "1", above(0), "factor on the size, applied first");
    v.key("rotate", s.rotate, "degrees", any(), "turn about x, then y, then z, applied second");
    v.key("translate", s.translate, "m", any(), "shift, applied last");
    v.key("offset", s.offset, "m", any(), "grows (above 0) or shrinks (below 0) the shape by this distance");
    v.key("shell", s.shell, "m", at_least(0), "thickness of a hollow shell, inwards from the surface; 0: solid");
}

template <class K>
struct ShapeKind {
    using Type = K;
    std::string_view name;
    std::string_view
        short_key;  // the key meant where the kind is given a list or a word in place of a block; empty: none
    std::string_view meaning;
};

/// f(ShapeKind<K>) for every kind.
template <class F>
void for_each_shape_kind(F&& f) {
    f(ShapeKind<Sphere>{"sphere", "", "ball"});
    f(ShapeKind<Ellipsoid>{"ellipsoid", "", "ellipsoid"});
    f(ShapeKind<BoxShape>{"box", "", "box along the axes"});
    f(ShapeKind<Cylinder>{"cylinder", "", "cylinder along z"});
    f(ShapeKind<RoundedCone>{"rounded_cone", "", "hull of two spheres"});
    f(ShapeKind<Capsule>{"capsule", "", "cylinder with round ends"});
    f(ShapeKind<Torus>{"torus", "", "ring about z"});
    f(ShapeKind<Plane>{"plane", "", "half-space"});
    f(ShapeKind<Revolve>{"revolve", "profile", "polygon turned about z, such as a glass"});
    f(ShapeKind<Sweep>{"sweep", "", "ball along a smooth curve, such as an arm"});
    f(ShapeKind<MeshFile>{"mesh", "", "closed mesh or point set from a file"});
    f(ShapeKind<Union>{"union", "shapes", "what is in any of the shapes"});
    f(ShapeKind<Intersection>{"intersection", "shapes", "what is in all of the shapes"});
    f(ShapeKind<Difference>{"difference", "shapes", "the first shape less all others"});
    f(ShapeKind<Mirror>{"mirror", "shapes", "the shapes and their image in a plane"});
    f(ShapeKind<Repeat>{"repeat", "shapes", "copies of the shapes in a row, a ring or a screw"});
    f(ShapeKind<Twist>{"twist", "shapes", "the shapes turned about z more and more with their height"});
    f(ShapeKind<Bend>{"bend", "shapes", "the shapes bent along z"});
    f(ShapeKind<Noise>{"noise", "shapes", "the shapes with bumps of fractal noise"});
    f(ShapeKind<NamedShape>{"named", "name", "an entry of the top-level block `shapes`"});
}

}  // namespace thixo::scene
