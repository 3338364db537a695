#include "sim/liquid/pressure_solver.h"

#include <algorithm>
#include <limits>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/power_of_two.h"

namespace thixo {
namespace {

// A shift is right to first order only. An error above this part of the density is restored over several steps. No
// shift is longer than this part of a spacing: by its second order a longer one makes more error than it removes.
constexpr Real kMostRestored = Real(0.02), kLongestShift = Real(0.02);
// A particle this near to its rest density is full. Without the band, a particle that a shift leaves slightly too light
// falls until it is stopped, and has to be shifted again.
constexpr Real kFull = Real(0.002);

/// The bound-constrained quadratic problem
///     min 1/2 p'Ap - b'p,   p >= 0
/// in the norm of the diagonal, by conjugate gradients on the particles that are under pressure or need it. The gradient
/// is minus the residual r = s* - 1, weighed by V0.
///
/// In a splash some particles are about to lose their pressure in every step. To end a step at the first of them, or to
/// project it and start anew, leaves no more than steepest descent. So directions are cut back beforehand: a step as
/// long as the last one, alpha, keeps p >= 0.
///     d_i <- max(d_i, - p_i/alpha)
/// The step is the best one along this direction, as far as p >= 0. The next direction is conjugate to this one.
class BoundedConjugateGradients {
  public:
    BoundedConjugateGradients(const NeighbourLists& neighbours, const std::vector<WallEffect>& walls,
                              const Smoothing& smoothing, double tau, PressureSystem& system, SolveScratch& scratch,
                              std::vector<Real>& pressure)
        : neighbours_(neighbours),
          walls_(walls),
          smoothing_(smoothing),
          tau_(static_cast<Real>(tau)),
          per_volume_(1 / cube(power_of_two_below(smoothing.spacing))),
          system_(system),
          s_(scratch),
          p_(pressure) {}

    SolveReport solve(const SolveLimits& limits) {
        // Steps are near one in units of the diagonal. One that is far from it says little of the next.
        constexpr double kShortest = 0.25, kLongest = 4;
        SolveReport report;
        Change change = measure();
        bool restart = true;
        double length = 1;
        while (true) {
            report.residual = change.error / std::max<double>(1, static_cast<double>(p_.size()));
            report.converged = report.residual <= limits.tolerance;
            if (report.converged || report.iterations >= limits.iterations) return report;
            if (restart) start();
            cut_back(static_cast<Real>(length));
            const Products products = apply();
            ++report.iterations;
            if (products.curvature <= 0) return report;  // no particle can be pushed
            if (products.descent <= 0) {                 // cut back, it leads nowhere; the steepest one does
                if (restart) return report;
                restart = true;
                continue;
            }
            const double best = products.descent / products.curvature;
            change = move(static_cast<Real>(std::min(best, products.room)));
            conjugate(static_cast<Real>(change.along / products.curvature));
            restart = false;
            length = std::clamp(best, kShortest, kLongest);
        }
    }

  private:
    /// What a step has led to: the sum of errors, and that of k r B d over the open particles.
    struct Change {
        double error = 0, along = 0;
        Change operator+(const Change& b) const { return {error + b.error, along + b.along}; }
    };
    struct Products {
        double descent = 0, curvature = 0;
        double room = std::numeric_limits<double>::infinity();  // the longest step that keeps p >= 0
        Products operator+(const Products& b) const {
            return {descent + b.descent, curvature + b.curvature, std::min(room, b.room)};
        }
    };

    Real gain(std::size_t i) const { return system_.inverse_diagonal[i] / tau_; }
    /// Whether the pressure of a particle is to change: it has some, or too little.
    bool open(std::size_t i) const { return p_[i] > 0 || s_.residual[i] > 0; }
    Real steepest(std::size_t i) const { return open(i) ? gain(i) * s_.residual[i] : Real(0); }

    double error(std::size_t i) const {
        return system_.inverse_diagonal[i] > 0 && open(i) ? std::abs(static_cast<double>(s_.residual[i])) : 0.0;
    }
    Change measure() const {
        return parallel_sum<Change>(
            p_.size(),
            [&](std::size_t i) {
                return Change{error(i), 0};
            },
            Change{});
    }

    void start() {
        parallel_for(
            p_.size(), [&](std::size_t i) { s_.direction[i] = steepest(i); }, 4096);
    }

    void cut_back(Real length) {
        parallel_for(
            p_.size(), [&](std::size_t i) { s_.direction[i] = std::max(s_.direction[i], -p_[i] / length); }, 4096);
    }

    Products apply() {
        parallel_for(
            p_.size(), [&](std::size_t i) { system_.place[i].w = system_.motion[i].w * s_.direction[i]; }, 4096);
        find_pressure_acceleration(s_.direction, neighbours_, smoothing_, system_);
        return parallel_sum<Products>(
            p_.size(),
            [&](std::size_t i) {
                const Real response = -tau_ * density_rate(i, neighbours_, walls_, smoothing_, system_, false);
                s_.response[i] = response;
                const double volume = system_.motion[i].w, b = response, d = s_.direction[i], r = s_.residual[i];
                Products out{volume * r * d, volume * b * d};
                if (d < 0) out.room = -static_cast<double>(p_[i]) / d;
                return out;
            },
            Products{});
    }

    Change move(Real step) {
        return parallel_sum<Change>(
            p_.size(),
            [&](std::size_t i) {
                const Quad& a = system_.motion[i];
                p_[i] = std::max(p_[i] + step * s_.direction[i], Real(0));
                s_.residual[i] -= step * s_.response[i];
                s_.push[i] += step * Vec3(a.x, a.y, a.z);
                // In units of about the spacing: a volume times a pressure leaves the range of a float at micrometres.
                const Real work = (per_volume_ * a.w) * steepest(i);
                return Change{error(i), static_cast<double>(work) * static_cast<double>(s_.response[i]) / per_volume_};
            },
            Change{});
    }

    void conjugate(Real beta) {
        parallel_for(
            p_.size(),
            [&](std::size_t i) {
                s_.direction[i] = open(i) ? gain(i) * s_.residual[i] - beta * s_.direction[i] : Real(0);
            },
            4096);
    }

    const NeighbourLists& neighbours_;
    const std::vector<WallEffect>& walls_;
    const Smoothing& smoothing_;
    Real tau_, per_volume_;  // [s^2], [1/m^3]
    PressureSystem& system_;
    SolveScratch& s_;
    std::vector<Real>& p_;
};

void resize_scratch(std::size_t n, SolveScratch& s) {
    for (auto* reals : {&s.residual, &s.direction, &s.response}) reals->resize(n);
    for (auto* vectors : {&s.push, &s.shift}) vectors->resize(n, Vec3::Zero());
}

/// Makes the guessed pressure feasible. Its acceleration goes into system.motion.
void start_from(std::vector<Real>& pressure, const NeighbourLists& neighbours, const Smoothing& smoothing,
                PressureSystem& system) {
    parallel_for(
        pressure.size(),
        [&](std::size_t i) {
            if (system.inverse_diagonal[i] == 0) pressure[i] = 0;
            system.place[i].w = system.motion[i].w * pressure[i];
        },
        4096);
    find_pressure_acceleration(pressure, neighbours, smoothing, system);
}

}  // namespace

SolveReport remove_divergence(Particles& particles, const NeighbourLists& neighbours,
                              const std::vector<WallEffect>& walls, const Smoothing& smoothing,
                              const DivergenceSolve& params, PressureSystem& system, SolveScratch& scratch) {
    const Real half = static_cast<Real>(params.kick), step = static_cast<Real>(params.dt);
    auto& pressure = particles.pressure;
    resize_scratch(particles.size(), scratch);
    start_from(pressure, neighbours, smoothing, system);
    parallel_for(
        particles.size(),
        [&](std::size_t i) {
            Quad& m = system.motion[i];
            scratch.push[i] = Vec3(m.x, m.y, m.z);
            const Vec3 u = particles.velocity[i] + half * (particles.acceleration[i] + scratch.push[i]);
            m = {u.x(), u.y(), u.z(), m.w};
        },
        4096);
    refresh_motion(system);
    parallel_for(particles.size(), [&](std::size_t i) {
        scratch.residual[i] = step * density_rate(i, neighbours, walls, smoothing, system, true) +
                              std::min(system.excess[i] + kFull, Real(0));
    });
    const SolveReport report =
        BoundedConjugateGradients(neighbours, walls, smoothing, params.kick * params.dt, system, scratch, pressure)
            .solve(params.limits);
    parallel_for(
        particles.size(), [&](std::size_t i) { particles.acceleration[i] += scratch.push[i]; }, 4096);
    return report;
}

SolveReport restore_density(Particles& particles, const NeighbourLists& neighbours,
                            const std::vector<WallEffect>& walls, const Smoothing& smoothing, const SolveLimits& limits,
                            PressureSystem& system, SolveScratch& scratch) {
    auto& pressure = particles.restoring;
    const double off = parallel_sum(pressure.size(), [&](std::size_t i) {
        const Real r = scratch.residual[i] += std::clamp(system.excess[i], -kFull, kMostRestored);
        scratch.push[i].setZero();
        return system.inverse_diagonal[i] > 0 ? std::max<double>(r, 0) : 0.0;
    });
    if (off <= limits.tolerance * static_cast<double>(pressure.size())) {
        std::ranges::fill(pressure, Real(0));
    } else {
        start_from(pressure, neighbours, smoothing, system);
        parallel_for(pressure.size(), [&](std::size_t i) {
            const Quad& a = system.motion[i];
            scratch.push[i] = Vec3(a.x, a.y, a.z);
            scratch.residual[i] += density_rate(i, neighbours, walls, smoothing, system, false);
        });
    }
    const SolveReport report =
        BoundedConjugateGradients(neighbours, walls, smoothing, 1, system, scratch, pressure).solve(limits);
    scratch.shift.swap(scratch.push);
    const Real most = kLongestShift * smoothing.spacing;
    parallel_for(
        scratch.shift.size(),
        [&](std::size_t i) {
            const Real length = scratch.shift[i].norm();
            if (length > most) scratch.shift[i] *= most / length;
        },
        4096);
    return report;
}

}  // namespace thixo
