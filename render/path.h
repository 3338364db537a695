// Light along one path from the camera.
#pragma once

#include <span>

#include "render/sampler.h"
#include "render/world.h"

namespace thixo::render {

/// What the camera sees first.
struct FirstHit {
    bool found = false;
    float depth = 0;                     // m along the view axis
    Vec3f normal{0, 0, 0};               // towards the camera
    Vec3f albedo{0, 0, 0};               // of a dielectric: one
    Eigen::Vector4f motion{0, 0, 0, 0};  // pixels to the right and up, to the next frame and to the one before
    const ObjectLabel* label = nullptr;  // where the world has labels
    Vec3d place{0, 0, 0};                // of the hit, in the world [m]
    Hit hit;                             // as the ray met it; untouched where a lamp is seen
    Vec3f seen{0, 0, 0};                 // colour of what is seen through and in clear and mirroring surfaces
    Vec3f way{0, 0, 0};                  // direction in which that is met, times the share that arrives of it
};

/// Which ways to sample light take part. `both` is for pictures; the single ones give the same mean, and test it.
enum class Strategy { both, lights, surfaces };

/// Radiance along a camera ray [W/(m^2 sr)]: path tracing with next-event estimation, both joined by the power
/// heuristic (Veach 1997). With settings.straight_shadows light reaches shaded points straight through smooth
/// dielectrics. It loses what Fresnel reflection and absorption take. Paths that would bring the same light by
/// refraction are left out, and so are reflections of suns and area lights in dielectrics (caustics). Without it such
/// light arrives by refraction and reflection alone. What glows is met by chance alone. What comes of each of the world's light groups is added to
/// `groups`, unless that is empty.
Vec3f radiance(const World& world, const Ray& camera_ray, Sampler& sampler, FirstHit& first,
               Strategy strategy = Strategy::both, std::span<Vec3d> groups = {});

/// Share of light that comes straight along the ray to its origin, per colour. `through`: it went through a
/// dielectric's surface.
Vec3f transmittance(const World& world, Ray ray, Interior interior, bool& through);

}  // namespace thixo::render
