#include "render/passes.h"

namespace thixo::render {

const std::array<Pass, kPassCount> kPasses{{
    {.layer = "",
     .letters = "RGB",
     .half = true,
     .gathered = Gathered::pixel,
     .of_pixel = [](const Pixel& p) { return p.mean(); }},
    {.layer = "",
     .letters = "A",
     .half = true,
     .gathered = Gathered::pixel,
     .of_pixel = [](const Pixel& p) { return Vec3d(p.covered / double(p.samples), 0, 0); }},
    {.layer = "",
     .letters = "Z",
     .half = false,
     .gathered = Gathered::nearest,
     .of_hit = [](const FirstHit& h) { return Vec3f(h.depth, 0, 0); },
     .nothing = double(kFar)},
    {.layer = "N",
     .letters = "XYZ",
     .half = true,
     .gathered = Gathered::mean,
     .of_hit = [](const FirstHit& h) { return h.normal; }},
    {.layer = "albedo",
     .letters = "RGB",
     .half = true,
     .gathered = Gathered::mean,
     .of_hit = [](const FirstHit& h) { return h.albedo; }},
    {.layer = "variance",
     .letters = "RGB",
     .half = false,
     .gathered = Gathered::pixel,
     .of_pixel = [](const Pixel& p) { return p.variance(); }},
    {.layer = "samples",
     .letters = "",
     .half = false,
     .gathered = Gathered::pixel,
     .of_pixel = [](const Pixel& p) { return Vec3d(p.samples, 0, 0); }},
}};

std::string Pass::channel(int k) const {
    if (letters.empty()) return std::string(layer);
    const std::string letter(1, letters[std::size_t(k)]);
    return layer.empty() ? letter : std::string(layer) + "." + letter;
}

void Pixel::add(const Vec3f& radiance, const FirstHit& first, bool transparent_background) {
    const Vec3d c = radiance.cast<double>();
    ++samples;
    sum += c;
    squares += c.cwiseProduct(c);
    covered += first.found || !transparent_background;
    if (!first.found) return;
    const bool nearest = first.depth > 0 && first.depth < depth;
    if (nearest) depth = first.depth;
    for (std::size_t k = 0; k < kPassCount; ++k) {
        const Pass& pass = kPasses[k];
        if (pass.gathered == Gathered::mean) gathered[k] += pass.of_hit(first).cast<double>();
        if (pass.gathered == Gathered::nearest && nearest) gathered[k] = pass.of_hit(first).cast<double>();
    }
}

Vec3d Pixel::variance() const {
    if (samples < 2) return Vec3d::Zero();
    return (squares / samples - mean().cwiseProduct(mean())).cwiseMax(0.0) / (samples - 1);
}

Vec3d Pixel::value(std::size_t k) const {
    const Pass& pass = kPasses[k];
    switch (pass.gathered) {
        case Gathered::mean:
            return gathered[k] / double(samples);
        case Gathered::nearest:
            return depth < kFar ? gathered[k] : Vec3d(Vec3d::Constant(pass.nothing));
        case Gathered::pixel:
            break;
    }
    return pass.of_pixel(*this);
}

}  // namespace thixo::render
