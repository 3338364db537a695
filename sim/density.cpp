#include "sim/density.h"

#include <cmath>

#include "pipeline/base/parallel.h"

namespace thixo {

void compute_density(Particles& particles, const NeighbourLists& neighbours, const Walls& walls, const Smoothing& smoothing, Sweep& sweep) {
    const Poly6 kernel = smoothing.density;
    const auto& place = sweep.place;
    sweep.walls.resize(particles.size());
    parallel_for(particles.size(), [&](std::size_t i) {
        const Quad p = place[i];
        Real sum = p.w * kernel.value(0);
        for (const Index j : neighbours[i]) {
            const Quad q = place[j];
            sum += q.w * kernel.value(square(p.x - q.x) + square(p.y - q.y) + square(p.z - q.z));
        }
        sweep.walls[i] = wall_effect(walls, particles.position[i]);
        particles.density[i] = particles.mass[i] / particles.rest_volume[i] * (sum + sweep.walls[i].share);
    });
}

void compute_pressure(Particles& particles, const std::vector<MaterialParams>& materials, Sweep& sweep) {
    sweep.matter.resize(particles.size());
    parallel_for(particles.size(), [&](std::size_t i) {
        const MaterialParams& m = materials[static_cast<std::size_t>(particles.material[i])];
        const Real rest = m.density;
        const Real rho = std::max(particles.density[i], rest);
        const Real compressed = m.gamma == 1 ? rho / rest : std::pow(rho / rest, m.gamma);
        const Real pressure = m.stiffness * (compressed - 1) - Real(0.5) * m.cohesion * square(rho);
        particles.pressure[i] = pressure;
        sweep.matter[i] = {pressure, m.viscosity, rest * m.sound_speed, 0};
        sweep.motion[i].w = particles.mass[i] / rho;
    }, 2048);
}

}  // namespace thixo
