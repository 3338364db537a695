// Solid bodies: connected pieces of matter.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "pipeline/geometry/shape.h"
#include "sim/state/elements.h"

namespace thixo {

/// The kind of a body's surfels.
enum class Skin : std::uint8_t {
    embedded,  // bound to the body's first rest shape
    animated,  // moved with the particles, deformed and resampled: the body has begun to melt
    rebound    // animated surfels bound to the rest shape in which the body has frozen
};

/// The material frame is the first rest shape about its centre of mass. The present rest shape, rotated and moved to
/// fit the deformed body (dissertation 5.4.3), is that frame in the pose x = R m + t. Everything bound to the matter is
/// in the material frame, and never turned in it. A body that split off shares its parent's frame.
struct SolidBody {
    std::int32_t id = 0;        // for ever: Particles::body of its particles, and of the frame; -1: matter of emitters
    std::int32_t parent = -1;   // id of the body it split from; -1: none
    std::int32_t source = 0;    // index into Scene::bodies; -1: matter of emitters, which has no rest shape
    std::int32_t frame = 0;     // of the rest shape: its pieces share it. The source, or one in which it has frozen
    std::int32_t material = 0;  // index into Scene::materials
    Skin skin = Skin::embedded;
    bool refrozen = false;          // its rest shape is one in which it has frozen
    std::vector<Index> elements{};  // ascending
    Index typical = 0;              // an element whose width and support are those at the surface
    Index lightest = 0;
    Mat3d turn = Mat3d::Identity();  // R
    Vec3d place{0, 0, 0};            // t [m]
    // The first rest shape, in the world at time 0: the scene's, or, for a body that has split, that of its surfels.
    // Without one the body meets others element by element.
    std::optional<Shape> shape{};
    bool scene_shape = true;           // the shape is the scene's, unchanged by splits
    std::vector<std::int32_t> cuts{};  // sheets along which the body was cut: it lies behind each
    Vec3 origin{0, 0, 0};              // of the material frame there [m]
    // It goes on through periodic faces, and its shape with it. It never turns: its images would turn about themselves.
    bool endless = false;
    // Too small to be elastic: it moves as one piece, in the shape in which it broke off (fracture/rigid_fragments.h).
    bool rigid = false;

    std::size_t size() const { return elements.size(); }
    bool empty() const { return elements.empty(); }
    /// Whether the body has a rest shape.
    bool shaped() const { return source >= 0; }
};

/// A body's pose in the numbers of the state.
struct BodyPose {
    Mat3 turn;
    Vec3 place;
};
inline std::vector<BodyPose> poses_of(const std::vector<SolidBody>& bodies) {
    std::vector<BodyPose> poses;
    for (const SolidBody& b : bodies) poses.push_back({b.turn.cast<Real>(), b.place.cast<Real>()});
    return poses;
}

/// The rest places of a body's elements, in their order [m].
inline std::vector<Vec3> rest_places(const SolidBody& body, const Elements& e) {
    std::vector<Vec3> place;
    place.reserve(body.size());
    for (const Index i : body.elements) place.push_back(xyz(e.rest[i]));
    return place;
}

}  // namespace thixo
