// Rough glass: no energy is made or lost, what is sampled is what is evaluated, light may run either way.
#include "render/materials/dielectric.h"

#include <gtest/gtest.h>

#include "pipeline/base/random.h"

namespace thixo::render {
namespace {

Vec3f toward(float cosine) { return {std::sqrt(1 - cosine * cosine), 0, cosine}; }
float uniform(std::uint64_t i, std::uint64_t use) { return float(random_unit(12, i, use, 0)); }
Vec3f on_sphere(std::uint64_t i) {
    const float z = 2 * uniform(i, 3) - 1, phi = 2 * kPif * uniform(i, 4), r = std::sqrt(1 - z * z);
    return {r * std::cos(phi), r * std::sin(phi), z};
}

class RoughGlass : public testing::TestWithParam<std::pair<float, float>> {  // alpha, eta
  protected:
    RoughGlass() : table_(tabulate_interface(GetParam().first)), m_{GetParam().first, GetParam().second, &table_} {}
    InterfaceAlbedo table_;
    RoughInterface m_;
};

TEST_P(RoughGlass, ScattersAllTheFluxItGets) {
    // Flux that goes through is radiance times eta^2. 40 000 samples and a table of 0.3 %: 1 %.
    for (const float cosine : {0.1f, 0.4f, 1.0f}) {
        double sum = 0;
        constexpr int n = 40000;
        for (std::uint64_t i = 0; i < n; ++i) {
            const Scatter s = m_.scatter(toward(cosine), uniform(i, 0), {uniform(i, 1), uniform(i, 2)});
            sum += double(s.weight.x() * (s.direction.z() < 0 ? m_.eta * m_.eta : 1));
        }
        EXPECT_NEAR(sum / n, 1, 0.01) << cosine;
    }
}

TEST_P(RoughGlass, IsSampledAsItIsEvaluated) {
    // The flux to either side by samples of the directions, and by even directions: both estimate the same integral;
    // 5 standard errors. So is one of the density itself, over directions that are not lost between facets.
    const Vec3f wo = toward(0.5f);
    constexpr int n = 100000;
    for (const bool through : {false, true}) {
        double sampled = 0, even = 0, even2 = 0, sampled2 = 0;
        for (std::uint64_t i = 0; i < n; ++i) {
            const Scatter s = m_.scatter(wo, uniform(i, 0), {uniform(i, 1), uniform(i, 2)});
            const double w = (s.direction.z() < 0) == through ? double(s.weight.x()) : 0;
            sampled += w / n;
            sampled2 += w * w / n;
            const Vec3f wi = on_sphere(i);
            float pdf;
            const double e = (wi.z() < 0) == through ? 4 * kPi * double(m_.evaluate(wo, wi, pdf)) : 0;
            even += e / n;
            even2 += e * e / n;
        }
        const double error = std::sqrt((sampled2 - sampled * sampled + even2 - even * even) / n);
        EXPECT_NEAR(sampled, even, 5 * error) << through;
        EXPECT_LT(error, 0.05);
    }
}

TEST_P(RoughGlass, LetsLightRunEitherWay) {
    // f(a -> b)/n_b^2 = f(b -> a)/n_a^2, to the interpolation of the table.
    RoughInterface back = m_;
    back.eta = 1 / m_.eta;
    for (std::uint64_t i = 0; i < 300; ++i) {
        const Vec3f a = sample_cosine({uniform(i, 0), uniform(i, 1)});
        Vec3f b = on_sphere(i);
        if (a.z() < 0.05f || std::abs(b.z()) < 0.05f) continue;
        float unused;
        const float there = m_.evaluate(a, b, unused) / std::abs(b.z());
        const bool through = b.z() < 0;
        // Seen from the other side the normal is the other one.
        const float again = through ? back.evaluate(-b, -a, unused) / a.z() : m_.evaluate(b, a, unused) / a.z();
        const float scale = through ? m_.eta * m_.eta : 1;
        EXPECT_NEAR(there * scale, again, 0.01f * std::max(0.1f, again)) << through;
    }
}

INSTANTIATE_TEST_SUITE_P(Indices, RoughGlass,
                         testing::Values(std::pair(0.1f, 1.5f), std::pair(0.4f, 1.5f), std::pair(0.9f, 1.5f),
                                         std::pair(0.4f, 1 / 1.5f), std::pair(0.4f, 1.128f)));

}  // namespace
}  // namespace thixo::render
