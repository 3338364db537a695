#include "sim/solid/laws.h"

#include <algorithm>

namespace thixo {
namespace {

/// Finds the numbers of an elastic block by its keys (scene_key.h).
struct Numbers {
    std::vector<double*> all;
    void key(const char*, double& number, const char*, const scene::Check&, const char*) { all.push_back(&number); }
    void key(const char*, scene::Flow&, const char*, const scene::Check&, const char*) {}
    void block(auto&&...) {}
    void list(auto&&...) {}
};
std::vector<double*> numbers_of(scene::Elastic& e) {
    Numbers numbers;
    visit(numbers, e);
    return numbers.all;
}

ElasticValues between(ElasticValues a, const ElasticValues& b, double part) {
    ElasticValues out = b;
    const std::vector<double*> from = numbers_of(a.elastic), to = numbers_of(out.elastic);
    for (std::size_t k = 0; k < to.size(); ++k) *to[k] = (1 - part) * *from[k] + part * *to[k];
    out.viscosity = (1 - part) * a.viscosity + part * b.viscosity;
    return out;
}

}  // namespace

ElasticValues elastic_at(const ResolvedMaterial& material, double time) {
    ElasticValues now = material.elastic.front();
    for (std::size_t k = 1; k < material.elastic.size(); ++k) {
        const ElasticValues& next = material.elastic[k];
        if (time < next.time - next.duration) break;
        now = between(now, next, next.duration > 0 ? std::min(1.0, 1 - (next.time - time) / next.duration) : 1.0);
    }
    return now;
}

StressLaw law_at(const ResolvedMaterial& material, double time) {
    const ElasticValues now = elastic_at(material, time);
    return law_of(now.elastic, now.viscosity);
}

StressLaw melting_law(const scene::Melting& melting, const ElasticValues& cold, double b) {
    if (!melting.any()) return law_of(cold.elastic, (1 - b) * cold.viscosity);
    const scene::LiquidEnd& liquid = melting.liquid;
    scene::Elastic e = cold.elastic;
    const auto mix = [&](double& value, double hot) { value = (1 - b) * value + b * hot; };
    mix(e.youngs_modulus, liquid.youngs_modulus);
    mix(e.poisson_ratio, liquid.poisson_ratio);
    mix(e.volume_stiffness, 0);
    mix(e.yield_strain, liquid.yield_strain);
    mix(e.creep, liquid.creep);
    mix(e.hardening, 0);
    if (b > 0) e.maximum_plastic_strain = 0;  // a liquid flows without limit
    return law_of(e, (1 - b) * cold.viscosity);
}

Stiffness6 orthotropic_stiffness(const scene::Orthotropic& o, const Mat3d& axes) {
    using Matrix6 = Eigen::Matrix<double, 6, 6>;
    const Vec3d &e = o.youngs_modulus, &nu = o.poisson_ratio;
    Matrix6 compliance = Matrix6::Zero();
    for (int a = 0; a < 3; ++a) {
        const int b = (a + 1) % 3;
        compliance(a, a) = 1 / e[a];
        compliance(a, b) = compliance(b, a) = -nu[a] / e[a];
        compliance(3 + a, 3 + a) = 1 / o.shear_modulus[a];
    }
    const Matrix6 own = compliance.inverse();
    const auto tensor = [](const auto& v, double shear) {
        Mat3d m;
        m << v[0], shear * v[3], shear * v[5], shear * v[3], v[1], shear * v[4], shear * v[5], shear * v[4], v[2];
        return m;
    };
    Matrix6 c;
    for (int k = 0; k < 6; ++k) {
        const Mat3d strain = axes.transpose() * tensor(Eigen::Matrix<double, 6, 1>::Unit(k), 0.5) * axes;
        Eigen::Matrix<double, 6, 1> in;
        in << strain(0, 0), strain(1, 1), strain(2, 2), 2 * strain(0, 1), 2 * strain(1, 2), 2 * strain(2, 0);
        const Mat3d stress = axes * tensor(Eigen::Matrix<double, 6, 1>(own * in), 1) * axes.transpose();
        c.col(k) << stress(0, 0), stress(1, 1), stress(2, 2), stress(0, 1), stress(1, 2), stress(2, 0);
    }
    return c.cast<Real>();
}

}  // namespace thixo
