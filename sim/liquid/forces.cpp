#include "sim/liquid/forces.h"

#include <algorithm>
#include <span>

#include "pipeline/base/parallel.h"

namespace thixo {
namespace {

/// Force per volume on particle i from its neighbours [N/m^3], several at a time. The sums leave out the kernels'
/// constant factors:
///     -45/(pi h^4) (1 - r/h)^2 /r  and  45/(pi h^5) (1 - r/h)
enum class Matter { one, several, mixed };  // mixed: not all of it is liquid
template <Matter kind>
Vec3 force_of_neighbours(std::size_t i, std::span<const Index> neighbours, Index nobody, const Sweep& sweep,
                         const Smoothing& smoothing, Real artificial, Real softening) {
    const Real h_inv = smoothing.pressure.h_inv;
    const Real gradient = 3 * smoothing.pressure.scale * h_inv, laplacian = smoothing.viscosity.laplacian_scale;
    const Quad p = sweep.place[i], v = sweep.motion[i], m = sweep.matter[i];
    Lanes fx{}, fy{}, fz{};
    for_each_run(neighbours, nobody, [&](const Index* j) {
        Lanes x, y, z, pressure, vx, vy, vz, volume;
        gather(sweep.place.data(), j, x, y, z, pressure);
        gather(sweep.motion.data(), j, vx, vy, vz, volume);
        Lanes drag = all_lanes(laplacian * m.x), impedance = all_lanes(artificial * m.y);
        if constexpr (kind != Matter::one) {
            Lanes mu, rho_c, melt, unused;
            gather(sweep.matter.data(), j, mu, rho_c, melt, unused);
            drag = Real(0.5) * laplacian * (m.x + mu);
            impedance = Real(0.5) * artificial * (m.y + rho_c);
            if constexpr (kind == Matter::mixed) {
                const Lanes both = m.z + melt;
                drag = both > 0 ? laplacian * (m.z * m.x + melt * mu) / both : Lanes{};
                volume *= larger(melt, m.z);
            }
        }
        x = p.x - x;
        y = p.y - y;
        z = p.z - z;
        vx = v.x - vx;
        vy = v.y - vy;
        vz = v.z - vz;
        const Lanes r2 = x * x + y * y + z * z, r = root(r2);
        const Lanes q = positive(1 - r * h_inv);
        const Lanes approach = negative(vx * x + vy * y + vz * z);
        const Lanes stress = p.w + pressure - impedance * approach / (r2 + softening);
        // Two particles in the same place have no direction to part along: only viscosity acts.
        const Lanes along = r2 > 0 ? volume * stress * gradient * q * q / r : Lanes{};
        drag *= volume * q;
        fx += along * x - drag * vx;
        fy += along * y - drag * vy;
        fz += along * z - drag * vz;
    });
    return {sum_of(fx), sum_of(fy), sum_of(fz)};
}

}  // namespace

void compute_accelerations(Particles& particles, const NeighbourLists& neighbours, const Smoothing& smoothing,
                           const ForceParams& params, const Sweep& sweep) {
    const Real s = smoothing.support / 2;
    const Real softening = Real(0.01) * square(s);
    const Real artificial = params.artificial_viscosity * s;
    const Index nobody = sweep.nobody();
    parallel_for(particles.size(), [&](std::size_t i) {
        const auto force = sweep.mixed          ? force_of_neighbours<Matter::mixed>
                           : sweep.one_material ? force_of_neighbours<Matter::one>
                                                : force_of_neighbours<Matter::several>;
        Vec3 f = force(i, neighbours[i], nobody, sweep, smoothing, artificial, softening);
        const Quad v = sweep.motion[i];
        const WallEffect& w = sweep.walls[i];
        const Real melt = sweep.matter[i].z;
        f -= melt * std::max(sweep.place[i].w, Real(0)) * w.gradient;
        f += melt * 2 * sweep.matter[i].x * (w.drag_velocity - w.drag * xyz(v));
        // The steps of solids add the accelerations from outside themselves.
        const Vec3 outside = is_elastic(particles.phase[i])
                                 ? Vec3(0, 0, 0)
                                 : acceleration_from_outside(params.outside, particles.position[i], xyz(v));
        particles.acceleration[i] = outside + v.w / particles.mass[i] * f;
    });
}

}  // namespace thixo
