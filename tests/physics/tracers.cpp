#include "tests/physics/tracers.h"

#include <algorithm>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/kernels.h"
#include "pipeline/geometry/point_grid.h"

namespace thixo::gate {
namespace {

constexpr Real kSameSide = Real(0.5);  // cosine between normals of one side
constexpr Real kFolded = 4;            // matter that was this much farther apart was brought together by a fold
constexpr std::size_t kFitted = 16, kAsked = 150;

}  // namespace

/// Finds the first place of matter from its current place.
struct Tracers::Matter {
    const std::vector<Vec3>&first, &place;
    Real reach;                  // a spacing [m]
    std::vector<Vec3> normal{};  // of patches
    PointGrid grid{};

    Matter(const std::vector<Vec3>& f, const std::vector<Vec3>& p, Real spacing) : first(f), place(p), reach(spacing) {
        for (std::size_t t = 0; t < place.size(); t += kPatch) {
            Vec3 n(0, 0, 0);
            for (std::size_t k = 0; k < 6; ++k)
                n += (place[t + 1 + k] - place[t]).cross(place[t + 1 + (k + 1) % 6] - place[t]);
            normal.push_back(n.norm() > 0 ? Vec3(n.normalized()) : n);
        }
        grid.build(place, reach / 2);
    }
    /// Whether places lie on all sides of x, in the plane of a and b.
    bool around(const Vec3& x, const Vec3& a, const Vec3& b, const std::vector<std::pair<Real, Index>>& chosen) const {
        std::vector<Real> angles;
        for (const auto& [r2, t] : chosen) angles.push_back(std::atan2(b.dot(place[t] - x), a.dot(place[t] - x)));
        std::ranges::sort(angles);
        Real gap = angles.front() + static_cast<Real>(2 * kPi) - angles.back();
        for (std::size_t k = 1; k < angles.size(); ++k) gap = std::max(gap, angles[k] - angles[k - 1]);
        return gap < static_cast<Real>(kPi);
    }
    /// False where no tracer is within half a spacing, or x is not surrounded by them. `without`: a patch to leave out.
    bool at(const Vec3& x, const Vec3& n, Index without, Vec3& was) const {
        Vec3 a, b;
        orthonormal_basis(n, a, b);
        std::vector<std::pair<Real, Index>> near, chosen;
        grid.nearest(x, kAsked, reach, near);
        // Nearest along the surface, which may lie above or below the tracers.
        for (auto& [r2, t] : near) r2 -= square(n.dot(place[t] - x));
        std::ranges::sort(near);
        for (const auto& [r2, t] : near) {
            if (t / kPatch == without || normal[t / kPatch].dot(n) < kSameSide) continue;
            if (!chosen.empty()) {
                const Index c = chosen.front().second;
                if ((first[t] - first[c]).norm() > kFolded * ((place[t] - place[c]).norm() + reach / 4)) continue;
            }
            chosen.emplace_back(r2, t);
            if (chosen.size() == kFitted) break;
        }
        if (chosen.size() < 6 || chosen.front().first > square(reach / 2) || !around(x, a, b, chosen)) return false;
        const Real support = Real(1.05) * std::sqrt(chosen.back().first);
        const Poly6 w(support);
        Mat3 spread = Real(1e-4) * Mat3::Identity(), covariance = Mat3::Zero();
        spread(0, 0) = 0;
        for (const auto& [r2, t] : chosen) {
            const Vec3 off = (place[t] - x) / support, base(1, a.dot(off), b.dot(off));
            const Real weight = w.value(r2) / w.value(0);
            spread += weight * base * base.transpose();
            covariance += weight * (first[t] - first[chosen[0].second]) * base.transpose();
        }
        was = first[chosen[0].second] + (covariance * spread.inverse()).col(0);
        return true;
    }
};

Tracers::Tracers(const Simulation& s) {
    const SurfelCloud& cloud = s.surface.surfels;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
        if (s.embedded.beyond[s.embedded_source[i]]) continue;
        const Vec3 a =
            cloud.axis1[i].cross(cloud.axis2[i]).dot(cloud.normal[i]) < 0 ? Vec3(-cloud.axis1[i]) : cloud.axis1[i];
        for (Index k = 0; k < kPatch; ++k) {
            const Real r = k == 0 ? Real(0) : Real(0.5), angle = static_cast<Real>(2 * kPi * k / 6);
            first_.push_back(cloud.position[i] + r * (std::cos(angle) * a + std::sin(angle) * cloud.axis2[i]));
        }
    }
    place_ = first_;
    note(s);
}

void Tracers::note(const Simulation& s) {
    before_.resize(s.particles.size());
    for (std::size_t j = 0; j < s.particles.size(); ++j)
        before_[static_cast<std::size_t>(s.particles.id[j])] = s.particles.position[j];
}

void Tracers::follow(const Simulation& s) {
    if (calls_++ % 4 != 0) return;
    std::vector<Vec3> from;
    for (std::size_t j = 0; j < s.particles.size(); ++j)
        from.push_back(before_[static_cast<std::size_t>(s.particles.id[j])]);
    PointGrid grid;
    grid.build(from, s.problem.smoothing.support);
    const Poly6 w(grid.cell());
    parallel_for(place_.size(), [&](std::size_t t) {
        Real weight = 0;
        Vec3 mean(0, 0, 0), mean_shift(0, 0, 0);
        Mat3 spread = Mat3::Zero(), covariance = Mat3::Zero();
        grid.for_each_neighbour(place_[t], grid.cell(), [&](Index j, Real r2) {
            const Real a = w.value(r2) / w.value(0);
            const Vec3 x = (from[j] - place_[t]) / grid.cell(), u = s.particles.position[j] - from[j];
            weight += a;
            mean += a * x;
            mean_shift += a * u;
            covariance += a * u * x.transpose();
            spread += a * x * x.transpose();
        });
        if (!(weight > 0)) return;
        mean /= weight;
        mean_shift /= weight;
        covariance = covariance / weight - mean_shift * mean.transpose();
        spread = spread / weight - mean * mean.transpose() + Real(5e-4) * Mat3::Identity();
        place_[t] += mean_shift - covariance * spread.inverse() * mean;
    });
    note(s);
}

Tracers::Errors Tracers::errors(const Simulation& s) const {
    const Matter matter(first_, place_, s.problem.smoothing.spacing);
    PointGrid body;
    body.build(first_, s.problem.smoothing.spacing / 2);
    const SurfelCloud& cloud = s.surface.surfels;
    Errors e;
    std::vector<std::pair<Real, Index>> near;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
        const Vec3& painted = s.surface.rest[i];
        if (Vec3 was; matter.at(cloud.position[i], cloud.normal[i], kNone, was))
            e.painted.push_back(static_cast<double>((painted - was).norm()));
        body.nearest(painted, 1, 100 * s.problem.smoothing.spacing, near);
        e.off_body.push_back(near.empty() ? std::numeric_limits<double>::infinity() : std::sqrt(double(near[0].first)));
    }
    for (Index p = 0; p < matter.normal.size(); ++p) {
        const Index middle = p * kPatch;
        if (Vec3 was; matter.at(place_[middle], matter.normal[p], p, was))
            e.own.push_back(static_cast<double>((first_[middle] - was).norm()));
    }
    for (auto* errors : {&e.painted, &e.own, &e.off_body}) std::ranges::sort(*errors);
    e.covered = static_cast<double>(e.painted.size()) / static_cast<double>(std::max<std::size_t>(cloud.size(), 1));
    return e;
}

}  // namespace thixo::gate
