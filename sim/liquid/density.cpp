#include "sim/liquid/density.h"

#include <cmath>

#include "pipeline/base/parallel.h"

namespace thixo {

namespace {

template <bool mixed>
void sum_density(Particles& particles, const NeighbourLists& neighbours, const Walls& walls, const Smoothing& smoothing,
                 Sweep& sweep) {
    const Poly6 kernel = smoothing.density;
    const Quad* place = sweep.place.data();
    const Index nobody = sweep.nobody();
    sweep.walls.resize(particles.size());
    parallel_chunks(
        particles.size(),
        [&](std::size_t begin, std::size_t end, std::size_t) {
            WallCursor cursor(walls);
            for (std::size_t i = begin; i < end; ++i) {
                const Quad p = place[i];
                Lanes sums{};  // sum_j V0_j (1 - r^2/h^2)^3
                for_each_run(neighbours[i], nobody, [&](const Index* j) {
                    Lanes x, y, z, volume;
                    gather(place, j, x, y, z, volume);
                    x -= p.x;
                    y -= p.y;
                    z -= p.z;
                    const Lanes q = positive(1 - (x * x + y * y + z * z) * kernel.h2_inv);
                    if constexpr (mixed) volume *= larger(gather(sweep.present.data(), j), sweep.present[i]);
                    sums += volume * q * q * q;
                });
                sweep.walls[i] = wall_effect(walls, particles.position[i], cursor);
                const Real beside =
                    mixed ? sweep.present[i] * sweep.walls[i].share + sweep.rest_share[i] : sweep.walls[i].share;
                const Real share = kernel.scale * (p.w + sum_of(sums)) + beside;
                particles.density[i] = particles.mass[i] / particles.rest_volume[i] * share;
            }
        },
        256);
}

/// Writes the fields of a particle that forces read. pressure(i, material, rho) is P_i [Pa].
template <class P>
void pack_matter(const Particles& particles, const Materials& materials, Sweep& sweep, P&& pressure) {
    resize_packed(sweep.ghosts, sweep.matter, {0, 0, 0, 0});
    sweep.one_material = materials.size() == 1;
    parallel_for(
        particles.size(),
        [&](std::size_t i) {
            const ResolvedMaterial& m = materials[static_cast<std::size_t>(particles.material[i])];
            const Real rho = std::max(particles.density[i], m.density);
            sweep.place[i].w = pressure(i, m, rho);
            sweep.matter[i] = {m.viscosity, m.density * m.sound_speed, sweep.mixed ? sweep.melt[i] : Real(1), 0};
            sweep.motion[i].w = particles.mass[i] / rho;
        },
        2048);
    refresh_places(sweep.ghosts, sweep.place);
    refresh_ghosts(sweep.ghosts, sweep.motion);
    refresh_ghosts(sweep.ghosts, sweep.matter);
}

}  // namespace

void compute_density(Particles& particles, const NeighbourLists& neighbours, const Walls& walls,
                     const Smoothing& smoothing, Sweep& sweep) {
    if (sweep.mixed)
        sum_density<true>(particles, neighbours, walls, smoothing, sweep);
    else
        sum_density<false>(particles, neighbours, walls, smoothing, sweep);
}

void pack_without_pressure(Particles& particles, const Materials& materials, Sweep& sweep) {
    pack_matter(particles, materials, sweep, [](std::size_t, const ResolvedMaterial&, Real) { return Real(0); });
}

void compute_pressure(Particles& particles, const Materials& materials, Sweep& sweep) {
    pack_matter(particles, materials, sweep, [&](std::size_t i, const ResolvedMaterial& m, Real rho) {
        const Real compressed = m.gamma == 1 ? rho / m.density : std::pow(rho / m.density, m.gamma);
        return particles.pressure[i] = m.stiffness * (compressed - 1);
    });
}

}  // namespace thixo
