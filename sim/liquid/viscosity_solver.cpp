#include "sim/liquid/viscosity_solver.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/power_of_two.h"
#include "sim/liquid/viscous_pairs.h"

namespace thixo {
namespace {

using Run = ViscosityScratch::Run;
using Block = ViscosityScratch::Block;

double dot(const Quad& a, const Quad& b) {
    return static_cast<double>(a.x) * b.x + static_cast<double>(a.y) * b.y + static_cast<double>(a.z) * b.z;
}
Vec3 product(const Block& b, const Vec3& v) {
    return {b.xx * v.x() + b.xy * v.y() + b.xz * v.z(), b.xy * v.x() + b.yy * v.y() + b.yz * v.z(),
            b.xz * v.x() + b.yz * v.y() + b.zz * v.z()};
}
Block block(const Mat3& m) { return {m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(0, 2), m(1, 2)}; }

/// Corrects a disordered neighbourhood, whose moment M is not 1. It does not make up for a missing half.
Real evened(Real moment) { return 1 / std::max(moment, Real(0.9)); }

/// Calls f(run of pairs, run of indices) for all runs of a particle's neighbours.
template <class F>
void for_each_pair_run(const ViscosityScratch& s, std::size_t i, std::span<const Index> neighbours, Index nobody,
                       F&& f) {
    const Run* run = s.runs.data() + s.first[i];
    for_each_run(neighbours, nobody, [&](const Index* j) { f(*run++, j); });
}

class Solver {
  public:
    Solver(Particles& particles, const NeighbourLists& neighbours, const Sweep& sweep, const ViscositySolve& params,
           Real support, ViscosityScratch& scratch)
        : p_(particles),
          neighbours_(neighbours),
          sweep_(sweep),
          params_(params),
          s_(scratch),
          n_(particles.size()),
          dt_(static_cast<Real>(params.kick)),
          per_volume_(1 / cube(power_of_two_below(support))) {
        resize_packed(sweep.ghosts, s_.matter, Quad{0, 0, 0, 0});
        resize_packed(sweep.ghosts, s_.direction, Quad{0, 0, 0, 0});
        s_.diagonal.resize(n_);
        s_.inverse.resize(n_);
        s_.target.resize(n_);
        s_.velocity.resize(n_);
        s_.residual.resize(n_);
        s_.product.resize(n_);
    }

    /// mu, V and 1/M of all particles.
    void set_matter(const Materials& materials, const PairKernel& kernel) {
        parallel_for(n_, [&](std::size_t i) {
            Real mu = materials[static_cast<std::size_t>(p_.material[i])].implicit_viscosity;
            if (sweep_.mixed && sweep_.melt[i] == 0) mu = 1;  // of a solid: drops out of the pairs' means
            s_.matter[i] = {mu, sweep_.motion[i].w * per_volume_, evened(moment(i, kernel)), sweep_.matter[i].z};
        });
        refresh_ghosts(sweep_.ghosts, s_.matter);
    }

    /// Sets v*, the first guess, and the walls' part of the diagonal and of the right-hand side (in residual).
    void set_target(const Walls& walls, const Smoothing& smoothing) {
        parallel_chunks(n_, [&](std::size_t begin, std::size_t end, std::size_t) {
            WallCursor cursor(walls);
            for (std::size_t i = begin; i < end; ++i) {
                // The elasticity of a solid resists pressure. It is unknown here, so that a is left out.
                Vec3 target = p_.velocity[i];
                if (!is_elastic(p_.phase[i])) target = target + dt_ * p_.acceleration[i];
                Mat3 diagonal = p_.mass[i] * Mat3::Identity();
                Vec3 right = p_.mass[i] * target;
                if (sweep_.walls[i].drag > 0 && s_.matter[i].x > 0)
                    add_walls(walls, i, smoothing.support, cursor, diagonal, right);
                s_.target[i] = quad(target);
                s_.velocity[i] = quad(target + dt_ * p_.viscous_acceleration[i]);
                s_.diagonal[i] = block(diagonal);
                s_.residual[i] = quad(right);
            }
        });
    }

    /// Sets sqrt(dt kappa_ij) n_ij of all pairs, and the inverse blocks of the diagonal.
    void set_pairs(const PairKernel& kernel) {
        s_.first.resize(n_ + 1);
        s_.first[0] = 0;
        for (std::size_t i = 0; i < n_; ++i)
            s_.first[i + 1] = s_.first[i] + (neighbours_[i].size() + kLanes - 1) / kLanes;
        if (s_.runs.size() < s_.first[n_]) s_.runs.resize(s_.first[n_] + s_.first[n_] / 8);
        const Real strength = kCentral * dt_ * kernel.scale / square(per_volume_);
        parallel_chunks(n_, [&](std::size_t begin, std::size_t end, std::size_t) {
            for (std::size_t i = begin; i < end; ++i) set_pairs_of(i, strength, kernel.h2_inv);
        });
    }

    ViscosityReport solve() {
        const Sums start = first_residual();
        const double enough = square(params_.tolerance) * start.target;
        ViscosityReport report;
        double rr = start.rr, rz = start.rz;
        while (rr > enough && report.iterations < params_.most_iterations) {
            const double curvature = sweep_direction();
            if (!(curvature > 0)) break;
            const Sums next = descend(rz / curvature);
            turn(next.rz / rz);
            rr = next.rr;
            rz = next.rz;
            ++report.iterations;
        }
        report.residual = start.target > 0 ? std::sqrt(rr / start.target) : 0;
        report.converged = rr <= enough;
        return report;
    }

    void apply() {
        parallel_for(
            n_,
            [&](std::size_t i) {
                const Vec3 v = xyz(s_.velocity[i]) + xyz(s_.residual[i]) / p_.mass[i];
                p_.viscous_acceleration[i] = (v - xyz(s_.target[i])) / dt_;
                p_.acceleration[i] += p_.viscous_acceleration[i];
            },
            2048);
    }

  private:
    struct Sums {
        double rr = 0, rz = 0, target = 0;  // |r|^2/m, r.z [kg m^2/s^2]
        Sums operator+(const Sums& b) const { return {rr + b.rr, rz + b.rz, target + b.target}; }
    };

    void add_walls(const Walls& walls, std::size_t i, Real support, WallCursor& cursor, Mat3& diagonal,
                   Vec3& right) const {
        const Real strength = kCentral * dt_ * s_.matter[i].w * s_.matter[i].x * (s_.matter[i].y / per_volume_);
        const WallDrag drag = wall_drag(walls, p_.position[i], support, cursor);
        diagonal += strength * drag.friction;
        right += strength * drag.moving;
    }

    /// M_i = sum_j V_j k r^2/6: 1 over the packing.
    Real moment(std::size_t i, const PairKernel& kernel) const {
        const Quad at = sweep_.place[i];
        Lanes sum{};
        for_each_run(neighbours_[i], sweep_.nobody(), [&](const Index* j) {
            Lanes x, y, z, unused, vx, vy, vz, volume;
            gather(sweep_.place.data(), j, x, y, z, unused);
            gather(sweep_.motion.data(), j, vx, vy, vz, volume);
            x = at.x - x;
            y = at.y - y;
            z = at.z - z;
            const Lanes q = positive(1 - (x * x + y * y + z * z) * kernel.h2_inv);
            sum += volume * (q * q) * (1 - q);
        });
        return kernel.scale / (6 * kernel.h2_inv) * sum_of(sum);
    }

    void set_pairs_of(std::size_t i, Real strength, Real h2_inv) {
        const Quad at = sweep_.place[i], own = s_.matter[i];
        Run* run = s_.runs.data() + s_.first[i];
        Lanes xx{}, yy{}, zz{}, xy{}, xz{}, yz{};
        for_each_run(neighbours_[i], sweep_.nobody(), [&](const Index* j) {
            Lanes x, y, z, unused, mu, volume, even, melt;
            gather(sweep_.place.data(), j, x, y, z, unused);
            gather(s_.matter.data(), j, mu, volume, even, melt);
            x = at.x - x;
            y = at.y - y;
            z = at.z - z;
            const Lanes r2 = x * x + y * y + z * z, near = positive(1 - r2 * h2_inv);
            Lanes pair_mu = own.x + mu > 0 ? 2 * (own.x * mu) / (own.x + mu) : Lanes{};
            if (sweep_.mixed) {  // the harmonic mean weighed by melt fractions, times the larger of them
                const Lanes sum = own.w * mu + melt * own.x;
                pair_mu = sum > 0 ? larger(melt, own.w) * ((own.w + melt) * (own.x * mu) / sum) : Lanes{};
            }
            // Both of a pair must get the same value to the last bit: first the products symmetric in i and j.
            const Lanes pair = ((own.y * volume) * pair_mu) * (Real(0.5) * (own.z + even));
            const Lanes kappa = strength * pair * (near * near);
            // Two particles in the same place have no direction to act along.
            const Lanes scale = r2 > 0 ? root(kappa / r2) : Lanes{};
            x *= scale;
            y *= scale;
            z *= scale;
            *run++ = {x, y, z};
            xx += x * x;
            yy += y * y;
            zz += z * z;
            xy += x * y;
            xz += x * z;
            yz += y * z;
        });
        const Block d = s_.diagonal[i];
        Mat3 m;
        m << d.xx + sum_of(xx), d.xy + sum_of(xy), d.xz + sum_of(xz), 0, d.yy + sum_of(yy), d.yz + sum_of(yz), 0, 0,
            d.zz + sum_of(zz);
        const Mat3d full = m.selfadjointView<Eigen::Upper>().toDenseMatrix().cast<double>();
        s_.inverse[i] = block(full.inverse().cast<Real>());
    }

    /// A q at particle i, with q packed with ghosts:
    ///     D q_i + sum_j e (e.(q_i - q_j))
    Vec3 apply_matrix(std::size_t i, const std::vector<Quad>& packed) const {
        const Quad q = packed[i];
        Lanes fx{}, fy{}, fz{};
        for_each_pair_run(s_, i, neighbours_[i], sweep_.nobody(), [&](const Run& e, const Index* j) {
            Lanes x, y, z, unused;
            gather(packed.data(), j, x, y, z, unused);
            const Lanes along = e.x * (q.x - x) + e.y * (q.y - y) + e.z * (q.z - z);
            fx += e.x * along;
            fy += e.y * along;
            fz += e.z * along;
        });
        return product(s_.diagonal[i], xyz(q)) + Vec3(sum_of(fx), sum_of(fy), sum_of(fz));
    }

    /// Computes r = b - A x, and the first direction z = P r. `direction` holds x packed for its neighbours.
    Sums first_residual() {
        parallel_for(
            n_, [&](std::size_t i) { s_.direction[i] = s_.velocity[i]; }, 4096);
        refresh_ghosts(sweep_.ghosts, s_.direction);
        const Sums sums = parallel_sum<Sums>(
            n_,
            [&](std::size_t i) {
                const Quad b = s_.residual[i];
                const Quad r = quad(xyz(b) - apply_matrix(i, s_.direction));
                const Quad z = quad(product(s_.inverse[i], xyz(r)));
                s_.residual[i] = r;
                s_.product[i] = z;
                const double mass = p_.mass[i];
                return Sums{dot(r, r) / mass, dot(r, z), dot(b, b) / mass};
            },
            Sums{});
        turn(0);
        return sums;
    }

    /// Computes product = A direction. Returns direction . product.
    double sweep_direction() {
        return parallel_sum(n_, [&](std::size_t i) {
            s_.product[i] = quad(apply_matrix(i, s_.direction));
            return dot(s_.direction[i], s_.product[i]);
        });
    }

    /// x += a p, r -= a A p; then product becomes z = P r.
    Sums descend(double step) {
        const Real a = static_cast<Real>(step);
        return parallel_sum<Sums>(
            n_,
            [&](std::size_t i) {
                Quad &x = s_.velocity[i], &r = s_.residual[i], &q = s_.product[i];
                const Quad& p = s_.direction[i];
                x = quad(xyz(x) + a * xyz(p));
                r = quad(xyz(r) - a * xyz(q));
                q = quad(product(s_.inverse[i], xyz(r)));
                return Sums{dot(r, r) / static_cast<double>(p_.mass[i]), dot(r, q), 0};
            },
            Sums{});
    }

    /// p = z + b p.
    void turn(double b) {
        const Real share = static_cast<Real>(b);
        parallel_for(
            n_, [&](std::size_t i) { s_.direction[i] = quad(xyz(s_.product[i]) + share * xyz(s_.direction[i])); },
            4096);
        refresh_ghosts(sweep_.ghosts, s_.direction);
    }

    Particles& p_;
    const NeighbourLists& neighbours_;
    const Sweep& sweep_;
    const ViscositySolve& params_;
    ViscosityScratch& s_;
    std::size_t n_;
    Real dt_;
    // Volumes are in units of a power of two near h^3. Otherwise the product of two would leave the range of a float
    // where the spacing is a micrometre or a thousand kilometres. A power of two changes no other bit.
    Real per_volume_;
};

}  // namespace

ViscosityReport solve_viscosity(Particles& particles, const SweepInput& input, const Materials& materials,
                                const ViscositySolve& params, ViscosityScratch& scratch) {
    Solver solver(particles, input.neighbours, input.sweep, params, input.smoothing.support, scratch);
    const PairKernel kernel(input.smoothing);
    solver.set_matter(materials, kernel);
    solver.set_target(input.walls, input.smoothing);
    solver.set_pairs(kernel);
    const ViscosityReport report = solver.solve();
    solver.apply();
    return report;
}

}  // namespace thixo
