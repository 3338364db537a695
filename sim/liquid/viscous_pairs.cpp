#include "sim/liquid/viscous_pairs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "pipeline/base/parallel.h"

namespace thixo {
namespace {

/// Friction of a wall over the integral of lap w_visc, by distance over support: kCells + 1 values over [0, 1] [1].
class FrictionTable {
  public:
    FrictionTable() {
        for (std::size_t k = 0; k <= kCells; ++k) {
            // At the ends the ratios have limits, but no value: the table is constant near them.
            const double q = std::clamp(static_cast<double>(k) / kCells, 0.05, 0.999);
            const WallFriction f = wall_friction_of(q, 1);
            along_[k] = static_cast<Real>(f.along);
            across_[k] = static_cast<Real>(f.across);
        }
    }
    /// W/(5 mu V) of a wall with these integrals, its normal in the wall's frame [1/m^2].
    Mat3 friction(const WallIntegrals& in, Real support) const {
        const Real place = std::clamp(in.distance * (1 / support), Real(0), Real(1)) * kCells;
        const auto k = std::min(static_cast<std::size_t>(place), kCells - 1);
        const Real part = place - static_cast<Real>(k);
        const Real along = along_[k] + part * (along_[k + 1] - along_[k]);
        const Real across = across_[k] + part * (across_[k + 1] - across_[k]);
        const Real length = in.gradient.norm();
        // In the middle of a gap the walls' normals cancel, and no direction is normal.
        if (!(length > 0)) return in.laplacian * (2 * along + across) / 3 * Mat3::Identity();
        const Vec3 n = in.gradient / length;
        return in.laplacian * (along * Mat3::Identity() + (across - along) * n * n.transpose());
    }

  private:
    static constexpr std::size_t kCells = 32;
    std::array<Real, kCells + 1> along_, across_;
};

/// Viscous force per volume on particle i from its neighbours [N/m^3].
Vec3 friction_of_neighbours(std::size_t i, std::span<const Index> neighbours, const Sweep& sweep,
                            const PairKernel& kernel) {
    const Quad p = sweep.place[i], v = sweep.motion[i];
    const Real own = sweep.matter[i].x;
    Lanes fx{}, fy{}, fz{};
    for_each_run(neighbours, sweep.nobody(), [&](const Index* j) {
        Lanes x, y, z, vx, vy, vz, volume, mu, unused, unused2, unused3;
        gather(sweep.place.data(), j, x, y, z, unused);
        gather(sweep.motion.data(), j, vx, vy, vz, volume);
        gather(sweep.matter.data(), j, mu, unused, unused2, unused3);
        x = p.x - x;
        y = p.y - y;
        z = p.z - z;
        const Lanes r2 = x * x + y * y + z * z, near = positive(1 - r2 * kernel.h2_inv), sum = own + mu;
        const Lanes parting = (v.x - vx) * x + (v.y - vy) * y + (v.z - vz) * z;
        // Two particles in the same place have no direction to act along.
        // A volume times a viscosity and a slow motion leaves the range of a float at micrometres: units cancel first.
        const Lanes rate = kernel.scale * volume * (2 * own * mu / sum) * (parting / r2);
        const Lanes along = r2 > 0 && sum > 0 ? rate * near * near : Lanes{};
        fx -= along * x;
        fy -= along * y;
        fz -= along * z;
    });
    return kCentral * Vec3(sum_of(fx), sum_of(fy), sum_of(fz));
}

}  // namespace

PairKernel::PairKernel(const Smoothing& smoothing) : h2_inv(1 / square(smoothing.support)) {
    const Poly6 bare(smoothing.support);
    scale = 12 * bare.scale * h2_inv / packed_gradient(bare, smoothing.spacing);
}

WallDrag wall_drag(const Walls& walls, const Vec3& x, Real support, WallCursor& cursor) {
    static const FrictionTable table;
    WallDrag sum;
    for (std::size_t k = 0; k < walls.list.size(); ++k) {
        const Wall& w = walls.list[k];
        if (!w.no_slip) continue;
        const WallIntegrals in = w.map.at(w.to_wall(x), cursor.at[k]);
        if (in.laplacian <= 0) continue;
        const Mat3 friction = w.turn * table.friction(in, support) * w.turn.transpose();
        sum.friction += friction;
        sum.moving += friction * w.velocity_at(x);
    }
    return sum;
}

WallFriction wall_friction_of(double distance, double support) {
    // Integrals over planes at depth z = q h, then over z beyond the wall, of k times (n.T)^2 z and (n.N)^2 z are
    //     945/(16 h) T,  945/(16 h) S
    // That of lap w_visc alone is
    //     90/h^2 L
    const double q = distance / support, q2 = q * q, q4 = q2 * q2, log_q = std::log(q);
    const double along = 1.0 / 96 - (q2 / 12 - q4 * q2 / 12 + q4 * q4 / 96 + q4 / 4 * log_q);
    const double across = 1.0 / 48 - (-q4 / 4 - q4 / 2 * log_q + q4 * q2 / 3 - q4 * q4 / 16);
    const double all = 1.0 / 12 - q / 6 + q2 * q / 6 - q4 / 12;
    constexpr double kScale = 945.0 / 16 / 90;
    return {kScale * along / (q * all), kScale * across / (q * all)};
}

void compute_viscous_accelerations(Particles& particles, const SweepInput& input, const Outside& outside) {
    const auto& [neighbours, walls, smoothing, sweep] = input;
    const PairKernel kernel(smoothing);
    parallel_chunks(
        particles.size(),
        [&](std::size_t begin, std::size_t end, std::size_t) {
            WallCursor cursor(walls);
            for (std::size_t i = begin; i < end; ++i) {
                const Vec3 x = particles.position[i], v = xyz(sweep.motion[i]);
                const Real mu = sweep.matter[i].x;
                Vec3 f(0, 0, 0);
                if (mu > 0) f = friction_of_neighbours(i, neighbours[i], sweep, kernel);
                if (mu > 0 && sweep.walls[i].drag > 0) {
                    const WallDrag drag = wall_drag(walls, x, smoothing.support, cursor);
                    f += kCentral * mu * (drag.moving - drag.friction * v);
                }
                const Vec3 own =
                    is_elastic(particles.phase[i]) ? Vec3(0, 0, 0) : acceleration_from_outside(outside, x, v);
                particles.acceleration[i] = own + sweep.motion[i].w / particles.mass[i] * f;
            }
        },
        256);
}

}  // namespace thixo
