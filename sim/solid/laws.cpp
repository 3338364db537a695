#include <algorithm>

#include "pipeline/base/error.h"
#include "sim/solid/solids.h"

namespace thixo {
namespace {

struct Values {  // what goes over from one material to another
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
    if (b > 0) e.maximum_plastic_strain = 0;  // a liquid flows as far as it likes
    return law_of(e, (1 - b) * viscosity_);
}

}  // namespace thixo
