#include "sim/liquid/pressure_solver.h"

#include <algorithm>
#include <limits>

#include "pipeline/base/parallel.h"

namespace thixo {
namespace {

// A shift is right to first order only. An error above this part of the density is restored over several steps. No
// shift is longer than this part of a spacing: by its second order a longer one makes more error than it removes.
constexpr Real kMostRestored = Real(0.02), kLongestShift = Real(0.02);
// A particle this near to its rest density is full. Without the band, a particle that a shift leaves slightly too light
// falls until it is stopped, and has to be shifted again.
constexpr Real kFull = Real(0.002);
constexpr Real kProjectedStep = Real(0.5);  // length of a projected gradient step, in diagonals

/// The bound-constrained quadratic problem
///     min 1/2 p'Ap - b'p,   p >= 0
/// in the norm of the diagonal. Conjugate gradients act on the particles under pressure, and further steps change this
/// set where it is not right (MPRGP: Dostal & Schoeberl 2005). The gradient is minus the residual r = s* - 1, weighed
/// by V0.
class BoundedConjugateGradients {
  public:
    BoundedConjugateGradients(const NeighbourLists& neighbours, const std::vector<WallEffect>& walls,
                              const Smoothing& smoothing, double tau, PressureSystem& system, SolveScratch& scratch,
                              std::vector<Real>& pressure)
        : neighbours_(neighbours),
          walls_(walls),
          smoothing_(smoothing),
          tau_(static_cast<Real>(tau)),
          system_(system),
          s_(scratch),
          p_(pressure) {}

    SolveReport solve(const SolveLimits& limits) {
        SolveReport report;
        Norms norms = measure();
        bool restart = true;  // the direction must be computed anew
        while (true) {
            report.residual = norms.error / std::max<double>(1, static_cast<double>(p_.size()));
            report.converged = report.residual <= limits.tolerance;
            if (report.converged || report.iterations >= limits.iterations) return report;
            const bool grow = norms.blocked > norms.reduced;
            if (grow || restart) start(grow);
            const Products products = apply();
            ++report.iterations;
            if (products.curvature <= 0) return report;  // no particle can be pushed
            const double step = products.descent / products.curvature;
            restart = true;
            if (grow || step <= products.room) {
                norms = move(static_cast<Real>(step));
                if (!grow) {
                    // sum over the free particles of k r_new B d, from values that are known before and after
                    conjugate(static_cast<Real>((products.mixed - step * products.squared) / products.curvature));
                    restart = false;
                }
            } else {
                project(static_cast<Real>(step));
                apply();
                ++report.iterations;
                norms = move(1);
            }
        }
    }

  private:
    struct Norms {
        double reduced = 0, blocked = 0, error = 0;
        Norms operator+(const Norms& b) const { return {reduced + b.reduced, blocked + b.blocked, error + b.error}; }
    };
    struct Products {
        double descent = 0, curvature = 0, mixed = 0, squared = 0;
        double room = std::numeric_limits<double>::infinity();  // the longest step that keeps p >= 0
        Products operator+(const Products& b) const {
            return {descent + b.descent, curvature + b.curvature, mixed + b.mixed, squared + b.squared,
                    std::min(room, b.room)};
        }
    };

    Real gain(std::size_t i) const { return system_.inverse_diagonal[i] / tau_; }
    bool free(std::size_t i) const { return p_[i] > 0; }

    Norms norms_of(std::size_t i) const {
        const double r = s_.residual[i], weight = static_cast<double>(system_.motion[i].w * gain(i));
        if (weight <= 0) return {};
        if (!free(i)) return r > 0 ? Norms{0, weight * r * r, r} : Norms{};
        const double most = static_cast<double>(p_[i] / (kProjectedStep * gain(i)));
        return {weight * r * std::max(r, -most), 0, std::abs(r)};
    }
    Norms measure() const {
        return parallel_sum<Norms>(
            p_.size(), [&](std::size_t i) { return norms_of(i); }, Norms{});
    }

    /// The steepest direction of the free particles, or (`grow`) of those that a bound holds back.
    void start(bool grow) {
        parallel_for(
            p_.size(),
            [&](std::size_t i) {
                const Real r = s_.residual[i];
                s_.direction[i] = (grow ? !free(i) && r > 0 : free(i)) ? gain(i) * r : Real(0);
            },
            4096);
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
                const double weight = free(i) ? volume * static_cast<double>(gain(i)) : 0.0;
                Products out{volume * r * d, volume * b * d, weight * r * b, weight * b * b,
                             std::numeric_limits<double>::infinity()};
                if (d < 0) out.room = -static_cast<double>(p_[i]) / d;
                return out;
            },
            Products{});
    }

    Norms move(Real step) {
        return parallel_sum<Norms>(
            p_.size(),
            [&](std::size_t i) {
                const Quad& a = system_.motion[i];
                p_[i] = std::max(p_[i] + step * s_.direction[i], Real(0));
                s_.residual[i] -= step * s_.response[i];
                s_.push[i] += step * Vec3(a.x, a.y, a.z);
                return norms_of(i);
            },
            Norms{});
    }

    void conjugate(Real beta) {
        parallel_for(
            p_.size(),
            [&](std::size_t i) {
                s_.direction[i] = free(i) ? gain(i) * s_.residual[i] - beta * s_.direction[i] : Real(0);
            },
            4096);
    }

    /// Projects the direction: it becomes the part of the step that keeps p >= 0.
    void project(Real step) {
        parallel_for(
            p_.size(),
            [&](std::size_t i) { s_.direction[i] = std::max(p_[i] + step * s_.direction[i], Real(0)) - p_[i]; }, 4096);
    }

    const NeighbourLists& neighbours_;
    const std::vector<WallEffect>& walls_;
    const Smoothing& smoothing_;
    Real tau_;
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
