#include "sim/solid/implicit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/base/parallel.h"
#include "sim/contact/answer.h"
#include "sim/solid/rigid_rates.h"

namespace thixo {
namespace {

constexpr int kFree = 4;  // iterations in which friction follows the motion; afterwards each drag stays as it is
constexpr int kMostNewton = 16, kMostIterations = 2000, kMostSearch = 4;
constexpr double kForcing = 0.1;    // part of its right hand side that a linear system may leave as residual
constexpr double kOvershoot = 0.5;  // part of the slope along a direction that the search may leave
constexpr Real kRounding = 4 * std::numeric_limits<Real>::epsilon();

double dot(const Vec3& a, const Vec3& b) { return a.cast<double>().dot(b.cast<double>()); }

/// An element's place and momentum. `momentum` is that at its place.
std::pair<Vec3d, Vec3d> motion_of(const Elements& e, std::size_t i, const Vec3d& momentum) {
    return {xyz(e.rest[i]).cast<double>() + xyz(e.displacement[i]).cast<double>(), momentum};
}

/// Moves every body's frame on by its rigid motion over dt. The step is then solved in the new frame: steps backwards
/// in time neither damp nor strain rigid motion. In the new frame the fields are
///     start                where the elements are
///     displacement         where they come to without forces
///     base and rigid       as evaluate() reads them
///     velocity             v' without forces
///     acceleration         of places that turn with the body
void go_ahead(double dt, Solids& solids, ImplicitScratch& scratch) {
    Elements& e = solids.elements;
    for (auto* v : {&scratch.start, &scratch.base, &scratch.rigid}) v->resize(e.size());
    scratch.turning.assign(e.size(), Vec3::Zero());
    scratch.angular.assign(solids.bodies.size(), Vec3d::Zero());
    for (SolidBody& body : solids.bodies) {
        if (body.empty()) continue;
        const RigidRates r = rigid_rates(body, e, [&](std::size_t k) {
            const std::size_t i = body.elements[k];
            return motion_of(e, i, static_cast<double>(e.mass[i]) * xyz(e.velocity[i]).cast<double>());
        });
        const Turning on = turn_on(r, dt);
        const Mat3d back = on.turn.transpose(), change = back - Mat3d::Identity();
        scratch.angular[static_cast<std::size_t>(&body - solids.bodies.data())] = back * r.angular;
        parallel_for(body.size(), [&](std::size_t k) {
            const std::size_t i = body.elements[k];
            const Vec3d y = xyz(e.rest[i]).cast<double>() + xyz(e.displacement[i]).cast<double>() - r.centre;
            const Vec3d u = xyz(e.displacement[i]).cast<double>(), v = xyz(e.velocity[i]).cast<double>();
            const Vec3d trembles = v - r.velocity - r.spin.cross(y);
            const Vec3d rigid = back * r.velocity + on.spin.cross(y);
            scratch.start[i] = quad((u + change * y - dt * (back * r.velocity)).cast<Real>());
            scratch.base[i] = e.displacement[i];
            scratch.rigid[i] = quad(rigid.cast<Real>());
            e.displacement[i] = quad((u + dt * trembles).cast<Real>());
            e.velocity[i] = quad((trembles + rigid).cast<Real>());
            e.acceleration[i] = Vec3::Zero();
            const Vec3d turning = on.spin.cross(on.spin.cross(y)) + on.change.cross(y);
            scratch.turning[i] = turning.cast<Real>();
            solids.external[i] = (back * solids.external[i].cast<double>() - turning).cast<Real>();
        });
        body.place += body.turn * (r.centre + dt * r.velocity - on.turn * r.centre);
        body.turn = Quatd(Mat3d(body.turn * on.turn)).normalized().toRotationMatrix();
    }
}

/// Newton's method for one step.
class Step {
  public:
    Step(double dt, double tolerance, const Walls& walls, const std::vector<Quad>& before, Solids& solids,
         ImplicitScratch& scratch)
        : dt_(dt),
          tolerance_(tolerance),
          walls_(walls),
          before_(before),
          solids_(solids),
          e_(solids.elements),
          s_(scratch) {
        const std::size_t n = e_.size();
        for (auto* v : {&scratch.change, &scratch.direction}) v->resize(n);
        for (auto* v : {&scratch.residual, &scratch.product, &scratch.preconditioned}) v->resize(n);
        scratch.inverse.resize(n);
    }

    ImplicitReport solve() {
        ImplicitReport report;
        s_.boundaries.frozen = false;
        find_diagonal_of_elasticity();
        if (s_.two_levels) s_.coarse.prepare(solids_.laws, solids_.bodies, e_, solids_.held);
        Norms norms = evaluate();
        while (norms.residual > square(tolerance_) * norms.forces + norms.rounding) {
            if (report.newton == kMostNewton || !std::isfinite(norms.residual)) {
                report.converged = false;
                break;
            }
            s_.boundaries.frozen = ++report.newton > kFree;
            linearise(solids_.laws, e_, dt_, Tangent::definite, s_.stiffness);
            precondition();
            report.iterations += descend(0.3 * tolerance_ * std::sqrt(norms.forces / norms.residual));
            norms = search();
        }
        return report;
    }

  private:
    struct Norms {  // squares, over masses
        double residual = 0, forces = 0, rounding = 0;
        Norms operator+(const Norms& b) const {
            return {residual + b.residual, forces + b.forces, rounding + b.rounding};
        }
    };
    struct Slopes {
        double residual = 0, work = 0, norm = 0;
        Slopes operator+(const Slopes& b) const { return {residual + b.residual, work + b.work, norm + b.norm}; }
    };

    /// Evaluates the residual at the present displacements:
    ///     residual = f - M (v' - v)/dt      [N]
    /// Rounding of displacements and velocities bounds how small it can become. Without forces, that bound is all.
    Norms evaluate() {
        const Real per = static_cast<Real>(1 / dt_);
        parallel_for(
            e_.size(),
            [&](std::size_t i) {
                e_.velocity[i] = quad(per * (xyz(e_.displacement[i]) - xyz(s_.base[i])) + xyz(s_.rigid[i]));
            },
            2048);
        const StretchBounds bounds = find_stress_forces(solids_.laws, e_, s_.stress, solids_.force);
        solids_.stretch2 = static_cast<double>(bounds.stretch2);
        solids_.stiffening = static_cast<double>(bounds.stiffening);
        add_boundary_forces(walls_, dt_, solids_, s_.boundaries, solids_.force);
        return parallel_sum<Norms>(
            e_.size(),
            [&](std::size_t i) {
                if (solids_.held[i]) {
                    s_.residual[i].setZero();
                    return Norms{};
                }
                const Real m = e_.mass[i];
                const Vec3 gain = (m * per) * (xyz(e_.velocity[i]) - xyz(before_[i])), given = m * solids_.external[i];
                const Vec3 r = solids_.force[i] + given - gain;
                s_.residual[i] = r;
                const double mass = static_cast<double>(m);
                const Symmetric& k = s_.elastic[i];
                const double rounded = static_cast<double>(
                    kRounding * ((m * per * per + std::max({k.xx, k.yy, k.zz})) * xyz(e_.displacement[i]).norm() +
                                 m * per * xyz(e_.velocity[i]).norm()));
                return Norms{dot(r, r) / mass,
                             (dot(gain, gain) + dot(given, given) + dot(solids_.force[i], solids_.force[i])) / mass,
                             square(rounded) / mass};
            },
            Norms{});
    }

    void find_diagonal_of_elasticity() {
        if (s_.version == e_.bonds.weights_version) return;
        find_diagonal(solids_.laws, e_, s_.elastic, s_.viscous);
        s_.version = e_.bonds.weights_version;
    }

    void precondition() {
        const Real per = static_cast<Real>(1 / dt_);
        s_.diagonal.resize(e_.size());
        parallel_for(
            e_.size(),
            [&](std::size_t i) {
                const Symmetric &a = s_.elastic[i], &b = s_.viscous[i];
                const Real inertia = e_.mass[i] * per * per;
                s_.diagonal[i] = {a.xx + per * b.xx + inertia, a.yy + per * b.yy + inertia, a.zz + per * b.zz + inertia,
                                  a.xy + per * b.xy,           a.yz + per * b.yz,           a.zx + per * b.zx};
            },
            1024);
        const bool bounded = s_.boundaries.walls || solids_.contacts.nodes.size() > 0;
        s_.bounds.assign(bounded ? e_.size() : 0, {});
        if (bounded) add_boundary_diagonal(solids_, s_.boundaries, s_.bounds);
        if (s_.two_levels) s_.coarse.factor(dt_, s_.bounds);
        parallel_for(
            e_.size(),
            [&](std::size_t i) {
                if (bounded) s_.diagonal[i] = symmetric(Mat3(matrix(s_.diagonal[i]) + matrix(s_.bounds[i])));
                s_.inverse[i] = symmetric(Mat3(matrix(s_.diagonal[i]).cast<double>().inverse().cast<Real>()));
            },
            512);
    }

    /// Computes product = (M/dt^2 + K) direction, and returns direction . product.
    double sweep() {
        multiply(e_, s_.stiffness, s_.direction, s_.product);
        multiply_boundaries(walls_, solids_, s_.direction, s_.boundaries, s_.product);
        const Real per = static_cast<Real>(1 / dt_);
        return parallel_sum(e_.size(), [&](std::size_t i) {
            const Vec3 d = xyz(s_.direction[i]);
            s_.product[i] = solids_.held[i] ? Vec3(0, 0, 0) : Vec3((e_.mass[i] * per * per) * d - s_.product[i]);
            return dot(d, s_.product[i]);
        });
    }

    /// Solves the linear system for `change`, to kForcing of the residual or to `enough` of it, whichever is more.
    int descend(double enough) {
        std::vector<Vec3>& left = s_.preconditioned;  // P r
        std::vector<Vec3> r = s_.residual;
        const auto apply = [&] {
            parallel_for(
                e_.size(), [&](std::size_t i) { left[i] = matrix(s_.inverse[i]) * r[i]; }, 1024);
            if (s_.two_levels) s_.coarse.add_correction(r, left);
            return parallel_sum<Slopes>(
                e_.size(),
                [&](std::size_t i) {
                    return Slopes{dot(r[i], left[i]), 0, dot(r[i], r[i]) / static_cast<double>(e_.mass[i])};
                },
                Slopes{});
        };
        Slopes now = apply();
        const double first = now.norm;
        parallel_for(
            e_.size(),
            [&](std::size_t i) {
                s_.change[i] = quad(Vec3::Zero());
                s_.direction[i] = quad(left[i]);
            },
            2048);
        int k = 0;
        const double goal = square(std::max(std::min(enough, 0.5), kForcing)) * first;
        while (k < kMostIterations && now.norm > goal) {
            ++k;
            const double curvature = sweep();
            if (!(curvature > 0)) break;
            const Real a = static_cast<Real>(now.residual / curvature);
            parallel_for(
                e_.size(),
                [&](std::size_t i) {
                    s_.change[i] = quad(xyz(s_.change[i]) + a * xyz(s_.direction[i]));
                    r[i] -= a * s_.product[i];
                },
                2048);
            const Slopes next = apply();
            const Real b = static_cast<Real>(next.residual / now.residual);
            parallel_for(
                e_.size(), [&](std::size_t i) { s_.direction[i] = quad(left[i] + b * xyz(s_.direction[i])); }, 2048);
            now = next;
        }
        return k;
    }

    /// Goes along `change`, as far as the forces point along it.
    Norms search() {
        const auto slope = [&] {
            return parallel_sum(e_.size(), [&](std::size_t i) { return dot(xyz(s_.change[i]), s_.residual[i]); });
        };
        const auto go = [&](double part) {
            const Real a = static_cast<Real>(part);
            parallel_for(
                e_.size(),
                [&](std::size_t i) { e_.displacement[i] = quad(xyz(e_.displacement[i]) + a * xyz(s_.change[i])); },
                2048);
            return evaluate();
        };
        const double first = slope();
        double at = 1;
        Norms norms = go(1);
        for (int k = 0; k < kMostSearch; ++k) {
            const double left = slope();
            if (std::isfinite(left) && left > -kOvershoot * first) break;
            const double next = std::isfinite(left) ? std::max(at * first / (first - left), at / 10) : at / 10;
            norms = go(next - at);
            at = next;
        }
        return norms;
    }

    const double dt_, tolerance_;
    const Walls& walls_;
    const std::vector<Quad>& before_;
    Solids& solids_;
    Elements& e_;
    ImplicitScratch& s_;
};

/// Gives each body the momenta that the step left out, as a rigid motion: those of the residual, and a difference of
/// angular momenta. The velocities `before` at the present places, less the body's turning, have another angular
/// momentum than the body had. The difference is due to the change of inertia by the step's deformation.
void keep_momenta(double dt, const std::vector<Quad>& before, Solids& solids, ImplicitScratch& scratch) {
    Elements& e = solids.elements;
    for (std::size_t b = 0; b < solids.bodies.size(); ++b) {
        const SolidBody& body = solids.bodies[b];
        if (std::ranges::any_of(body.elements, [&](Index i) { return solids.held[i] != 0; })) continue;
        if (body.empty()) continue;
        RigidRates left = rigid_rates(body, e, [&](std::size_t k) {
            const std::size_t i = body.elements[k];
            return motion_of(e, i, dt * scratch.residual[i].cast<double>());
        });
        const RigidRates present = rigid_rates(body, e, [&](std::size_t k) {
            const std::size_t i = body.elements[k];
            return motion_of(e, i,
                             static_cast<double>(e.mass[i]) *
                                 (xyz(before[i]).cast<double>() - dt * scratch.turning[i].cast<double>()));
        });
        left.spin += left.spin_of(scratch.angular[b] - present.angular);
        parallel_for(body.size(), [&](std::size_t k) {
            const std::size_t i = body.elements[k];
            const Vec3d y = xyz(e.rest[i]).cast<double>() + xyz(e.displacement[i]).cast<double>() - left.centre;
            const Vec3d v = left.velocity + left.spin.cross(y);
            e.velocity[i] = quad((xyz(e.velocity[i]).cast<double>() + v).cast<Real>());
            e.displacement[i] = quad((xyz(e.displacement[i]).cast<double>() + dt * v).cast<Real>());
        });
    }
}

/// Moves every element that is in a wall out of it.
void stay_out_of_walls(const Walls& walls, Solids& solids) {
    Elements& e = solids.elements;
    const std::vector<BodyPose> poses = poses_of(solids.bodies);
    if (walls.list.empty()) return;
    parallel_chunks(
        e.size(),
        [&](std::size_t begin, std::size_t end, std::size_t) {
            WallCursor cursor(walls);
            for (std::size_t i = begin; i < end; ++i) {
                if (solids.held[i]) continue;
                const BodyPose& pose = poses[static_cast<std::size_t>(e.owner[i])];
                for (std::size_t w = 0; w < walls.list.size(); ++w) {
                    const Wall& wall = walls.list[w];
                    const Vec3 x = pose.turn * (xyz(e.rest[i]) + xyz(e.displacement[i])) + pose.place;
                    Vec3 n;
                    const Real d = wall.map.distance(wall.to_wall(x), n, cursor.at[w]);
                    if (!(d < 0)) continue;
                    n = pose.turn.transpose() * (wall.turn * n);
                    const Vec3 v = xyz(e.velocity[i]), moving = pose.turn.transpose() * wall.velocity_at(x);
                    e.displacement[i] = quad(xyz(e.displacement[i]) - d * n);
                    e.velocity[i] = quad(v + std::max(-n.dot(v - moving), Real(0)) * n);
                }
            }
        },
        256);
}

/// Nodes' displacements are counted from where the elements are, in the present frames.
void count_displacements_from(const std::vector<Quad>& start, const Walls& walls, Solids& solids) {
    ContactNodes& n = solids.contacts.nodes;
    const NodeFrames frames(solids, walls);
    parallel_for(
        n.size(), [&](std::size_t k) { n.start[k] = n.last[k] = displacement_of_node(n, start, frames, k); }, 64);
}

}  // namespace

ImplicitReport step_implicitly(double time, double dt, double tolerance, Walls& walls, const MoveHeld& move_held,
                               Solids& solids, ImplicitScratch& scratch) {
    Elements& e = solids.elements;
    move_walls(walls, time + dt);
    go_ahead(dt, solids, scratch);
    count_displacements_from(scratch.start, walls, solids);
    const std::vector<Quad> before = e.velocity;
    move_held(time + dt, dt);
    const ImplicitReport report = Step(dt, tolerance, walls, before, solids, scratch).solve();
    keep_momenta(dt, before, solids, scratch);
    store_boundary_state(walls, dt, solids);
    stay_out_of_walls(walls, solids);
    return report;
}

}  // namespace thixo
