#include "sim/solid/plasticity.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

namespace thixo {
namespace {

// A finite return along dev e misses its goal by the curvature of the metric. Each further one corrects most of that.
constexpr int kMostReturns = 16;
constexpr Real kReturned = Real(1e-3);  // what may be missing of a flow, in its size
constexpr Real kStrainRounding = 4 * std::numeric_limits<Real>::epsilon();
// Largest change of the metric in one return, in parts of itself: far below 1, so that it stays positive definite.
constexpr double kLongestReturn = 0.3;
constexpr double kCrushed = 1e-3;  // least det C_p

Symmetric sum(const Symmetric& a, Real factor, const Symmetric& b) {
    return {a.xx + factor * b.xx, a.yy + factor * b.yy, a.zz + factor * b.zz,
            a.xy + factor * b.xy, a.yz + factor * b.yz, a.zx + factor * b.zx};
}

/// C_p = 1 + 2 eps^p. Of an element so crushed that this has no meaning as a shape, the metric is that of no flow.
Mat3d metric_of(const Symmetric& plastic) {
    const Mat3d metric = Mat3d::Identity() + 2 * matrix(plastic).cast<double>();
    return metric.determinant() > kCrushed ? metric : Mat3d::Identity();
}

Symmetric flowing_strain(const StressLaw& law, const Symmetric& strain, const Symmetric& plastic) {
    const Symmetric elastic = sum(strain, -1, plastic);
    if (!law.keeps_volume) return elastic;
    const Mat3d metric = metric_of(plastic);
    const double mean = metric.inverse().cwiseProduct(matrix(elastic).cast<double>()).sum() / 3;
    return sum(elastic, -1, symmetric(Mat3((mean * metric).cast<Real>())));
}

/// |U_p^-1 e U_p^-1|, by tr (C_p^-1 e)^2.
Real size_of(const StressLaw& law, const Symmetric& flowing, const Symmetric& plastic) {
    if (!law.keeps_volume) return norm(flowing);
    const Mat3d mixed = metric_of(plastic).inverse() * matrix(flowing).cast<double>();
    return static_cast<Real>(std::sqrt(std::max(0.0, mixed.cwiseProduct(mixed.transpose()).sum())));
}

Mat3 inverse_root(const Symmetric& plastic) {
    Eigen::SelfAdjointEigenSolver<Mat3d> eigen;
    eigen.computeDirect(metric_of(plastic));
    return eigen.operatorInverseSqrt().cast<Real>();
}

/// The longest part of `step` in [0, 1] after which |plastic + part step| is at most `limit`.
Real allowed_part(const Symmetric& plastic, const Symmetric& step, Real limit) {
    if (norm(sum(plastic, 1, step)) <= limit) return 1;
    const Mat3 p = matrix(plastic), d = matrix(step);
    const Real a = d.squaredNorm(), b = p.cwiseProduct(d).sum(), c = p.squaredNorm() - square(limit);
    const Real root = b * b - a * c;
    return root > 0 && a > 0 ? std::clamp((std::sqrt(root) - b) / a, Real(0), Real(1)) : Real(0);
}

/// One return, in which `step` is cut where it is too long. Returns the part that was taken.
Real flow_keeping_volume(const StressLaw& law, const Symmetric& step, Symmetric& plastic) {
    const Mat3d metric = metric_of(plastic), change = 2 * matrix(step).cast<double>();
    double part = std::min(1.0, kLongestReturn / (metric.inverse() * change).norm());
    if (law.most_plastic > 0) part = std::min<double>(part, allowed_part(plastic, step, law.most_plastic));
    // det C_p changes by the square of the step. Then C_p grows alike in all directions to where it was.
    const Mat3d next = metric + part * change;
    const double back = std::cbrt(metric.determinant() / next.determinant());
    const Mat3d gain = part * change + (back - 1) * next;
    plastic = sum(plastic, 1, symmetric(Mat3((gain / 2).cast<Real>())));
    return static_cast<Real>(part);
}

/// The same for the whole strain: eps^p is turned where it is as large as it may be.
Real flow_as_a_whole(const StressLaw& law, const Symmetric& step, Symmetric& plastic) {
    plastic = sum(plastic, 1, step);
    const Real size = norm(plastic);
    if (law.most_plastic > 0 && size > law.most_plastic) plastic = sum({}, law.most_plastic / size, plastic);
    return 1;
}

}  // namespace

Real remaining_part(const StressLaw& law, Real dt, Real size, Real hardened) {
    const Real yield = law.yield + law.hardening * hardened;
    if (!(law.creep > 0) || !(size > yield)) return 1;
    const Real surface = (yield + law.hardening * size) / (1 + law.hardening);
    return std::max(std::exp(-law.creep * dt), surface / size);
}

Real flowing_size(const StressLaw& law, const Symmetric& strain, const Symmetric& plastic) {
    return size_of(law, flowing_strain(law, strain, plastic), plastic);
}

bool is_reshaped(const StressLaw& law, const Symmetric& plastic) { return law.keeps_volume && norm(plastic) > 0; }

Mat3 inverse_metric(const Symmetric& plastic) { return metric_of(plastic).inverse().cast<Real>(); }

Symmetric strain_of_shape(const Symmetric& elastic, const Symmetric& plastic) {
    const Mat3 root = inverse_root(plastic);
    return symmetric(Mat3(root * matrix(elastic) * root));
}

Symmetric plastic_beside(const StressLaw& law, const Symmetric& strain, const Symmetric& elastic) {
    if (!law.keeps_volume) return sum(strain, -1, elastic);
    const auto metric = [](const Symmetric& s) { return Mat3d(Mat3d::Identity() + 2 * matrix(s).cast<double>()); };
    Eigen::SelfAdjointEigenSolver<Mat3d> eigen;
    eigen.computeDirect(metric(strain));
    const Mat3d root = eigen.operatorSqrt();
    const Mat3d shape = root * metric(elastic).inverse() * root;
    return symmetric(Mat3(((shape - Mat3d::Identity()) / 2).cast<Real>()));
}

bool flow_plastically(const StressLaw& law, Real dt, const Symmetric& strain, Symmetric& plastic, Real& hardened) {
    Symmetric flowing = flowing_strain(law, strain, plastic);
    const Real first = size_of(law, flowing, plastic), remaining = remaining_part(law, dt, first, hardened);
    if (remaining >= 1) return false;
    const Real goal = remaining * first;
    const Real enough = std::max(kReturned * std::min(first - goal, goal), kStrainRounding * (first + norm(strain)));
    Real size = first, gain = 1;  // how much |dev e| falls, over the return's length
    for (int k = 0; k < kMostReturns && std::abs(size - goal) > enough; ++k) {
        const Real length = (size - goal) / gain, before = size;
        const Symmetric step = sum({}, length / size, flowing);
        const Real part =
            law.keeps_volume ? flow_keeping_volume(law, step, plastic) : flow_as_a_whole(law, step, plastic);
        flowing = flowing_strain(law, strain, plastic);
        size = size_of(law, flowing, plastic);
        if (!(part > 0) || std::abs(before - size) < enough / 2) break;  // the limit of eps^p holds it
        gain = std::clamp((before - size) / (part * length), Real(0.5), Real(2));
    }
    hardened += std::max(first - size, Real(0));
    return size > (law.yield + law.hardening * hardened) * (1 + kReturned);
}

}  // namespace thixo
