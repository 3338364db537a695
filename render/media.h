// Nested dielectrics by priority: Schmidt & Budge 2002, "Simple nested dielectrics in ray traced images".
#pragma once

#include "render/world.h"

namespace thixo::render {

/// The object whose medium fills a place inside of all these: the highest priority; among equals the one entered first.
/// kNone: air.
Index medium_of(const World& world, const Interior& interior);

float ior_of(const World& world, Index medium);

/// Share of light left, per colour, after the way from `from` to `to` along a ray that is inside these objects
/// (Beer-Lambert). The ray may have left the bounds of an object by then: it went through a gap in its surface. Such an
/// object is removed, and its medium counts up to the bounds.
Vec3f absorb(const World& world, Interior& interior, const Ray& ray, float from, float to);

/// What a ray does to the media around it when it goes through a dielectric's surface.
struct Interface {
    Interior behind;              // what it is inside of then
    float before = 1, after = 1;  // indices of refraction
    bool real = false;  // false: another object of higher priority fills both sides, or both are the same; light goes
                        // straight on
};
Interface interface_at(const World& world, const Interior& interior, const Hit& hit);

/// The objects a point is inside of, by the first crossing of each along a ray.
Interior interior_at(const World& world, const Vec3f& point);

/// Nearest hit, with one rule more than RayScene::intersect. The far side of a transparent mesh may touch something
/// opaque, as a glass touches a table. Then the opaque surface is hit, without a film of air in between.
bool nearest_hit(const World& world, const Ray& ray, const Interior& interior, Hit& hit);

}  // namespace thixo::render
