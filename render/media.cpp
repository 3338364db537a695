#include "render/media.h"

namespace thixo::render {

Index medium_of(const World& world, const Interior& interior) {
    Index best = kNone;
    for (int i = 0; i < interior.count(); ++i)
        if (best == kNone || world.medium(interior[i]).priority > world.medium(best).priority) best = interior[i];
    return best;
}

float ior_of(const World& world, Index medium) { return medium == kNone ? 1.0f : world.medium(medium).ior; }

namespace {

/// Where the ray, which starts inside, leaves the box.
float way_out(const Box3& box, const Ray& ray) {
    float t = kInfinity;
    for (int k = 0; k < 3; ++k) {
        const float d = ray.direction[k], side = d > 0 ? box.upper[k] : box.lower[k];
        if (d != 0) t = std::min(t, (side - ray.origin[k]) / d);
    }
    return t;
}

}  // namespace

Vec3f absorb(const World& world, Interior& interior, const Ray& ray, float from, float to) {
    if (interior.count() == 0) return Vec3f::Ones();
    const Index medium = medium_of(world, interior);
    const float end = std::min(to, way_out(world.rays->bounds(medium), ray));
    const Vec3f left = (-world.medium(medium).absorption.array() * std::max(0.0f, end - from)).exp().matrix();
    for (int i = interior.count() - 1; i >= 0; --i)
        if (way_out(world.rays->bounds(interior[i]), ray) < to) interior.remove(interior[i]);
    return left;
}

Interface interface_at(const World& world, const Interior& interior, const Hit& hit) {
    Interface result;
    result.behind = interior;
    if (hit.entering)
        result.behind.add(hit.object);
    else
        result.behind.remove(hit.object);
    result.before = ior_of(world, medium_of(world, interior));
    result.after = ior_of(world, medium_of(world, result.behind));
    result.real = result.before != result.after;
    return result;
}

namespace {

/// Distance to the first surface of `object` met by a ray that takes itself to be inside it (or not).
float first_crossing_of(const World& world, Index object, bool inside, const Vec3f& point) {
    Interior interior;
    if (inside) interior.add(object);
    Ray ray;
    ray.origin = point;
    ray.direction = Vec3f(0.12f, 0.23f, 0.96f).normalized();
    ray.time = world.shutter.frame_time();
    Hit hit;
    for (int hits = 0; hits < 256 && world.rays->intersect(ray, interior, hit); ++hits) {
        if (hit.object == object) return hit.t;
        ray.tmin = std::nextafter(hit.t, kInfinity);
        // Others are walked through: what has been entered is left again.
        if (world.material(hit.object).dielectric())
            hit.entering ? interior.add(hit.object) : interior.remove(hit.object);
    }
    return kInfinity;
}

}  // namespace

Interior interior_at(const World& world, const Vec3f& point) {
    Interior interior;
    for (Index object = 0; object < world.material_of.size(); ++object) {
        const Box3& box = world.rays->bounds(object);
        if (!world.material(object).dielectric() || (point.array() < box.lower.array()).any() ||
            (point.array() > box.upper.array()).any())
            continue;
        if (first_crossing_of(world, object, true, point) < first_crossing_of(world, object, false, point))
            interior.add(object);
    }
    return interior;
}

bool nearest_hit(const World& world, const Ray& ray, const Interior& interior, Hit& hit) {
    if (!world.rays->intersect(ray, interior, hit, world.attributes)) return false;
    if (hit.blended || hit.entering || !world.material(hit.object).dielectric()) return true;
    Interior behind = interior;
    behind.remove(hit.object);
    Ray probe = ray;
    const float touching = 10 * hit.rounding / std::max(0.05f, std::abs(hit.geometric.dot(ray.direction)));
    probe.tmin = std::max(ray.tmin, hit.t - touching);
    probe.tmax = hit.t + touching;
    Hit touched;
    if (world.rays->intersect(probe, behind, touched, world.attributes) && !world.material(touched.object).dielectric())
        hit = touched;
    return true;
}

}  // namespace thixo::render
