#include "sim/solid/laws.h"

#include <algorithm>

#include "pipeline/base/error.h"

namespace thixo {
namespace {

struct Values {  // what changes from one material to another
    scene::Elastic elastic;
    double viscosity;
};

Values values_of(const scene::Material& m) { return {m.elastic, m.viscosity}; }

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

Values between(Values a, const Values& b, double part) {
    Values out = b;
    const std::vector<double*> from = numbers_of(a.elastic), to = numbers_of(out.elastic);
    for (std::size_t k = 0; k < to.size(); ++k) *to[k] = (1 - part) * *from[k] + part * *to[k];
    out.viscosity = (1 - part) * a.viscosity + part * b.viscosity;
    return out;
}

Values values_at(const scene::Scene& scene, const scene::Material& material, double time) {
    Values now = values_of(material);
    for (const scene::MaterialChange& c : material.elastic.changes) {
        if (time < c.time - c.duration) break;
        const auto other = std::find_if(scene.materials.begin(), scene.materials.end(),
                                        [&](const scene::Material& m) { return m.name == c.material; });
        THIXO_ASSERT(other != scene.materials.end(), "no material {}", c.material);
        now = between(now, values_of(*other), c.duration > 0 ? std::min(1.0, 1 - (c.time - time) / c.duration) : 1.0);
    }
    return now;
}

}  // namespace

StressLaw law_at(const scene::Scene& scene, std::size_t material, double time) {
    const Values now = values_at(scene, scene.materials[material], time);
    return law_of(now.elastic, now.viscosity);
}

MeltingLaw::MeltingLaw(const scene::Scene& scene, std::size_t material, double time)
    : melting_(scene.materials[material].melting) {
    const Values now = values_at(scene, scene.materials[material], time);
    cold_ = now.elastic;
    viscosity_ = now.viscosity;
}

StressLaw MeltingLaw::at(double b) const {
    if (!melting_.any()) return law_of(cold_, (1 - b) * viscosity_);
    const scene::LiquidEnd& liquid = melting_.liquid;
    scene::Elastic e = cold_;
    const auto mix = [&](double& cold, double hot) { cold = (1 - b) * cold + b * hot; };
    mix(e.youngs_modulus, liquid.youngs_modulus);
    mix(e.poisson_ratio, liquid.poisson_ratio);
    mix(e.volume_stiffness, 0);
    mix(e.yield_strain, liquid.yield_strain);
    mix(e.creep, liquid.creep);
    mix(e.hardening, 0);
    if (b > 0) e.maximum_plastic_strain = 0;  // a liquid flows without limit
    return law_of(e, (1 - b) * viscosity_);
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
