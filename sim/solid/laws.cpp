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

Values between(const Values& a, const Values& b, double part) {
    Values out = b;
    const auto mix = [&](double scene::Elastic::*key) {
        out.elastic.*key = (1 - part) * (a.elastic.*key) + part * (b.elastic.*key);
    };
    for (const auto key :
         {&scene::Elastic::youngs_modulus, &scene::Elastic::poisson_ratio, &scene::Elastic::volume_stiffness,
          &scene::Elastic::zero_energy, &scene::Elastic::yield_strain, &scene::Elastic::creep,
          &scene::Elastic::maximum_plastic_strain, &scene::Elastic::friction, &scene::Elastic::contact_damping,
          &scene::Elastic::contact_stiffness})
        mix(key);
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

namespace {

StressLaw law_of(const scene::Elastic& e, double viscosity) {
    const double modulus = e.youngs_modulus, nu = e.poisson_ratio;
    const auto real = [](double a) { return static_cast<Real>(a); };
    StressLaw law;
    law.lambda = real(modulus * nu / ((1 + nu) * (1 - 2 * nu)));
    law.mu = real(modulus / (2 * (1 + nu)));
    law.volume_stiffness = real(e.volume_stiffness);
    law.viscosity = real(viscosity);
    law.zero_energy = real(e.zero_energy * modulus);
    law.yield = real(e.yield_strain);
    law.creep = real(e.creep);
    law.most_plastic = real(e.maximum_plastic_strain);
    law.friction = real(e.friction);
    law.contact_damping = real(e.contact_damping);
    law.contact_stiffness = real(e.contact_stiffness);
    return law;
}

}  // namespace

StressLaw law_at(const scene::Scene& scene, std::size_t material, double time) {
    const Values now = values_at(scene, scene.materials[material], time);
    return law_of(now.elastic, now.viscosity);
}

StressLaw scaled(const StressLaw& law, Real share) {
    StressLaw out = law;
    for (Real* a : {&out.lambda, &out.mu, &out.volume_stiffness, &out.viscosity, &out.zero_energy}) *a *= share;
    return out;
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
