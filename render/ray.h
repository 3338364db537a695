// Rays, what they hit, and what they are inside of.
#pragma once

#include <array>
#include <limits>

#include "pipeline/base/math.h"

namespace thixo::render {

inline constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Points of a ray are
///   x(t) = origin + t direction,   tmin <= t <= tmax   [m].
/// Requires a unit direction.
struct Ray {
    Vec3f origin{0, 0, 0};
    Vec3f direction{0, 0, 1};
    float tmin = 0;
    float tmax = kInfinity;
    bool bounced = false;  // it starts where one has just bounced off (see kStart in surfel_blend.cpp)
    float time = 0;        // part of the shutter's time, 0 to 1; all rays of a path have one
};

/// The closed objects a ray is inside of, in the order of entering. What does not fit is dropped: eight nested objects
/// are more than any picture has, and losing one costs a shade, not the frame.
class Interior {
  public:
    bool contains(Index object) const {
        for (int i = 0; i < count_; ++i)
            if (objects_[i] == object) return true;
        return false;
    }
    void add(Index object) {
        if (count_ < kCapacity && !contains(object)) objects_[count_++] = object;
    }
    void remove(Index object) {
        int kept = 0;
        for (int i = 0; i < count_; ++i)
            if (objects_[i] != object) objects_[kept++] = objects_[i];
        count_ = kept;
    }
    int count() const { return count_; }
    Index operator[](int i) const { return objects_[i]; }

  private:
    static constexpr int kCapacity = 8;
    std::array<Index, kCapacity> objects_{};
    int count_ = 0;
};

/// What a hit knows of the material there. On surfels: blended with the weights that placed the hit, m0 to first order
/// in the tangent plane. On meshes: m0 is the place in the mesh's own frame, the rest is zero.
struct Attributes {
    Vec3f rest{0, 0, 0};                     // m0 [m]
    Vec3f rest_a{0, 0, 0}, rest_b{0, 0, 0};  // its derivatives along orthonormal_basis(normal) [1]
    Vec2f uv{0, 0};                          // of a mesh that has them
    float uv_per_metre = 0;                  // how much of uv a metre of the surface holds
    Vec3f velocity{0, 0, 0};                 // [m/s]
    float temperature = 0;                   // [degC]
    Vec3f colour{-1, -1, -1};                // of a mesh's vertices, linear; below 0 where there is none
};

struct Hit {
    float t = kInfinity;        // [m]
    Vec3f position{0, 0, 0};    // [m]
    Vec3f normal{0, 0, 1};      // for shading, unit, outward of the object
    Vec3f geometric{0, 0, 1};   // of the surface itself, unit, outward; tells the side
    Index object = kNone;       // index of the object in the scene
    std::int32_t sheet = -1;    // of the surfels; -1: a mesh
    bool entering = true;       // the ray goes from outside to inside
    bool blended = false;       // on surfels, not on a mesh
    float offset = 0;           // rays that bounce off start this far from the surface [m]
    float rounding = 0;         // of the position [m]
    float footprint = 0;        // width of what a pixel sees there, across the ray [m]
    Vec3f slant{0, 0, 0};       // by how much that is longer along the surface, away from the ray [m]
    Vec3f rest_slant{0, 0, 0};  // the same in m0
    Attributes attributes;      // where they were asked for
};

/// Where a ray that bounces off towards `direction` starts: clear of the surface, on the side it goes to.
inline Vec3f leave(const Hit& hit, const Vec3f& direction) {
    return hit.position + hit.geometric * (hit.geometric.dot(direction) > 0 ? hit.offset : -hit.offset);
}

/// Where a ray that came along `direction` and goes through the surface starts. It is a rounding before the surface, so
/// that the ray meets whatever touches it there. The surface itself it cannot meet again: it is on the other side now
/// (RayScene::intersect).
inline Vec3f pass(const Hit& hit, const Vec3f& direction) {
    return hit.position + hit.geometric * (hit.geometric.dot(direction) > 0 ? -hit.rounding : hit.rounding);
}

}  // namespace thixo::render
