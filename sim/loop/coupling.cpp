#include "sim/loop/coupling.h"

#include <algorithm>

#include "pipeline/base/parallel.h"

namespace thixo {
namespace {

/// Sum over the rest neighbours of V0_j (1 - c_ij) W(rest_ij) [1].
Real rest_share(const Elements& e, const Poly6& kernel, std::size_t i) {
    const Real own = e.solidity(i);
    Real sum = 0;
    for (std::size_t k = e.bonds.begin[i]; k < e.bonds.begin[i + 1]; ++k) {
        const Index j = e.bonds.neighbour[k];
        if (j == i) continue;
        const Real solid = std::min(own, e.solidity(j));
        sum += e.volume[j] * solid * kernel.value(bond_vector(e, i, k).cast<Real>().squaredNorm());
    }
    return sum;
}

}  // namespace

bool any_liquid(const Particles& particles) {
    return std::ranges::any_of(particles.melt, [](Real b) { return b > 0; });
}

void pack_phases(const Particles& particles, const Solids& solids, const Smoothing& smoothing, Sweep& sweep) {
    sweep.mixed = !solids.empty() && std::ranges::any_of(particles.melt, [](Real b) { return b < 1; });
    if (!sweep.mixed) return;
    resize_packed(sweep.ghosts, sweep.melt, Real(0));
    resize_packed(sweep.ghosts, sweep.present, Real(0));
    sweep.rest_share.assign(particles.size(), 0);
    parallel_for(
        particles.size(),
        [&](std::size_t k) {
            const Real b = particles.melt[k];
            sweep.melt[k] = b;
            sweep.present[k] = Real(1);
            if (particles.phase[k] != Phase::solid) return;
            sweep.present[k] = b;
            sweep.rest_share[k] = rest_share(solids.elements, smoothing.density, solids.element(particles.id[k]));
        },
        256);
}

void keep_elastic_state(const Particles& particles, ElasticState& saved) {
    saved.density = particles.density;
    saved.pressure = particles.pressure;
}

void restore_elastic_state(const ElasticState& saved, Particles& particles) {
    parallel_for(
        particles.size(),
        [&](std::size_t k) {
            if (!is_elastic(particles.phase[k])) return;
            const Real b = particles.melt[k];
            if (particles.phase[k] == Phase::solid)
                particles.density[k] = (1 - b) * saved.density[k] + b * particles.density[k];
            particles.pressure[k] = (1 - b) * saved.pressure[k] + b * particles.pressure[k];
        },
        2048);
}

void push_by_liquid(const Particles& particles, double kick, Solids& solids) {
    Elements& e = solids.elements;
    const Real by = static_cast<Real>(kick);
    std::vector<Mat3> back;
    for (const SolidBody& body : solids.bodies) back.push_back(body.turn.transpose().cast<Real>());
    parallel_for(
        particles.size(),
        [&](std::size_t k) {
            if (!is_elastic(particles.phase[k])) return;
            const Index i = solids.element(particles.id[k]);
            Quad& v = e.velocity[i];
            v = quad(xyz(v) + back[static_cast<std::size_t>(e.owner[i])] * (by * particles.acceleration[k]));
        },
        2048);
}

}  // namespace thixo
