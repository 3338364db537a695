#include "render/passes.h"

#include <bit>

namespace thixo::render {
namespace {

using scene::Passes;

template <class V>
PassValue three(const V& v) {
    return {double(v.x()), double(v.y()), double(v.z()), 0};
}
PassValue one(double a) { return {a, 0, 0, 0}; }

/// Ids and shares of ranks 2 Layer and 2 Layer + 1.
template <std::vector<Coverage> Pixel::*List, std::size_t Layer>
PassValue ranks(const Pixel& pixel) {
    std::vector<Coverage> sorted = pixel.*List;
    sort_by_rank(sorted);
    PassValue value = PassValue::Zero();
    for (std::size_t k = 0; k < 2 && 2 * Layer + k < sorted.size(); ++k) {
        const Coverage& c = sorted[2 * Layer + k];
        value[Eigen::Index(2 * k)] = double(std::bit_cast<float>(c.id));
        value[Eigen::Index(2 * k + 1)] = c.samples / double(pixel.samples);
    }
    return value;
}

constexpr Pass of_pixel(std::string_view layer, std::string_view letters, bool half, PassValue (*value)(const Pixel&),
                        bool Passes::*asked = nullptr) {
    return {.layer = layer,
            .letters = letters,
            .half = half,
            .gathered = Gathered::pixel,
            .of_pixel = value,
            .asked = asked};
}
constexpr Pass mean(std::string_view layer, std::string_view letters, PassValue (*value)(const FirstHit&)) {
    return {.layer = layer, .letters = letters, .half = true, .gathered = Gathered::mean, .of_hit = value};
}
constexpr Pass nearest(std::string_view layer, std::string_view letters, PassValue (*value)(const FirstHit&),
                       double nothing, bool Passes::*asked = nullptr) {
    return {.layer = layer,
            .letters = letters,
            .half = false,
            .gathered = Gathered::nearest,
            .of_hit = value,
            .nothing = nothing,
            .asked = asked};
}

}  // namespace

const std::array<Pass, kPassCount> kPasses{
    of_pixel("", "RGB", true, [](const Pixel& p) { return three(p.mean()); }),
    of_pixel("", "A", true, [](const Pixel& p) { return one(p.covered / double(p.samples)); }),
    nearest(
        "", "Z", [](const FirstHit& h) { return one(double(h.depth)); }, double(kFar)),
    mean("N", "XYZ", [](const FirstHit& h) { return three(h.normal); }),
    mean("albedo", "RGB", [](const FirstHit& h) { return three(h.albedo); }),
    of_pixel("variance", "RGB", false, [](const Pixel& p) { return three(p.variance()); }),
    of_pixel("samples", "", false, [](const Pixel& p) { return one(p.samples); }),
    nearest(
        "P", "XYZ", [](const FirstHit& h) { return three(h.place); }, 0, &Passes::position),
    nearest(
        "motion", "XYZW", [](const FirstHit& h) -> PassValue { return h.motion.cast<double>(); }, 0, &Passes::motion),
    nearest(
        "body", "", [](const FirstHit& h) { return one(h.label ? h.label->body : -1); }, -1, &Passes::body),
    nearest(
        "sheet", "", [](const FirstHit& h) { return one(h.hit.sheet); }, -1, &Passes::sheet),
    of_pixel("CryptoObject00", "RGBA", false, &ranks<&Pixel::objects, 0>, &Passes::cryptomatte),
    of_pixel("CryptoObject01", "RGBA", false, &ranks<&Pixel::objects, 1>, &Passes::cryptomatte),
    of_pixel("CryptoObject02", "RGBA", false, &ranks<&Pixel::objects, 2>, &Passes::cryptomatte),
    of_pixel("CryptoMaterial00", "RGBA", false, &ranks<&Pixel::materials, 0>, &Passes::cryptomatte),
    of_pixel("CryptoMaterial01", "RGBA", false, &ranks<&Pixel::materials, 1>, &Passes::cryptomatte),
    of_pixel("CryptoMaterial02", "RGBA", false, &ranks<&Pixel::materials, 2>, &Passes::cryptomatte),
};

std::string Pass::channel(int k) const {
    if (letters.empty()) return std::string(layer);
    const std::string letter(1, letters[std::size_t(k)]);
    return layer.empty() ? letter : std::string(layer) + "." + letter;
}

void Pixel::add(const Vec3f& radiance, const FirstHit& first, const World& world) {
    const Vec3d c = radiance.cast<double>();
    ++samples;
    sum += c;
    squares += c.cwiseProduct(c);
    covered += first.found || !world.settings.transparent_background;
    if (!first.found) return;
    const bool is_nearest = first.depth > 0 && first.depth < depth;
    if (is_nearest) depth = first.depth;
    for (std::size_t k = 0; k < kPassCount; ++k) {
        const Pass& pass = kPasses[k];
        if (pass.gathered == Gathered::pixel || !pass.on(world.passes)) continue;
        if (pass.gathered == Gathered::mean) gathered[k] += pass.of_hit(first);
        if (pass.gathered == Gathered::nearest && is_nearest) gathered[k] = pass.of_hit(first);
    }
    if (!world.passes.cryptomatte || !first.label) return;
    count(objects, first.label->object_id);
    count(materials, first.label->material_id);
}

Vec3d Pixel::variance() const {
    if (samples < 2) return Vec3d::Zero();
    return (squares / samples - mean().cwiseProduct(mean())).cwiseMax(0.0) / (samples - 1);
}

PassValue Pixel::value(std::size_t k) const {
    const Pass& pass = kPasses[k];
    switch (pass.gathered) {
        case Gathered::mean:
            return gathered[k] / double(samples);
        case Gathered::nearest:
            return depth < kFar ? gathered[k] : PassValue(PassValue::Constant(pass.nothing));
        case Gathered::pixel:
            break;
    }
    return pass.of_pixel(*this);
}

std::map<std::string, std::string> pass_attributes(const World& world) {
    std::map<std::string, std::string> attributes;
    if (!world.passes.cryptomatte) return attributes;
    std::vector<std::string> objects, materials;
    for (const ObjectLabel& label : world.labels) {
        objects.push_back(label.name);
        materials.push_back(label.appearance);
    }
    describe_cryptomatte("CryptoObject", objects, attributes);
    describe_cryptomatte("CryptoMaterial", materials, attributes);
    return attributes;
}

}  // namespace thixo::render
