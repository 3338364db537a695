#include "render/lights.h"

#include <algorithm>
#include <limits>

#include "pipeline/base/error.h"

namespace thixo::render {

using scene::LightType;

namespace {

/// Into the environment's own frame; back with the sine turned round.
Vec3f turned(const Vec3f& d, float cosine, float sine) {
    return {cosine * d.x() + sine * d.y(), cosine * d.y() - sine * d.x(), d.z()};
}
/// The part of a spot's intensity that goes along d: it fades smoothly from the bright cosine to the dark one.
float spot_part(const Light& light, const Vec3f& d) {
    if (light.type != LightType::spot) return 1;
    const float s = clamp01((light.normal.dot(d) - light.dark) / std::max(light.bright - light.dark, 1e-6f));
    return s * s * (3 - 2 * s);
}

Vec3f own_direction(const Light& light, const Vec3f& d) { return turned(d, light.turn.x(), light.turn.y()); }

}  // namespace

Light make_light(const scene::Light& l, std::shared_ptr<const Environment> environment) {
    Light light;
    light.type = l.type;
    light.radiance = (l.colour * l.strength).cast<float>();
    light.horizon = l.horizon.cast<float>();
    light.ground = l.ground.cast<float>();
    const Vec3f direction = light_direction(l).normalized().cast<float>();
    if (l.type == LightType::sun) {
        const double half = std::max(l.angle, 0.01) * kPi / 360;
        light.normal = -direction;
        light.cone = float(2 * square(std::sin(half / 2)));
        light.radiance /= float(kPi * square(std::sin(half)));
    }
    if (l.type == LightType::area) {
        light.normal = direction;
        light.centre = l.position.cast<float>();
        const Vec3f across = Vec3f(0, 0, 1).cross(direction);
        const Vec3f u = across.norm() > 1e-4f ? across.normalized() : Vec3f(1, 0, 0);
        light.edge1 = u * float(l.size.x() / 2);
        light.edge2 = direction.cross(u) * float(l.size.y() / 2);
        light.area = float(l.size.x() * l.size.y());
    }
    if (light.sizeless()) {
        light.normal = direction;
        light.centre = l.position.cast<float>();
        const double half = l.cone * kPi / 360;
        light.dark = float(std::cos(half));
        light.bright = float(std::cos(half * (1 - l.softness)));
    }
    if (l.type == LightType::environment) {
        THIXO_ASSERT(environment, "the environment {} has no picture", l.name);
        light.environment = std::move(environment);
        light.turn = {float(std::cos(l.rotation * kPi / 180)), float(std::sin(l.rotation * kPi / 180))};
    }
    return light;
}

Vec3f infinite_radiance(const Light& light, const Vec3f& d) {
    if (light.type == LightType::sun)
        return (d - light.normal).squaredNorm() < 2 * light.cone ? light.radiance : Vec3f(Vec3f::Zero());
    if (light.type == LightType::environment)
        return light.radiance.cwiseProduct(light.environment->radiance(own_direction(light, d)));
    if (d.z() < 0) return light.radiance.cwiseProduct(light.ground);
    return light.radiance.cwiseProduct(light.horizon + (Vec3f::Ones() - light.horizon) * d.z());
}

LightSample sample_light(const Light& light, const Vec3f& position, const Vec3f& n, const Vec2f& u) {
    LightSample sample;
    sample.distance = std::numeric_limits<float>::infinity();
    switch (light.type) {
        case LightType::sun:
            sample.direction = to_world(sample_cone(u, light.cone), light.normal);
            sample.radiance = light.radiance;
            sample.pdf = 1 / (2 * kPif * light.cone);
            break;
        case LightType::sky: {
            const Vec3f local = sample_cosine(u);
            sample.direction = to_world(local, n);
            sample.radiance = infinite_radiance(light, sample.direction);
            sample.pdf = local.z() / kPif;
            break;
        }
        case LightType::environment: {
            const Environment::Sample found = light.environment->sample(u);
            sample.direction = turned(found.direction, light.turn.x(), -light.turn.y());
            sample.radiance = light.radiance.cwiseProduct(light.environment->radiance(found.direction));
            sample.pdf = found.pdf;
            break;
        }
        case LightType::area: {
            const Vec3f to = light.centre + (2 * u.x() - 1) * light.edge1 + (2 * u.y() - 1) * light.edge2 - position;
            sample.distance = to.norm();
            sample.direction = to / std::max(sample.distance, 1e-20f);
            const float cosine = -light.normal.dot(sample.direction);
            if (cosine <= 0) return sample;
            sample.radiance = light.radiance;
            sample.pdf = sample.distance * sample.distance / (cosine * light.area);
            break;
        }
        case LightType::point:
        case LightType::spot: {
            const Vec3f to = light.centre - position;
            sample.distance = std::max(to.norm(), 1e-20f);
            sample.direction = to / sample.distance;
            sample.radiance = light.radiance * (spot_part(light, -sample.direction) / square(sample.distance));
            sample.pdf = sample.radiance.maxCoeff() > 0 ? 1 : 0;
            break;
        }
    }
    return sample;
}

float light_pdf(const Light& light, const Vec3f& n, const Vec3f& d, float distance) {
    switch (light.type) {
        case LightType::sun:
            return (d - light.normal).squaredNorm() < 2 * light.cone ? 1 / (2 * kPif * light.cone) : 0;
        case LightType::sky:
            return std::max(0.0f, n.dot(d)) / kPif;
        case LightType::environment:
            return light.environment->pdf(own_direction(light, d));
        case LightType::area:
            return distance * distance / (std::max(1e-6f, -light.normal.dot(d)) * light.area);
        case LightType::point:
        case LightType::spot:
            return 0;
    }
    return 0;
}

float hit_area(const Light& light, const Vec3f& origin, const Vec3f& d) {
    constexpr float missed = std::numeric_limits<float>::infinity();
    if (light.type != LightType::area) return missed;
    const float cosine = light.normal.dot(d);
    if (cosine >= 0) return missed;
    const float t = light.normal.dot(light.centre - origin) / cosine;
    if (!(t > 0)) return missed;
    const Vec3f y = origin + t * d - light.centre;
    const bool within = std::abs(y.dot(light.edge1)) <= light.edge1.squaredNorm() &&
                        std::abs(y.dot(light.edge2)) <= light.edge2.squaredNorm();
    return within ? t : missed;
}

float light_strength(const Light& l, const Vec3f& position) {
    float solid_angle = kPif;
    if (l.type == LightType::sun) solid_angle = 2 * kPif * l.cone;
    if (l.type == LightType::area) {
        const Vec3f to = position - l.centre;
        const float d2 = to.squaredNorm() + l.area;
        solid_angle = l.area * std::max(0.05f, l.normal.dot(to) / std::sqrt(d2)) / d2;
    }
    if (l.sizeless()) {
        const Vec3f to = position - l.centre;
        const float d2 = std::max(to.squaredNorm(), 1e-12f);
        return luminance(l.radiance) * std::max(0.05f, spot_part(l, to / std::sqrt(d2))) / d2;
    }
    if (l.type == LightType::environment)
        return luminance(l.radiance.cwiseProduct(l.environment->mean())) * solid_angle;
    return luminance(l.radiance) * solid_angle;
}

LightGroups light_groups(const std::vector<scene::Light>& lights, bool glow) {
    LightGroups groups{{scene::kBackgroundGroup}, {}};
    for (const scene::Light& l : lights) {
        const std::string& name = scene::group_of(l);
        const auto found = std::find(groups.names.begin(), groups.names.end(), name);
        groups.of_light.push_back(Index(found - groups.names.begin()));
        if (found == groups.names.end()) groups.names.push_back(name);
    }
    groups.of_glow = groups.names.size();
    if (glow) groups.names.push_back(scene::kGlowGroup);
    return groups;
}

}  // namespace thixo::render
