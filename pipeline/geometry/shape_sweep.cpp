// A ball swept along a smooth curve.
#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/geometry/bounds.h"
#include "pipeline/geometry/shape_checks.h"
#include "pipeline/geometry/shapes.h"

namespace thixo {
namespace {

using Vec4 = Eigen::Matrix<Real, 4, 1>;  // place and radius
constexpr int kSteps = 8;                // of a span, to find where it is nearest

/// c(t) = ((a t + b) t + c) t + d, 0 <= t <= 1
struct Span {
    Vec4 a, b, c, d;
    Vec3 centre;  // of a ball that holds all of its balls
    Real reach;
    std::array<Vec4, kSteps + 1> sample;

    Vec4 at(Real t) const { return ((a * t + b) * t + c) * t + d; }
    /// Signed distance from x to the ball at t.
    Real ball(const Vec3& x, Real t) const {
        const Vec4 p = at(t);
        return (x - p.head<3>()).norm() - p[3];
    }
};

struct Swept final : Shape::Node {
    explicit Swept(std::vector<Span> list) : spans(std::move(list)) {
        for (std::size_t k = 0; k < spans.size(); ++k) {
            const Box3 ball{spans[k].centre - Vec3::Constant(spans[k].reach),
                            spans[k].centre + Vec3::Constant(spans[k].reach)};
            box = k == 0 ? ball : joined(box, ball);
        }
        tighten();
    }

    /// min over t of |x - c(t)| - r(t): the union of balls. By the nearest sample, then golden section around it.
    Real distance(const Vec3& x) const override {
        Real best = std::numeric_limits<Real>::max();
        for (const Span& s : spans) {
            if ((x - s.centre).norm() - s.reach >= best) continue;
            int nearest = 0;
            Real least = std::numeric_limits<Real>::max();
            for (int i = 0; i <= kSteps; ++i)
                if (const Real d = (x - s.sample[std::size_t(i)].head<3>()).norm() - s.sample[std::size_t(i)][3];
                    d < least) {
                    least = d;
                    nearest = i;
                }
            best = std::min(best, refine(s, x, nearest));
        }
        return best;
    }
    std::optional<Box3> bounds() const override { return box; }

    static Real refine(const Span& s, const Vec3& x, int nearest) {
        Real low = Real(std::max(nearest - 1, 0)) / kSteps, high = Real(std::min(nearest + 1, kSteps)) / kSteps;
        constexpr Real kGolden = Real(0.6180339887498949);
        Real t1 = high - kGolden * (high - low), t2 = low + kGolden * (high - low);
        Real d1 = s.ball(x, t1), d2 = s.ball(x, t2);
        for (int i = 0; i < 18; ++i) {
            if (d1 < d2) {
                high = t2;
                t2 = t1;
                d2 = d1;
                t1 = high - kGolden * (high - low);
                d1 = s.ball(x, t1);
            } else {
                low = t1;
                t1 = t2;
                d1 = d2;
                t2 = low + kGolden * (high - low);
                d2 = s.ball(x, t2);
            }
        }
        return std::min({d1, d2, s.ball(x, low), s.ball(x, high)});
    }

    /// The box of all balls, from many of them and what lies between two.
    void tighten() {
        constexpr int kFine = 64;
        bool first = true;
        for (const Span& s : spans)
            for (int i = 0; i <= kFine; ++i) {
                const Vec4 p = s.at(Real(i) / kFine), before = s.at(Real(std::max(i - 1, 0)) / kFine);
                const Vec3 half = Vec3::Constant(std::max(p[3], before[3]) + (p - before).head<3>().norm() / 2);
                const Box3 ball{p.head<3>() - half, p.head<3>() + half};
                box = first ? ball : joined(box, ball);
                first = false;
            }
    }

    std::vector<Span> spans;
    Box3 box;
};

Span make_span(const Eigen::Vector4d& from, const Eigen::Vector4d& to, const Eigen::Vector4d& m0,
               const Eigen::Vector4d& m1) {
    Span s;
    s.d = from.cast<Real>();
    s.c = m0.cast<Real>();
    s.b = (3 * (to - from) - 2 * m0 - m1).cast<Real>();
    s.a = (2 * (from - to) + m0 + m1).cast<Real>();
    // The curve lies in the hull of its Bezier points.
    const std::array<Eigen::Vector4d, 4> bezier{from, from + m0 / 3, to - m1 / 3, to};
    s.centre = ((bezier[0] + bezier[1] + bezier[2] + bezier[3]) / 4).head<3>().cast<Real>();
    s.reach = 0;
    for (const auto& p : bezier)
        s.reach =
            std::max(s.reach, (p.head<3>().cast<Real>() - s.centre).norm() + static_cast<Real>(std::max(p[3], 0.0)));
    for (int i = 0; i <= kSteps; ++i) s.sample[std::size_t(i)] = s.at(Real(i) / kSteps);
    return s;
}

}  // namespace

Shape swept(const std::vector<SweepPoint>& points, bool closed) {
    const std::size_t n = points.size();
    if (n < (closed ? 3 : 2)) throw InputError("sweep has {} points; it needs at least {}", n, closed ? 3 : 2);
    std::vector<Eigen::Vector4d> p;
    for (const SweepPoint& s : points) {
        finite_vector(s.at, "sweep point");
        positive_size(s.radius, "sweep radius");
        p.emplace_back(s.at.x(), s.at.y(), s.at.z(), s.radius);
    }
    const std::size_t count = closed ? n : n - 1;
    std::vector<double> length(count);
    for (std::size_t k = 0; k < count; ++k) {
        length[k] = (points[(k + 1) % n].at - points[k].at).norm();
        if (!(length[k] > 0)) throw InputError("sweep points {} and {} are in one place", k + 1, (k + 1) % n + 1);
    }
    // Velocities by the parabola through a point and its neighbours, time running with the chords' lengths.
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
        Span s = make_span(p[k], p[(k + 1) % n], m0, m1);
        for (const Vec4& ball : s.sample)
            if (!(ball[3] > 0))
                throw InputError("sweep radius falls to {} between points {} and {}; put a point between them", ball[3],
                                 k + 1, (k + 1) % n + 1);
        spans.push_back(s);
    }
    return Shape(std::make_shared<Swept>(std::move(spans)));
}

}  // namespace thixo
