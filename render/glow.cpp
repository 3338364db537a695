#include "render/glow.h"

#include "render/black_body.h"

namespace thixo::render {
namespace {

constexpr double kFreezing = 273.15;  // K, of 0 degC

}  // namespace

Glow::Glow(const scene::Glow& glow) : any_(glow.strength > 0), radiance_((glow.strength * glow.colour).cast<float>()) {
    if (any_ && glow.black_body > 0) reference_ = float(glow.black_body + kFreezing);
}

Vec3f Glow::at(const Hit& hit) const {
    if (!by_temperature()) return radiance_;
    return radiance_.cwiseProduct(black_body_radiance(hit.attributes.temperature + float(kFreezing), reference_));
}

}  // namespace thixo::render
