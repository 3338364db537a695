// What every material of a surface states, in one place. It says how light is scattered, how a direction is chosen and
// with which density, and how much of the light comes back. The local frame has the normal along +z. wo leads to where
// the path came from, wi to where light comes from.
//
//   kType
//     Its word in the scene file (scene::AppearanceType). make_material looks for it in the list of materials.
//   Vec3f evaluate(colour, wo, wi, pdf)
//     f(wo, wi) cos(wi)   [1/sr]
//     `pdf` becomes the density of scatter() in wi [1/sr]. Both are zero where wi or wo is below the surface, and for
//     mirror directions.
//   Scatter scatter(colour, wo, choose, u)
//     A direction: `choose` picks the lobe, u the direction within it.
//   Vec3f albedo(colour, cosine)
//     E(wo) = int f(wo, wi) cos(wi) dwi   [1],   cosine = wo.z
//
// Diffuse, Plastic and Conductor are opaque. A Dielectric has two sides: its RoughInterface evaluates and scatters on
// both, without a colour. A dielectric absorbs nothing at its surface, so its albedo is 1.
#pragma once

#include <limits>

#include "render/warp.h"

namespace thixo::render {

/// Roughness below which a surface counts as smooth.
inline constexpr float kSmooth = 1e-3f;

/// A direction chosen by a surface. Weight zero: the light is absorbed.
///   weight = f cos / pdf   [1]
struct Scatter {
    Vec3f direction{0, 0, 1};  // local
    Vec3f weight{0, 0, 0};
    float pdf = 0;  // [1/sr]; infinite for a mirror direction
    bool mirror() const { return pdf == std::numeric_limits<float>::infinity(); }
};

/// The mirror direction of wo.
inline Vec3f mirrored(const Vec3f& wo) { return {-wo.x(), -wo.y(), wo.z()}; }

/// scatter() of a material whose density is that of sample_cosine, cos(wi)/pi.
template <class M>
Scatter scatter_by_cosine(const M& material, const Vec3f& colour, const Vec3f& wo, const Vec2f& u) {
    Scatter scattered;
    if (wo.z() <= 0) return scattered;
    scattered.direction = sample_cosine(u);
    const Vec3f f = material.evaluate(colour, wo, scattered.direction, scattered.pdf);
    if (scattered.pdf > 0) scattered.weight = f / scattered.pdf;
    return scattered;
}

}  // namespace thixo::render
