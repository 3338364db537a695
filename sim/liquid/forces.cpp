#include "sim/liquid/forces.h"

#include <algorithm>
#include <span>

#include "pipeline/base/parallel.h"
#include "sim/liquid/viscous_pairs.h"

namespace thixo {
namespace {

Vec3 xyz(const Quad& q) { return {q.x, q.y, q.z}; }

/// Force per volume on particle i from its neighbours [N/m^3], several at a time. The sums leave out the kernels'
/// constant factors:
///     -45/(pi h^4) (1 - r/h)^2 /r  and  k(0) (1 - r^2/h^2)^2
enum class Matter { one, several, mixed };  // mixed: not all of it is liquid
template <Matter kind>
Vec3 force_of_neighbours(std::size_t i, std::span<const Index> neighbours, const Sweep& sweep,
                         const Smoothing& smoothing, const PairKernel& kernel, Real artificial, Real softening) {
    const Real h_inv = smoothing.pressure.h_inv;
    const Real gradient = 3 * smoothing.pressure.scale * h_inv, central = kCentral * kernel.scale;
    const Quad p = sweep.place[i], v = sweep.motion[i], m = sweep.matter[i];
    Lanes fx{}, fy{}, fz{};
    for_each_run(neighbours, sweep.nobody(), [&](const Index* j) {
        Lanes x, y, z, pressure, vx, vy, vz, volume;
        gather(sweep.place.data(), j, x, y, z, pressure);
        gather(sweep.motion.data(), j, vx, vy, vz, volume);
        Lanes drag = all_lanes(central * m.x), impedance = all_lanes(artificial * m.y);
        if constexpr (kind != Matter::one) {
            Lanes mu, rho_c, melt, unused;
            gather(sweep.matter.data(), j, mu, rho_c, melt, unused);
            drag = Real(0.5) * central * (m.x + mu);
            impedance = Real(0.5) * artificial * (m.y + rho_c);
            if constexpr (kind == Matter::mixed) {
                const Lanes both = m.z + melt;
                drag = both > 0 ? central * (m.z * m.x + melt * mu) / both : Lanes{};
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
        const Lanes q = positive(1 - r * h_inv), near = positive(1 - r2 * kernel.h2_inv);
        const Lanes parting = vx * x + vy * y + vz * z;
        const Lanes stress = p.w + pressure - impedance * negative(parting) / (r2 + softening);
        // Two particles in the same place have no direction to act along.
        const Lanes along =
            r2 > 0 ? volume * (stress * gradient * q * q / r - drag * near * near * parting / r2) : Lanes{};
        fx += along * x;
        fy += along * y;
        fz += along * z;
    });
    return {sum_of(fx), sum_of(fy), sum_of(fz)};
}

}  // namespace

void compute_accelerations(Particles& particles, const SweepInput& input, const ForceParams& params) {
    const auto& [neighbours, walls, smoothing, sweep] = input;
    const Real s = smoothing.support / 2;
    const Real softening = Real(0.01) * square(s);
    const Real artificial = params.artificial_viscosity * s;
    const PairKernel kernel(smoothing);
    const auto force = sweep.mixed          ? force_of_neighbours<Matter::mixed>
                       : sweep.one_material ? force_of_neighbours<Matter::one>
                                            : force_of_neighbours<Matter::several>;
    parallel_chunks(
        particles.size(),
        [&](std::size_t begin, std::size_t end, std::size_t) {
            WallCursor cursor(walls);
            for (std::size_t i = begin; i < end; ++i) {
                Vec3 f = force(i, neighbours[i], sweep, smoothing, kernel, artificial, softening);
                const Vec3 x = particles.position[i], v = xyz(sweep.motion[i]);
                const WallEffect& w = sweep.walls[i];
                const Quad& matter = sweep.matter[i];
                f -= matter.z * std::max(sweep.place[i].w, Real(0)) * w.gradient;
                if (w.drag > 0 && matter.x > 0) {
                    const WallDrag drag = wall_drag(walls, x, smoothing.support, cursor);
                    f += matter.z * kCentral * matter.x * (drag.moving - drag.friction * v);
                }
                // The steps of solids add the accelerations from outside themselves.
                const Vec3 outside =
                    is_elastic(particles.phase[i]) ? Vec3(0, 0, 0) : acceleration_from_outside(params.outside, x, v);
                particles.acceleration[i] = outside + sweep.motion[i].w / particles.mass[i] * f;
            }
        },
        256);
}

}  // namespace thixo
