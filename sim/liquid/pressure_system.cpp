#include "sim/liquid/pressure_system.h"

#include <cmath>

#include "pipeline/base/parallel.h"

namespace thixo {
namespace {

/// The unit of volume U for particles of this spacing: the cube of the power of two next below it [m^3].
Real unit_of(Real spacing) {
    int exponent = 0;
    std::frexp(spacing, &exponent);
    return std::ldexp(Real(1), 3 * (exponent - 1));
}

/// The kernel at several distances at once, without its constants. r_vec points from the neighbour:
///     U w = scale value,   U grad w = gradient slope r_vec
struct Spline {
    Spline(const ConvexSpline& kernel, Real unit)
        : h_inv(kernel.h_inv), scale(kernel.scale * unit), gradient(-3 * scale * kernel.h_inv) {}
    Lanes value(Lanes r) const {
        const Lanes q = r * h_inv, a = positive(1 - q), b = positive(Real(0.5) - q), c = positive(third - q);
        return a * a * a - 4 * (b * b * b) + 3 * (c * c * c);
    }
    /// Two particles in the same place have no direction to part along.
    Lanes slope(Lanes r2, Lanes r) const {
        const Lanes q = r * h_inv, a = positive(1 - q), b = positive(Real(0.5) - q), c = positive(third - q);
        return r2 > 0 ? (a * a - 4 * (b * b) + 3 * (c * c)) / r : Lanes{};
    }
    static constexpr Real third = Real(1.0 / 3), at_centre = Real(11.0 / 18);
    Real h_inv, scale, gradient;
};

void pack(const Particles& particles, PressureSystem& system) {
    const std::size_t n = particles.size();
    resize_packed(*system.ghosts, system.place, {Real(1e9), Real(1e9), Real(1e9), 0});
    resize_packed(*system.ghosts, system.motion, {0, 0, 0, 0});
    system.slope.resize(n);
    for (auto* reals : {&system.excess, &system.rate, &system.inverse_diagonal}) reals->resize(n);
    parallel_for(
        n,
        [&](std::size_t i) {
            const Vec3 &x = particles.position[i], &v = particles.velocity[i];
            const Real volume = particles.rest_volume[i] / system.unit;
            system.place[i] = {x.x(), x.y(), x.z(), square(volume) / (particles.mass[i] / system.unit)};
            system.motion[i] = {v.x(), v.y(), v.z(), volume};
        },
        2048);
    refresh_places(*system.ghosts, system.place);
    refresh_motion(system);
}

void make_room_for_pairs(const NeighbourLists& neighbours, PressureSystem& system) {
    system.first_pair.resize(neighbours.size());
    std::size_t pairs = 0;
    for (std::size_t i = 0; i < neighbours.size(); ++i) {
        system.first_pair[i] = pairs;
        pairs += (neighbours[i].size() + kLanes - 1) / kLanes * kLanes;
    }
    system.pair_slope.resize(pairs);
}

}  // namespace

void measure_density(Particles& particles, const NeighbourLists& neighbours, const Ghosts& ghosts,
                     const std::vector<WallEffect>& walls, const Smoothing& smoothing, PressureSystem& system) {
    system.ghosts = &ghosts;
    system.unit = unit_of(smoothing.spacing);
    pack(particles, system);
    make_room_for_pairs(neighbours, system);
    const Spline spline(smoothing.fluid, system.unit);
    const Real inverse_k = 1 / smoothing.fluid_gradient;
    const Index nobody = system.nobody();
    parallel_for(particles.size(), [&](std::size_t i) {
        const Quad p = system.place[i], u = system.motion[i];
        Lanes share{}, gx{}, gy{}, gz{}, steep{}, rate{};
        Real* pair_slope = system.pair_slope.data() + system.first_pair[i];
        for_each_run(neighbours[i], nobody, [&](const Index* j) {
            Lanes x, y, z, mobility, vx, vy, vz, volume;
            gather(system.place.data(), j, x, y, z, mobility);
            gather(system.motion.data(), j, vx, vy, vz, volume);
            x = p.x - x;
            y = p.y - y;
            z = p.z - z;
            const Lanes r2 = x * x + y * y + z * z, r = root(r2), slope = spline.slope(r2, r), f = volume * slope;
            store(slope, pair_slope);
            pair_slope += kLanes;
            share += volume * spline.value(r);
            gx += f * x;
            gy += f * y;
            gz += f * z;
            steep += mobility * slope * slope * r2;
            rate += f * ((u.x - vx) * x + (u.y - vy) * y + (u.z - vz) * z);
        });
        const WallEffect& w = walls[i];
        const Vec3 g = spline.gradient * Vec3(sum_of(gx), sum_of(gy), sum_of(gz)) + w.gradient;
        const Real volume = u.w, mass = particles.mass[i] / system.unit;
        const Real s = spline.scale * (spline.at_centre * volume + sum_of(share)) + w.share;
        const Real diagonal = volume * inverse_k * (g.squaredNorm() / mass + square(spline.gradient) * sum_of(steep));
        system.slope[i] = {g.x(), g.y(), g.z(), volume / mass * inverse_k};
        system.excess[i] = s - 1;
        system.rate[i] = spline.gradient * sum_of(rate) + xyz(u).dot(w.gradient) - w.inflow;
        // A packing has about 5/h^2 V0/m. Below a five-hundredth of it, no neighbour is near enough to push.
        const Real least = Real(0.01) * square(spline.h_inv) * volume / mass;
        system.inverse_diagonal[i] = diagonal > least ? 1 / diagonal : 0;
        particles.density[i] = mass / volume * s;
    });
}

void find_pressure_acceleration(const std::vector<Real>& pressure, const NeighbourLists& neighbours,
                                const Smoothing& smoothing, PressureSystem& system) {
    const Spline spline(smoothing.fluid, system.unit);
    const Index nobody = system.nobody();
    refresh_places(*system.ghosts, system.place);
    parallel_for(pressure.size(), [&](std::size_t i) {
        const Quad p = system.place[i], slope = system.slope[i];
        Lanes fx{}, fy{}, fz{};
        const Real* pair_slope = system.pair_slope.data() + system.first_pair[i];
        for_each_run(neighbours[i], nobody, [&](const Index* j) {
            Lanes x, y, z, strength;
            gather(system.place.data(), j, x, y, z, strength);
            const Lanes f = strength * load(pair_slope);
            pair_slope += kLanes;
            fx += f * (p.x - x);
            fy += f * (p.y - y);
            fz += f * (p.z - z);
        });
        const Vec3 a =
            -slope.w * (spline.gradient * Vec3(sum_of(fx), sum_of(fy), sum_of(fz)) + pressure[i] * xyz(slope));
        system.motion[i] = {a.x(), a.y(), a.z(), system.motion[i].w};
    });
    refresh_motion(system);
}

Real density_rate(std::size_t i, const NeighbourLists& neighbours, const std::vector<WallEffect>& walls,
                  const Smoothing& smoothing, const PressureSystem& system, bool moving) {
    const Spline spline(smoothing.fluid, system.unit);
    const Index nobody = system.nobody();
    const Quad p = system.place[i], u = system.motion[i];
    Lanes rate{};
    const Real* pair_slope = system.pair_slope.data() + system.first_pair[i];
    for_each_run(neighbours[i], nobody, [&](const Index* j) {
        Lanes x, y, z, unused, vx, vy, vz, volume;
        gather(system.place.data(), j, x, y, z, unused);
        gather(system.motion.data(), j, vx, vy, vz, volume);
        rate += volume * load(pair_slope) * ((u.x - vx) * (p.x - x) + (u.y - vy) * (p.y - y) + (u.z - vz) * (p.z - z));
        pair_slope += kLanes;
    });
    const WallEffect& w = walls[i];
    return spline.gradient * sum_of(rate) + xyz(u).dot(w.gradient) - (moving ? w.inflow : Real(0));
}

Real virial_pressure(std::size_t i, const std::vector<Real>& pressure, const NeighbourLists& neighbours,
                     const std::vector<WallEffect>& walls, const Smoothing& smoothing, const PressureSystem& system) {
    const ConvexSpline& kernel = smoothing.fluid;
    const std::size_t n = pressure.size();
    const Vec3 x = xyz(system.place[i]);
    Real sum = 0;
    for (const Index j : neighbours[i]) {
        const Real r = (x - xyz(system.place[j])).norm();
        const Real other = pressure[j < n ? j : system.ghosts->source[j - n]];
        sum -= system.motion[j].w * (pressure[i] + other) * r * kernel.derivative(r) / 2;
    }
    const WallEffect& w = walls[i];
    sum *= system.unit;
    if (w.share > 0) sum += pressure[i] * std::max(w.distance, Real(0)) * w.gradient.norm();
    return sum / (3 * smoothing.fluid_gradient);
}

}  // namespace thixo
