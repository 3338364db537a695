#include "sim/surface/zombies.h"

#include <algorithm>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/implicit_surface.h"
#include "sim/surface/displace.h"

namespace thixo {
namespace {

constexpr Real kSameSide = Real(0.5);  // cosine between normals of one side
// A tenth of the surfels' level. Where the damped gradient is wrong, zombies return to the surface, but not along it.
constexpr Real kLevel = Real(0.0005);
constexpr Real kNear = Real(0.3);   // largest distance of zombies from the surface, in surfel supports
constexpr int kAsked = 24;          // zombies examined
constexpr std::size_t kFitted = 8;  // most of them that take part in a fit
// Largest x^T S^-1 x of a place x from the mean of points that spread by S. At the rim of a disc of points it is 4.
constexpr Real kBeyond = 4;
using Vec2 = Eigen::Matrix<Real, 2, 1>;
using Mat2 = Eigen::Matrix<Real, 2, 2>;
using Mat32 = Eigen::Matrix<Real, 3, 2>;
// Two zombies whose distance was this much larger at first than now were brought together by a fold or a merge.
constexpr Real kFolded = 4;

/// Weighted first-order fit of m0 about a place, along the surface.
struct RestFit {
    Real weight = 0;
    Vec2 mean{0, 0};
    Vec3 mean_rest{0, 0, 0};
    Mat2 spread = Mat2::Zero();
    Mat32 covariance = Mat32::Zero();
    void add(Real w, const Vec2& x, const Vec3& m) {
        weight += w;
        mean += w * x;
        mean_rest += w * m;
        covariance += (w * m) * x.transpose();
        spread += (w * x) * x.transpose();
    }
    /// The value at x = 0; offsets are in parts of the weights' support. Beyond the points the fit is continued no
    /// farther than kBeyond: where the surface has grown it would soon lead out of the body.
    Vec3 value() const {
        const Vec2 x = mean / weight;
        const Vec3 m = mean_rest / weight;
        const Mat32 c = covariance / weight - m * x.transpose();
        const Mat2 s = spread / weight - x * x.transpose() + Real(1e-3) * Mat2::Identity();
        const Vec2 y = s.inverse() * x;
        const Real far = x.dot(y);
        return m - (far > kBeyond ? std::sqrt(kBeyond / far) : Real(1)) * c * y;
    }
};

}  // namespace

void add_zombie(const SurfelCloud& cloud, std::size_t i, const Vec3& rest, std::int32_t component, std::int32_t body,
                Zombies& zombies) {
    zombies.position.push_back(cloud.position[i]);
    zombies.normal.push_back(cloud.normal[i]);
    zombies.rest.push_back(rest);
    zombies.component.push_back(component);
    zombies.body.push_back(body);
}

void displace_zombies(const ParticleRows& particles, Real support, Zombies& zombies) {
    if (zombies.size() == 0) return;
    for_each_motion(zombies.position, particles, zombies.component, support, kLevel,
                    [&](std::size_t i, const LocalMotion& motion) {
                        zombies.position[i] += motion.shift;
                        zombies.normal[i] = motion.turned(zombies.normal[i]);
                    });
}

void project_zombies(const SurfaceState& surface, const std::vector<std::int32_t>& component,
                     const std::vector<Real>& melt, Real support, Zombies& zombies) {
    if (zombies.size() == 0 || surface.size() == 0) return;
    const SurfelCloud& cloud = surface.surfels;
    // Beside solid matter alone zombies are where they should be.
    std::vector<Vec3> molten;
    for (std::size_t i = 0; i < surface.size(); ++i)
        if (melt[i] > 0) molten.push_back(cloud.position[i]);
    if (molten.empty()) return;
    PointGrid grid, molten_grid;
    grid.build(cloud.position, support);
    molten_grid.build(molten, support);
    const Poly6 w(support);
    parallel_for(zombies.size(), [&](std::size_t k) {
        bool any = false;
        molten_grid.for_each_neighbour(zombies.position[k], support, [&](Index, Real) { any = true; });
        if (!any) return;
        SurfelAverage average;
        int count = 0;
        Real melted = 0;
        grid.for_each_neighbour(zombies.position[k], support, [&](Index i, Real r2) {
            if (component[i] != zombies.component[k] || cloud.normal[i].dot(zombies.normal[k]) < kSameSide) return;
            average.add(w.value(r2), cloud.position[i] - zombies.position[k], cloud.normal[i]);
            melted += w.value(r2) * melt[i];
            ++count;
        });
        if (count < 3 || !average.defined()) return;
        const Real b = std::min(melted / average.weight, Real(1));
        const Vec3 n = average.unit_normal(), turned = (1 - b) * zombies.normal[k] + b * n;
        const Real off = average.value(), near = kNear * support;
        zombies.position[k] -= b * (off - std::clamp(off, -near, near)) * n;
        if (turned.squaredNorm() > 0) zombies.normal[k] = turned.normalized();
    });
}

void take_rest_of_zombies(const Zombies& zombies, const std::vector<std::int32_t>& component,
                          const std::vector<Real>& melt, Real reach, SurfaceState& surface) {
    if (zombies.size() == 0) return;
    PointGrid grid;
    grid.build(zombies.position, reach / 4);  // most of the zombies looked for are nearer than that
    const SurfelCloud& cloud = surface.surfels;
    parallel_for(surface.size(), [&](std::size_t i) {
        if (!(melt[i] > 0)) return;
        const Vec3& x = cloud.position[i];
        const Vec3& n = cloud.normal[i];
        Vec3 a, b;
        orthonormal_basis(n, a, b);
        std::vector<std::pair<Real, Index>> near, chosen;
        grid.nearest(x, kAsked, reach, near);
        for (const auto& [r2, k] : near) {
            if (zombies.component[k] != component[i] || zombies.normal[k].dot(n) < kSameSide) continue;
            if (!chosen.empty()) {
                const Index first = chosen.front().second;
                const Real apart = (zombies.position[k] - zombies.position[first]).norm() + reach / 8;
                if (zombies.body[k] != zombies.body[first] ||
                    (zombies.rest[k] - zombies.rest[first]).norm() > kFolded * apart)
                    continue;
            }
            chosen.emplace_back(r2, k);
            if (chosen.size() == kFitted) break;
        }
        if (chosen.empty()) return;
        const Real support = Real(1.05) * std::sqrt(chosen.back().first) + reach / 1000;
        const Poly6 w(support);
        const Vec3& origin = zombies.rest[chosen.front().second];
        RestFit fit;
        for (const auto& [r2, k] : chosen) {
            const Vec3 off = (zombies.position[k] - x) / support;
            fit.add(w.value(r2) / w.value(0), {a.dot(off), b.dot(off)}, zombies.rest[k] - origin);
        }
        surface.rest[i] = origin + fit.value();
    });
}

}  // namespace thixo
