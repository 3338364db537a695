#include "pipeline/geometry/implicit_surface.h"

#include <limits>

#include "pipeline/base/error.h"

namespace thixo {

void ImplicitSurface::build(std::span<const Vec3> positions, std::span<const Vec3> normals, Real support,
                            std::span<const std::int32_t> groups) {
    THIXO_ASSERT(normals.size() == positions.size() && (groups.empty() || groups.size() == positions.size()),
                 "{} positions, {} normals, {} groups", positions.size(), normals.size(), groups.size());
    support_ = support;
    grid_.build(positions, support);
    position_.resize(positions.size());
    normal_.resize(positions.size());
    group_.resize(groups.size());
    for (Index slot = 0; slot < positions.size(); ++slot) {
        const Index i = grid_.index(slot);
        position_[slot] = positions[i];
        normal_[slot] = normals[i];
        if (!groups.empty()) group_[slot] = groups[i];
    }
    grid_.build(position_, support);  // in cell order: the grid's indices are those of these arrays
}

template <class F>
void ImplicitSurface::for_each_selected(const Vec3& x, const SurfelSelection& selection, F&& f) const {
    const bool oriented = selection.reference != Vec3(0, 0, 0);
    grid_.for_each_neighbour(x, support_, [&](Index i, Real r2) {
        if (selection.group && !group_.empty() && group_[i] != *selection.group) return;
        if (oriented && normal_[i].dot(selection.reference) < selection.least_cosine) return;
        f(i, r2);
    });
}

std::optional<ImplicitSurface::Sample> ImplicitSurface::evaluate(const Vec3& x,
                                                                 const SurfelSelection& selection) const {
    const Poly6 w(support_);
    SurfelAverage average;
    for_each_selected(x, selection, [&](Index i, Real r2) { average.add(w.value(r2), position_[i] - x, normal_[i]); });
    if (!average.defined()) return std::nullopt;
    return Sample{average.value(),       x + average.position / average.weight,
                  average.unit_normal(), average.planes / average.weight,
                  Vec3(0, 0, 0),         average.normal.norm() / average.weight};
}

std::optional<ImplicitSurface::Sample> ImplicitSurface::evaluate_gradient(const Vec3& x,
                                                                          const SurfelSelection& selection) const {
    const Poly6 w(support_);
    SurfelAverage average;
    Vec3 weight_slope(0, 0, 0);        // sum of grad w_i
    Mat3 offset_slope = Mat3::Zero();  // sum of (s_i - x) grad w_i^T
    Mat3 normal_slope = Mat3::Zero();  // sum of n_i grad w_i^T
    for_each_selected(x, selection, [&](Index i, Real r2) {
        const Vec3 offset = position_[i] - x;
        const Vec3 slope = -w.gradient_factor(r2) * offset;
        average.add(w.value(r2), offset, normal_[i]);
        weight_slope += slope;
        offset_slope += offset * slope.transpose();
        normal_slope += normal_[i] * slope.transpose();
    });
    if (!average.defined()) return std::nullopt;
    const Vec3 n = average.unit_normal();
    const Vec3 to_average = average.position / average.weight;  // a - x
    //     grad a = sum (s_i - a) grad w_i^T / sum w_i  [1]
    //     grad n = (1 - n n^T) sum n_i grad w_i^T / |sum w_i n_i|  [1/m]
    const Mat3 a_slope = (offset_slope - to_average * weight_slope.transpose()) / average.weight;
    const Mat3 n_slope = (normal_slope - n * (n.transpose() * normal_slope)) / average.normal.norm();
    const Vec3 gradient = n - a_slope.transpose() * n - n_slope.transpose() * to_average;
    return Sample{-n.dot(to_average),
                  x + to_average,
                  n,
                  average.planes / average.weight,
                  gradient,
                  average.normal.norm() / average.weight};
}

std::optional<Vec3> ImplicitSurface::nearest_normal(const Vec3& x) const {
    Real nearest = std::numeric_limits<Real>::max();
    std::optional<Vec3> normal;
    grid_.for_each_neighbour(x, support_, [&](Index i, Real r2) {
        if (r2 >= nearest) return;
        nearest = r2;
        normal = normal_[i];
    });
    return normal;
}

namespace {

/// Iterates x <- next(sample at x) until the step is small. Steps longer than half a support would leave the domain and
/// are shortened.
template <class Evaluate, class Next>
SurfaceProjection iterate(const Vec3& start, Real support, const ProjectionLimits& limits, Evaluate&& evaluate,
                          Next&& next) {
    SurfaceProjection result;
    result.position = start;
    for (result.steps = 0; result.steps < limits.steps; ++result.steps) {
        const auto sample = evaluate(result.position);
        if (!sample) {
            result.status = SurfaceStatus::left_domain;
            return result;
        }
        result.normal = sample->normal;
        Vec3 step = next(*sample, result.position) - result.position;
        const Real length = step.norm();
        if (length > support / 2) step *= support / (2 * length);
        result.position += step;
        if (length <= limits.tolerance * support) {
            result.status = SurfaceStatus::converged;
            return result;
        }
    }
    result.status = SurfaceStatus::step_cap;
    return result;
}

}  // namespace

SurfaceProjection ImplicitSurface::project_simple(const Vec3& x0, const SurfelSelection& selection,
                                                  const ProjectionLimits& limits) const {
    return iterate(
        x0, support_, limits, [&](const Vec3& x) { return evaluate(x, selection); },
        [](const Sample& sample, const Vec3& x) -> Vec3 { return x - sample.value * sample.normal; });
}

SurfaceProjection ImplicitSurface::project_almost_orthogonal(const Vec3& x0, const SurfelSelection& selection,
                                                             const ProjectionLimits& limits) const {
    return iterate(
        x0, support_, limits, [&](const Vec3& x) { return evaluate(x, selection); },
        [&](const Sample& sample, const Vec3&) -> Vec3 {
            return x0 - sample.normal.dot(x0 - sample.average) * sample.normal;
        });
}

SurfaceProjection ImplicitSurface::project_orthogonal(const Vec3& x0, const SurfelSelection& selection,
                                                      const ProjectionLimits& limits) const {
    return iterate(
        x0, support_, limits, [&](const Vec3& x) { return evaluate_gradient(x, selection); },
        [&](const Sample& sample, const Vec3&) -> Vec3 {
            const Real slope = sample.normal.dot(sample.gradient);
            // Where F hardly changes along n, the foot point is not determined. The step then goes along n.
            const Vec3 direction = slope > Real(0.1) ? Vec3(sample.gradient / slope) : sample.normal;
            return x0 - sample.normal.dot(x0 - sample.average) * direction;
        });
}

SurfaceRoot ImplicitSurface::root(const Vec3& from, const Vec3& to, const SurfelSelection& selection,
                                  const ProjectionLimits& limits) const {
    SurfaceRoot result;
    const Vec3 along = to - from;
    const Real length = along.norm();
    const auto first = evaluate(from, selection), last = evaluate(to, selection);
    if (!first || !last) {
        result.status = SurfaceStatus::left_domain;
        return result;
    }
    // Brent 1973, chapter 4: b is the best point, a the best before it, and c lies on the other side of the root.
    Real a = 0, b = 1, c = 0, fa = first->value, fb = last->value, fc = fa;
    if ((fa > 0) == (fb > 0) && fa != 0 && fb != 0) return result;
    Real step = b - a, previous = step;
    const Real tolerance = length > 0 ? limits.tolerance * support_ / length : Real(1);
    for (result.steps = 0; result.steps < limits.steps; ++result.steps) {
        if ((fb > 0) == (fc > 0)) {
            c = a;
            fc = fa;
            step = previous = b - a;
        }
        if (std::abs(fc) < std::abs(fb)) {
            a = b, b = c, c = a;
            fa = fb, fb = fc, fc = fa;
        }
        const Real half = (c - b) / 2;
        result.t = b;
        if (std::abs(half) <= tolerance || fb == 0) {
            result.status = SurfaceStatus::converged;
            return result;
        }
        if (std::abs(previous) >= tolerance && std::abs(fa) > std::abs(fb)) {
            const Real s = fb / fa;
            Real p, q;
            if (a == c) {
                p = 2 * half * s;
                q = 1 - s;
            } else {
                const Real u = fa / fc, v = fb / fc;
                p = s * (2 * half * u * (u - v) - (b - a) * (v - 1));
                q = (u - 1) * (v - 1) * (s - 1);
            }
            if (p > 0) q = -q;
            p = std::abs(p);
            if (2 * p < std::min(3 * half * q - std::abs(tolerance * q), std::abs(previous * q))) {
                previous = step;
                step = p / q;
            } else {
                step = previous = half;
            }
        } else {
            step = previous = half;
        }
        a = b;
        fa = fb;
        b += std::abs(step) > tolerance ? step : (half > 0 ? tolerance : -tolerance);
        const auto sample = evaluate(from + b * along, selection);
        if (!sample) {
            result.t = b;
            result.status = SurfaceStatus::left_domain;
            return result;
        }
        fb = sample->value;
    }
    result.t = b;
    result.status = SurfaceStatus::step_cap;
    return result;
}

}  // namespace thixo
