// A ball swept along a smooth curve.
#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/geometry/bounds.h"
#include "pipeline/geometry/local_shape.h"
#include "pipeline/geometry/shape_checks.h"
#include "pipeline/geometry/shapes.h"
#include "pipeline/geometry/sloped_shape.h"

namespace thixo {
namespace {

using Vec4 = Eigen::Matrix<Real, 4, 1>;  // place and radius
constexpr int kSamples = 8;              // samples of a span, to find where it is nearest
constexpr int kSteps = kSamples - 1;

/// A span of the curve:
///     c(t) = ((a t + b) t + c) t + d,  0 <= t <= 1
struct Span {
    Vec4 a, b, c, d;
    Vec3 centre;  // of a ball around all balls of the span
    Real reach;
    Real sample_x[kSamples], sample_y[kSamples], sample_z[kSamples], radius[kSamples];
    Real between;  // a ball between samples is nearer than a sample by at most this

    Vec4 at(Real t) const { return ((a * t + b) * t + c) * t + d; }
    Vec4 velocity(Real t) const { return (3 * a * t + 2 * b) * t + c; }
    Vec4 acceleration(Real t) const { return 6 * a * t + 2 * b; }

    /// The signed distance from x to the nearest sample's ball.
    Real nearest_sample(const Vec3& x, int& nearest) const {
        Real away[kSamples];
        for (int i = 0; i < kSamples; ++i)
            away[i] =
                std::sqrt(square(x.x() - sample_x[i]) + square(x.y() - sample_y[i]) + square(x.z() - sample_z[i])) -
                radius[i];
        nearest = 0;
        for (int i = 1; i < kSamples; ++i)
            if (away[i] < away[nearest]) nearest = i;
        return away[nearest];
    }
    /// The minimum near a sample of
    ///     f(t) = |x - c(t)| - r(t)  [m]
    /// Newton's method on f' runs within the bracket of the neighbouring samples, with bisection where a step leaves
    /// it. `found` is the ball there.
    Real refined(const Vec3& x, int nearest, Vec4& found) const {
        Real low = Real(std::max(nearest - 1, 0)) / kSteps, high = Real(std::min(nearest + 1, kSteps)) / kSteps;
        Real t = Real(nearest) / kSteps, best = std::numeric_limits<Real>::max();
        for (int i = 0; i < 12; ++i) {
            const Vec4 p = at(t), v = velocity(t), w = acceleration(t);
            const Vec3 from = p.head<3>() - x;
            const Real away = from.norm(), inverse = 1 / std::max(away, std::numeric_limits<Real>::min());
            if (away - p[3] < best) {
                best = away - p[3];
                found = p;
            }
            const Real along = from.dot(v.head<3>()) * inverse, slope = along - v[3];
            (slope > 0 ? high : low) = t;
            const Real curvature = (v.head<3>().squaredNorm() + from.dot(w.head<3>()) - along * along) * inverse - w[3];
            Real next = t - slope / curvature;
            const bool newton = curvature > 0 && next >= low && next <= high;
            if (!newton) next = (low + high) / 2;
            const Real step = std::abs(next - t);
            t = next;
            // The remaining error of t is of second order in the step, and that of f is of second order in the error of
            // t.
            if (step < (newton ? Real(5e-3) : Real(1e-4))) break;
        }
        const Vec4 p = at(t);
        const Real last = (x - p.head<3>()).norm() - p[3];
        if (!(last < best)) return best;
        found = p;
        return last;
    }
};

struct Swept final : Shape::Node, PartedNode, SlopedNode {
    explicit Swept(std::vector<Span> list) : spans(std::move(list)) {
        for (std::size_t k = 0; k < spans.size(); ++k) {
            const Box3 ball{spans[k].centre - Vec3::Constant(spans[k].reach),
                            spans[k].centre + Vec3::Constant(spans[k].reach)};
            box = k == 0 ? ball : joined(box, ball);
        }
        tighten();
        lay_out();
    }
    void lay_out() {
        for (auto* v : {&centre_x, &centre_y, &centre_z, &reach}) v->clear();
        for (const Span& span : spans) {
            centre_x.push_back(span.centre.x());
            centre_y.push_back(span.centre.y());
            centre_z.push_back(span.centre.z());
            reach.push_back(span.reach);
        }
    }

    /// Distance to the union of balls:
    ///     min over t of |x - c(t)| - r(t)  [m]
    /// Newton's method starts from the nearest sample. Spans that cannot be nearer than another's samples are left out.
    Real distance(const Vec3& x) const override {
        Vec4 ball;
        return nearest_ball(x, ball);
    }
    Real sloped(const Vec3& x, Real, Vec3& slope) const override {
        Vec4 ball;
        const Real d = nearest_ball(x, ball);
        slope = x - ball.head<3>();
        const Real away = slope.norm();
        if (away > 0) slope /= away;
        return d;
    }
    Real nearest_ball(const Vec3& x, Vec4& ball) const {
        thread_local std::vector<Real> bound;
        bound.resize(centre_x.size());
        for (std::size_t k = 0; k < bound.size(); ++k)
            bound[k] =
                std::sqrt(square(x.x() - centre_x[k]) + square(x.y() - centre_y[k]) + square(x.z() - centre_z[k])) -
                reach[k];
        const auto first = static_cast<std::size_t>(std::ranges::min_element(bound) - bound.begin());
        Real best = std::numeric_limits<Real>::max();
        const auto ask = [&](const Span& span) {
            int nearest;
            const Real sample = span.nearest_sample(x, nearest);
            if (!(sample - span.between < best)) return;
            Vec4 found;
            if (const Real d = span.refined(x, nearest, found); d < best) {
                best = d;
                ball = found;
            }
        };
        ask(spans[first]);
        for (std::size_t k = 0; k < spans.size(); ++k)
            if (k != first && bound[k] < best) ask(spans[k]);
        return best;
    }
    std::optional<Shape> within(const Ball3& ball) const override {
        std::vector<Real> sample;
        int nearest;
        for (const Span& span : spans) sample.push_back(span.nearest_sample(ball.centre, nearest));
        const Real most = *std::ranges::min_element(sample) + 2 * ball.radius;
        std::vector<Span> kept;
        for (std::size_t k = 0; k < spans.size(); ++k)
            if (sample[k] - spans[k].between <= most) kept.push_back(spans[k]);
        if (kept.size() == spans.size()) return std::nullopt;
        auto part = std::make_shared<Swept>(*this);
        part->spans = std::move(kept);
        part->lay_out();
        return Shape(std::move(part));
    }
    std::optional<Box3> bounds() const override { return box; }

    /// A box around all balls, from many of them and a bound of what lies between two.
    void tighten() {
        constexpr int kFine = 64;
        bool first = true;
        for (const Span& span : spans)
            for (int i = 0; i <= kFine; ++i) {
                const Vec4 p = span.at(Real(i) / kFine), before = span.at(Real(std::max(i - 1, 0)) / kFine);
                const Vec3 half = Vec3::Constant(std::max(p[3], before[3]) + (p - before).head<3>().norm() / 2);
                const Box3 ball{p.head<3>() - half, p.head<3>() + half};
                box = first ? ball : joined(box, ball);
                first = false;
            }
    }

    std::vector<Span> spans;
    std::vector<Real> centre_x, centre_y, centre_z, reach;  // of the spans, side by side
    Box3 box;
};

Span make_span(const Eigen::Vector4d& from, const Eigen::Vector4d& to, const Eigen::Vector4d& m0,
               const Eigen::Vector4d& m1) {
    Span span;
    span.d = from.cast<Real>();
    span.c = m0.cast<Real>();
    span.b = (3 * (to - from) - 2 * m0 - m1).cast<Real>();
    span.a = (2 * (from - to) + m0 + m1).cast<Real>();
    // The curve lies in the hull of its Bezier points.
    const std::array<Eigen::Vector4d, 4> bezier{from, from + m0 / 3, to - m1 / 3, to};
    span.centre = ((bezier[0] + bezier[1] + bezier[2] + bezier[3]) / 4).head<3>().cast<Real>();
    span.reach = 0;
    for (const auto& p : bezier)
        span.reach = std::max(span.reach,
                              (p.head<3>().cast<Real>() - span.centre).norm() + static_cast<Real>(std::max(p[3], 0.0)));
    for (int i = 0; i < kSamples; ++i) {
        const Vec4 p = span.at(Real(i) / kSteps);
        span.sample_x[i] = p.x(), span.sample_y[i] = p.y(), span.sample_z[i] = p.z(), span.radius[i] = p.w();
    }
    // Half a step at the greatest speed of centre and radius. The velocity lies in the hull of its own Bezier points.
    double fastest = 0;
    for (const Eigen::Vector4d& v : {m0, Eigen::Vector4d(3 * (to - from) - m0 - m1), m1})
        fastest = std::max(fastest, v.head<3>().norm() + std::abs(v[3]));
    span.between = static_cast<Real>(fastest / (2 * kSteps));
    return span;
}

}  // namespace

Shape swept(const std::vector<SweepPoint>& points, bool closed) {
    const std::size_t n = points.size();
    if (n < (closed ? 3 : 2)) throw InputError("sweep has {} points; it needs at least {}", n, closed ? 3 : 2);
    std::vector<Eigen::Vector4d> p;
    for (const SweepPoint& point : points) {
        finite_vector(point.at, "sweep point");
        positive_size(point.radius, "sweep radius");
        p.emplace_back(point.at.x(), point.at.y(), point.at.z(), point.radius);
    }
    const std::size_t count = closed ? n : n - 1;
    std::vector<double> length(count);
    for (std::size_t k = 0; k < count; ++k) {
        length[k] = (points[(k + 1) % n].at - points[k].at).norm();
        if (!(length[k] > 0)) throw InputError("sweep points {} and {} are in one place", k + 1, (k + 1) % n + 1);
    }
    // Velocities of the parabola through a point and its neighbours, with the lengths of the chords as times.
    const auto slope = [&](std::size_t k) { return Eigen::Vector4d((p[(k + 1) % n] - p[k % n]) / length[k % count]); };
    const auto velocity = [&](std::size_t k) {
        if (!closed && k == 0) return slope(0);
        if (!closed && k == n - 1) return slope(n - 2);
        const double before = length[(k + count - 1) % count], after = length[k % count];
        return Eigen::Vector4d((after * slope((k + count - 1) % count) + before * slope(k)) / (before + after));
    };
    std::vector<Span> spans;
    for (std::size_t k = 0; k < count; ++k) {
        const Eigen::Vector4d m0 = length[k] * velocity(k), m1 = length[k] * velocity((k + 1) % n);
        Span span = make_span(p[k], p[(k + 1) % n], m0, m1);
        for (const Real radius : span.radius)
            if (!(radius > 0))
                throw InputError("sweep radius falls to {} between points {} and {}; put a point between them", radius,
                                 k + 1, (k + 1) % n + 1);
        spans.push_back(span);
    }
    return Shape(std::make_shared<Swept>(std::move(spans)));
}

}  // namespace thixo
