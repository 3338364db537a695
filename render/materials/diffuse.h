// Matt: the same radiance in all directions (Lambert).
#pragma once

#include "pipeline/contract/scene.h"
#include "render/materials/scatter.h"

namespace thixo::render {

struct Diffuse {
    static constexpr auto kType = scene::AppearanceType::diffuse;
    explicit Diffuse(const scene::Appearance&) {}

    Vec3f evaluate(const Vec3f& colour, const Vec3f& wo, const Vec3f& wi, float& pdf) const {
        pdf = 0;
        if (wi.z() <= 0 || wo.z() <= 0) return Vec3f::Zero();
        pdf = wi.z() / kPif;
        return colour * pdf;
    }

    Scatter scatter(const Vec3f& colour, const Vec3f& wo, float, const Vec2f& u) const {
        return scatter_by_cosine(*this, colour, wo, u);
    }

    Vec3f albedo(const Vec3f& colour, float) const { return colour; }
};

}  // namespace thixo::render
