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
    return strategy.incompressible ? Parts{Real(0.66), Real(0.3)} : Parts{Real(1.3), Real(0.1)};
}

constexpr Real kLeastColour = Real(0.5);
// Particles with less than this above the least colour take a smaller part of their neighbours' torques.
constexpr Real kTakesLess = Real(0.1);

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

/// sum_j V_j w_ij without i.
Real colour_of(std::size_t i, std::span<const Index> neighbours, const Sweep& sweep, const Poly6& kernel,
               const std::vector<Real>& volume) {
    const Quad at = sweep.place[i];
    Lanes sum{};
    for_each_run(neighbours, sweep.nobody(), [&](const Index* j) {
        Lanes x, y, z, unused;
        gather(sweep.place.data(), j, x, y, z, unused);
        x = at.x - x;
        y = at.y - y;
        z = at.z - z;
        const Lanes q = positive(1 - (x * x + y * y + z * z) * kernel.h2_inv);
        sum += gather(volume.data(), j) * q * q * q;
    });
    return kernel.scale * sum_of(sum);
}

/// The gradient of the colour, the moment of the gradient's terms, and what neighbours take of a torque:
///     g = sum_j V_j grad w_ij,   m = - sum_j V_j grad w_ij (x_i - x_j)^T,   sum_j k_j V_j w_ij
struct Slope {
    Vec3 gradient;
    Mat3 moment;
    Real taken;
};

Slope slope_of(std::size_t i, std::span<const Index> neighbours, const Sweep& sweep, const Poly6& kernel,
               const TensionScratch& scratch) {
    const Quad at = sweep.place[i];
    Lanes taken{}, gx{}, gy{}, gz{}, xx{}, yy{}, zz{}, yz{}, xz{}, xy{};
    for_each_run(neighbours, sweep.nobody(), [&](const Index* j) {
        Lanes x, y, z, unused;
        gather(sweep.place.data(), j, x, y, z, unused);
        x = at.x - x;
        y = at.y - y;
        z = at.z - z;
        const Lanes q = positive(1 - (x * x + y * y + z * z) * kernel.h2_inv),
                    weight = gather(scratch.filled.data(), j) * q * q;
        taken += gather(scratch.taking.data(), j) * q * q * q;
        const Lanes wx = weight * x, wy = weight * y, wz = weight * z;
        gx -= wx;
        gy -= wy;
        gz -= wz;
        xx += wx * x;
        yy += wy * y;
        zz += wz * z;
        yz += wy * z;
        xz += wx * z;
        xy += wx * y;
    });
    const Real scale = 6 * kernel.scale * kernel.h2_inv;
    Mat3 m;
    m << sum_of(xx), sum_of(xy), sum_of(xz), sum_of(xy), sum_of(yy), sum_of(yz), sum_of(xz), sum_of(yz), sum_of(zz);
    return {scale * Vec3(sum_of(gx), sum_of(gy), sum_of(gz)), scale * m, kernel.scale * sum_of(taken)};
}

/// Torque of a stencil of stress S, over V_i [Pa]: the axial vector of S m.
Vec3 torque_of(const Mat3& stress, const Mat3& moment) {
    const Mat3 t = stress * moment;
    return {t(2, 1) - t(1, 2), t(0, 2) - t(2, 0), t(1, 0) - t(0, 1)};
}

/// (tr m 1 - m)^-1: the couple of a stencil over its torque. Neighbours in one line can make no torque about it. Where
/// they are nearly so, the matrix is widened: a torque that others share with them would make forces without bound.
/// The value det(1 - m/tr m) is 8/27 in a full neighbourhood, and 1/4 in a sheet.
Mat3 couple_over_torque(const Mat3& moment) {
    constexpr double kSlender = 0.15;
    const double trace = static_cast<double>(moment.trace());
    if (!(trace > 0)) return Mat3::Zero();
    const Mat3d inertia = Mat3d::Identity() - moment.cast<double>() / trace;
    const double widened = std::max(kSlender - inertia.determinant(), 0.0);
    return ((inertia + widened * Mat3d::Identity()).inverse() / trace).cast<Real>();
}

/// sum_j w_ij b_j without i.
Vec3 torque_of_neighbours(std::size_t i, std::span<const Index> neighbours, const Sweep& sweep, const Poly6& kernel,
                          const std::vector<Quad>& torque) {
    const Quad at = sweep.place[i];
    Lanes sx{}, sy{}, sz{};
    for_each_run(neighbours, sweep.nobody(), [&](const Index* j) {
        Lanes x, y, z, tx, ty, tz, unused;
        gather(sweep.place.data(), j, x, y, z, unused);
        gather(torque.data(), j, tx, ty, tz, unused);
        x = at.x - x;
        y = at.y - y;
        z = at.z - z;
        const Lanes q = positive(1 - (x * x + y * y + z * z) * kernel.h2_inv), weight = q * q * q;
        sx += weight * tx;
        sy += weight * ty;
        sz += weight * tz;
    });
    return kernel.scale * Vec3(sum_of(sx), sum_of(sy), sum_of(sz));
}

/// sum_j V_j (S_i + S_j - [o_i + o_j]x) grad w_ij.
Vec3 pull_of_neighbours(std::size_t i, std::span<const Index> neighbours, const Sweep& sweep, const Poly6& kernel,
                        const TensionScratch& scratch) {
    const Quad at = sweep.place[i], direct = scratch.direct[i], shear = scratch.shear[i], couple = scratch.couple[i];
    Lanes fx{}, fy{}, fz{};
    for_each_run(neighbours, sweep.nobody(), [&](const Index* j) {
        Lanes x, y, z, unused, xx, yy, zz, volume, yz, xz, xy, ox, oy, oz;
        gather(sweep.place.data(), j, x, y, z, unused);
        gather(scratch.direct.data(), j, xx, yy, zz, volume);
        gather(scratch.shear.data(), j, yz, xz, xy, unused);
        gather(scratch.couple.data(), j, ox, oy, oz, unused);
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
        ox += couple.x;
        oy += couple.y;
        oz += couple.z;
        fx -= along * (xx * x + (xy + oz) * y + (xz - oy) * z);
        fy -= along * ((xy - oz) * x + yy * y + (yz + ox) * z);
        fz -= along * ((xz + oy) * x + (yz - ox) * y + zz * z);
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

Real tension_of(std::size_t i, const Particles& particles, const Materials& materials) {
    return materials[static_cast<std::size_t>(particles.material[i])].tension;
}

/// V0, V, k V, and 1 - c in direct.x.
void find_colours(const Particles& particles, const SweepInput& input, TensionScratch& scratch) {
    const Sweep& sweep = input.sweep;
    const Poly6& kernel = input.smoothing.density;
    for (auto* numbers : {&scratch.own, &scratch.filled, &scratch.taking})
        resize_packed(sweep.ghosts, *numbers, Real(0));
    resize_packed(sweep.ghosts, scratch.direct, Quad{});
    parallel_for(
        particles.size(), [&](std::size_t i) { scratch.own[i] = particles.melt[i] * particles.rest_volume[i]; }, 2048);
    refresh_ghosts(sweep.ghosts, scratch.own);
    parallel_for(
        particles.size(),
        [&](std::size_t i) {
            const Real c =
                scratch.own[i] * kernel.value(0) + colour_of(i, input.neighbours[i], sweep, kernel, scratch.own);
            scratch.filled[i] = scratch.own[i] / std::max(c, kLeastColour);
            scratch.taking[i] = scratch.filled[i] * std::clamp((c - kLeastColour) / kTakesLess, Real(0), Real(1));
            scratch.direct[i].x = std::max(1 - c, Real(0));
        },
        256);
    refresh_ghosts(sweep.ghosts, scratch.filled);
    refresh_ghosts(sweep.ghosts, scratch.taking);
}

/// S, b, and (tr m 1 - m)^-1.
void find_stresses(const Particles& particles, const SweepInput& input, const TensionScale& scale,
                   const Materials& materials, TensionScratch& scratch) {
    const Sweep& sweep = input.sweep;
    const Poly6& kernel = input.smoothing.density;
    resize_packed(sweep.ghosts, scratch.shear, Quad{});
    resize_packed(sweep.ghosts, scratch.torque, Quad{});
    scratch.yielding.resize(particles.size());
    parallel_for(
        particles.size(),
        [&](std::size_t i) {
            const Slope slope = slope_of(i, input.neighbours[i], sweep, kernel, scratch);
            const Mat3 s =
                tension_of(i, particles, materials) * (scale.stress * surface_stress(slope.gradient) +
                                                       scale.deficit * scratch.direct[i].x * Mat3::Identity());
            const Real volume = scratch.filled[i], taken = volume * kernel.value(0) + slope.taken;
            const Vec3 torque = taken > 0 ? Vec3(volume / taken * torque_of(s, slope.moment)) : Vec3(0, 0, 0);
            scratch.direct[i] = {s(0, 0), s(1, 1), s(2, 2), volume};
            scratch.shear[i] = {s(1, 2), s(0, 2), s(0, 1), 0};
            scratch.torque[i] = {torque.x(), torque.y(), torque.z(), 0};
            scratch.yielding[i] = couple_over_torque(slope.moment);
        },
        256);
    for (auto* quads : {&scratch.direct, &scratch.shear, &scratch.torque}) refresh_ghosts(sweep.ghosts, *quads);
}

/// The couples o that take the torques.
void find_couples(const SweepInput& input, TensionScratch& scratch) {
    const Sweep& sweep = input.sweep;
    const Poly6& kernel = input.smoothing.density;
    resize_packed(sweep.ghosts, scratch.couple, Quad{});
    parallel_for(
        scratch.yielding.size(),
        [&](std::size_t i) {
            const Quad& own = scratch.torque[i];
            Vec3 torque = kernel.value(0) * Vec3(own.x, own.y, own.z);
            if (scratch.taking[i] > 0)
                torque += scratch.taking[i] / scratch.filled[i] *
                          torque_of_neighbours(i, input.neighbours[i], sweep, kernel, scratch.torque);
            const Vec3 couple = scratch.yielding[i] * torque;
            scratch.couple[i] = {couple.x(), couple.y(), couple.z(), 0};
        },
        256);
    refresh_ghosts(sweep.ghosts, scratch.couple);
}

}  // namespace

TensionScale::TensionScale(const Smoothing& smoothing, const Strategy& strategy)
    : stress(settled(strategy).stress / tension_of_stress(CutPacking(smoothing))),
      deficit(settled(strategy).deficit / energy_of_deficit(CutPacking(smoothing))),
      adhesion(1 / reach_into_wall(smoothing)) {}

Vec3 adhesion_on(std::size_t i, const Particles& particles, const Walls& walls, const TensionScale& scale,
                 const Materials& materials, const TensionScratch& scratch, WallCursor& cursor) {
    return scratch.own[i] * 2 * tension_of(i, particles, materials) * scale.adhesion *
           pull_of_walls(walls, particles.position[i], cursor);
}

void add_tension(Particles& particles, const SweepInput& input, const TensionScale& scale, const Materials& materials,
                 TensionScratch& scratch) {
    const auto& [neighbours, walls, smoothing, sweep] = input;
    if (std::ranges::all_of(materials, [](const ResolvedMaterial& m) { return m.tension <= 0; })) return;
    const bool wet = std::ranges::any_of(walls.list, [](const Wall& w) { return w.adhesion > 0; });
    const Poly6& kernel = smoothing.density;
    find_colours(particles, input, scratch);
    find_stresses(particles, input, scale, materials, scratch);
    find_couples(input, scratch);
    parallel_chunks(
        particles.size(),
        [&](std::size_t begin, std::size_t end, std::size_t) {
            WallCursor cursor(walls);
            for (std::size_t i = begin; i < end; ++i) {
                Vec3 f = scratch.filled[i] * pull_of_neighbours(i, neighbours[i], sweep, kernel, scratch);
                if (wet && sweep.walls[i].share > 0)
                    f += adhesion_on(i, particles, walls, scale, materials, scratch, cursor);
                particles.acceleration[i] += f / particles.mass[i];
            }
        },
        256);
}

}  // namespace thixo
