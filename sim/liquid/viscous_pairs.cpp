#include "sim/liquid/viscous_pairs.h"

#include <algorithm>
#include <array>
#include <cmath>

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

}  // namespace thixo
