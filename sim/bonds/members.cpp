#include "sim/bonds/members.h"

#include "pipeline/base/parallel.h"

namespace thixo {

Index append_element(Elements& e, std::int64_t particle, std::int32_t owner) {
    const Index i = append_row(e);
    e.id[i] = particle;
    e.owner[i] = owner;
    Bonds& bonds = e.bonds;
    if (bonds.begin.empty()) bonds.begin.push_back(0);
    bonds.begin.push_back(bonds.begin.back());
    bonds.moment.push_back(RestMoment{.inverse = {}, .full = false});
    bonds.flat.emplace_back(i, Symmetric{});
    return i;
}

void number_element(std::int64_t particle, Index element, Solids& solids) {
    const auto id = static_cast<std::size_t>(particle);
    if (solids.element_of.size() <= id) solids.element_of.resize(id + 1, kNone);
    solids.element_of[id] = element;
}

void locate_particles(const Particles& particles, Solids& solids) {
    if (solids.empty()) return;
    solids.particle_of.resize(solids.elements.size(), kNone);
    parallel_for(
        particles.size(),
        [&](std::size_t k) {
            if (const Index i = solids.element(particles.id[k]); i != kNone)
                solids.particle_of[i] = static_cast<Index>(k);
        },
        4096);
}

}  // namespace thixo
