#include "sim/liquid/tension.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "pipeline/base/parallel.h"
#include "sim/space/sampling.h"

namespace thixo {
namespace {

/// Shares of the two terms in the tension of a cut packing [1].
struct Parts {
    Real stress, deficit;
};

/// The shares for settled drops. Their surface is no cut packing: how much closer or looser it lies depends on the
/// pressure solver. The shares are calibrated by the pressure in drops of 7 to 11 spacings (gate drop). The deficit's
/// is as small as still holds single particles: a larger one draws jets of a few spacings into beads.
Parts settled(const Strategy& strategy) {
    return strategy.incompressible ? Parts{Real(0.68), Real(0.3)} : Parts{Real(1.3), Real(0.1)};
}

constexpr Real kLeastColour = Real(0.5);

/// S = |g| 1 - g g/|g|.
Mat3 surface_stress(const Vec3& g) {
    const Real size = g.norm();
    if (!(size > 0)) return Mat3::Zero();
    return size * Mat3::Identity() - g * g.transpose() / size;
}

/// A packing cut above layer 0, and sums over it for a site of each layer. Layers count downwards.
struct CutPacking {
    explicit CutPacking(const Smoothing& smoothing) : kernel(smoothing.density), d(smoothing.spacing) {
        reach = static_cast<int>(smoothing.support / packing_distance(d)) + 2;
    }
    /// sum over the sites of the packing of f(place relative to a site of the layer, their layer).
    template <class T, class F>
    T sum(int layer, T zero, F&& f) const {
        for (int k = -reach; k <= layer; ++k)
            for (int j = -2 * reach; j <= 2 * reach; ++j)
                for (int i = -2 * reach; i <= 2 * reach; ++i) zero += f(packing_site(i, j, k, d), layer - k);
        return zero;
    }
    Real colour(int layer) const {
        return sum(layer, Real(0), [&](const Vec3& x, int) { return cube(d) * kernel.value(x.squaredNorm()); });
    }
    Real volume(int layer) const { return cube(d) / std::max(colour(layer), kLeastColour); }
    Poly6 kernel;
    Real d;
    int reach;
};

/// Tension of the stress, per area: half the pull along the layers of all pairs of a site of each layer.
Real tension_of_stress(const CutPacking& cut) {
    std::vector<Real> volume;
    std::vector<Mat3> stress;
    for (int k = 0; k <= 3 * cut.reach; ++k) volume.push_back(cut.volume(std::min(k, cut.reach)));
    for (int k = 0; k <= 2 * cut.reach; ++k)
        stress.push_back(surface_stress(cut.sum(k, Vec3(0, 0, 0), [&](const Vec3& x, int layer) -> Vec3 {
            return -volume[static_cast<std::size_t>(layer)] * cut.kernel.gradient_factor(x.squaredNorm()) * x;
        })));
    Real virial = 0;
    for (std::size_t k = 0; k <= static_cast<std::size_t>(cut.reach); ++k)
        virial += cut.sum(static_cast<int>(k), Real(0), [&](const Vec3& x, int layer) {
            const auto l = static_cast<std::size_t>(layer);
            const Vec3 f =
                -volume[k] * volume[l] * cut.kernel.gradient_factor(x.squaredNorm()) * ((stress[k] + stress[l]) * x);
            return f.x() * x.x() + f.y() * x.y();
        }) / 4;
    return virial / cube(cut.d) * packing_layer(cut.d);
}

Real energy_of_deficit(const CutPacking& cut) {
    Real sum = 0;
    for (int k = 0; k <= cut.reach; ++k) sum += square(std::max(1 - cut.colour(k), Real(0))) / 2;
    return sum * packing_layer(cut.d);
}

/// The integral of w_spiky over the wall, over all layers; the first stands half a layer off the wall. With p = 1 -
/// z/h, the integral over a plane at distance z, and that over the half-space beyond it, are
///     30/h (p^4/4 - p^5/5)
///     30 (p^5/20 - p^6/30)
Real reach_into_wall(const Smoothing& smoothing) {
    const double layer = packing_layer(smoothing.spacing), h = smoothing.support;
    double sum = 0;
    for (double z = layer / 2; z < h; z += layer) {
        const double p = 1 - z / h;
        sum += layer * 30 * (std::pow(p, 5) / 20 - std::pow(p, 6) / 30);
    }
    return static_cast<Real>(sum);
}

/// sum_j V_j w_ij without i, and its gradient.
struct ColourSums {
    Real value;
    Vec3 gradient;
};

ColourSums colour_sums(std::size_t i, std::span<const Index> neighbours, const Sweep& sweep, const Poly6& kernel,
                       const std::vector<Real>& volume) {
    const Quad at = sweep.place[i];
    Lanes sum{}, gx{}, gy{}, gz{};
    for_each_run(neighbours, sweep.nobody(), [&](const Index* j) {
        Lanes x, y, z, unused;
        gather(sweep.place.data(), j, x, y, z, unused);
        x = at.x - x;
        y = at.y - y;
        z = at.z - z;
        const Lanes q = positive(1 - (x * x + y * y + z * z) * kernel.h2_inv),
                    weight = gather(volume.data(), j) * q * q;
        sum += weight * q;
        gx -= weight * x;
        gy -= weight * y;
        gz -= weight * z;
    });
    return {kernel.scale * sum_of(sum), 6 * kernel.scale * kernel.h2_inv * Vec3(sum_of(gx), sum_of(gy), sum_of(gz))};
}

/// sum_j V_j (S_i + S_j) grad w_ij.
Vec3 pull_of_neighbours(std::size_t i, std::span<const Index> neighbours, const Sweep& sweep, const Poly6& kernel,
                        const TensionScratch& scratch) {
    const Quad at = sweep.place[i], direct = scratch.direct[i], shear = scratch.shear[i];
    Lanes fx{}, fy{}, fz{};
    for_each_run(neighbours, sweep.nobody(), [&](const Index* j) {
        Lanes x, y, z, unused, xx, yy, zz, volume, yz, xz, xy;
        gather(sweep.place.data(), j, x, y, z, unused);
        gather(scratch.direct.data(), j, xx, yy, zz, volume);
        gather(scratch.shear.data(), j, yz, xz, xy, unused);
        x = at.x - x;
        y = at.y - y;
        z = at.z - z;
        const Lanes q = positive(1 - (x * x + y * y + z * z) * kernel.h2_inv), along = volume * q * q;
        xx += direct.x;
        yy += direct.y;
        zz += direct.z;
        yz += shear.x;
        xz += shear.y;
        xy += shear.z;
        fx -= along * (xx * x + xy * y + xz * z);
        fy -= along * (xy * x + yy * y + yz * z);
        fz -= along * (xz * x + yz * y + zz * z);
    });
    return 6 * kernel.scale * kernel.h2_inv * Vec3(sum_of(fx), sum_of(fy), sum_of(fz));
}

/// sum over walls of beta integral of grad w_spiky.
Vec3 pull_of_walls(const Walls& walls, const Vec3& x, WallCursor& cursor) {
    Vec3 sum(0, 0, 0);
    for (std::size_t k = 0; k < walls.list.size(); ++k) {
        const Wall& w = walls.list[k];
        if (w.adhesion > 0) sum += w.adhesion * (w.turn * w.map.at(w.to_wall(x), cursor.at[k]).gradient);
    }
    return sum;
}

}  // namespace

TensionScale::TensionScale(const Smoothing& smoothing, const Strategy& strategy)
    : stress(settled(strategy).stress / tension_of_stress(CutPacking(smoothing))),
      deficit(settled(strategy).deficit / energy_of_deficit(CutPacking(smoothing))),
      adhesion(1 / reach_into_wall(smoothing)) {}

void add_tension(Particles& particles, const SweepInput& input, const TensionScale& scale, const Materials& materials,
                 TensionScratch& scratch) {
    const auto& [neighbours, walls, smoothing, sweep] = input;
    if (std::ranges::all_of(materials, [](const ResolvedMaterial& m) { return m.tension <= 0; })) return;
    const bool wet = std::ranges::any_of(walls.list, [](const Wall& w) { return w.adhesion > 0; });
    const Poly6& kernel = smoothing.density;
    const auto tension = [&](std::size_t i) {
        return materials[static_cast<std::size_t>(particles.material[i])].tension;
    };
    resize_packed(sweep.ghosts, scratch.own, Real(0));
    resize_packed(sweep.ghosts, scratch.filled, Real(0));
    resize_packed(sweep.ghosts, scratch.direct, Quad{});
    resize_packed(sweep.ghosts, scratch.shear, Quad{});
    parallel_for(
        particles.size(), [&](std::size_t i) { scratch.own[i] = particles.melt[i] * particles.rest_volume[i]; }, 2048);
    refresh_ghosts(sweep.ghosts, scratch.own);
    parallel_for(
        particles.size(),
        [&](std::size_t i) {
            const Real c =
                scratch.own[i] * kernel.value(0) + colour_sums(i, neighbours[i], sweep, kernel, scratch.own).value;
            scratch.filled[i] = scratch.own[i] / std::max(c, kLeastColour);
            scratch.direct[i].x = std::max(1 - c, Real(0));
        },
        256);
    refresh_ghosts(sweep.ghosts, scratch.filled);
    parallel_for(
        particles.size(),
        [&](std::size_t i) {
            const Vec3 g = colour_sums(i, neighbours[i], sweep, kernel, scratch.filled).gradient;
            const Mat3 s = tension(i) *
                           (scale.stress * surface_stress(g) + scale.deficit * scratch.direct[i].x * Mat3::Identity());
            scratch.direct[i] = {s(0, 0), s(1, 1), s(2, 2), scratch.filled[i]};
            scratch.shear[i] = {s(1, 2), s(0, 2), s(0, 1), 0};
        },
        256);
    refresh_ghosts(sweep.ghosts, scratch.direct);
    refresh_ghosts(sweep.ghosts, scratch.shear);
    parallel_chunks(
        particles.size(),
        [&](std::size_t begin, std::size_t end, std::size_t) {
            WallCursor cursor(walls);
            for (std::size_t i = begin; i < end; ++i) {
                Vec3 f = scratch.filled[i] * pull_of_neighbours(i, neighbours[i], sweep, kernel, scratch);
                if (wet && sweep.walls[i].share > 0)
                    f += scratch.own[i] * 2 * tension(i) * scale.adhesion *
                         pull_of_walls(walls, particles.position[i], cursor);
                particles.acceleration[i] += f / particles.mass[i];
            }
        },
        256);
}

}  // namespace thixo
