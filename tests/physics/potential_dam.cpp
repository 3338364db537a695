#include "tests/physics/potential_dam.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "pipeline/base/math.h"

namespace thixo::potential_flow {
namespace {

/// The free surface from the wall down to the floor. The fluid lies to the right.
struct Surface {
    std::vector<Vec2d> x;     // nodes [m]
    std::vector<double> phi;  // potential [m^2/s]
    std::size_t size() const { return x.size(); }
};

struct Rate {
    std::vector<Vec2d> x;
    std::vector<double> phi;
    std::vector<double> normal;  // d phi/dn, n outwards [m/s]
};

/// Integrals over one element of ln r and of its derivative along the outward normal, weighted by the shape functions
/// of the element's two ends.
struct ElementIntegrals {
    double single[2], twofold[2];
};

/// Seen from the source, points of the element are at (s, d): s runs along it from s1 to s2, d along its normal.
ElementIntegrals integrate(double s1, double s2, double d) {
    const auto log_r = [d](double s) { return 0.5 * std::log(s * s + d * d + 1e-300); };
    const auto angle = [d](double s) { return std::abs(d) > 1e-14 ? std::atan(s / d) : 0.0; };
    const auto constant = [&](double s) { return s * log_r(s) - s + d * angle(s); };
    const auto linear = [&](double s) { return 0.5 * (s * s + d * d) * (log_r(s) - 0.5); };
    const double length = s2 - s1;
    const double single = constant(s2) - constant(s1), turned = angle(s2) - angle(s1);
    const double single_end = (linear(s2) - linear(s1) - s1 * single) / length;
    const double turned_end = (d * (log_r(s2) - log_r(s1)) - s1 * turned) / length;
    return {{single - single_end, single_end}, {turned - turned_end, turned_end}};
}

Vec2d turned_left(const Vec2d& t) { return {-t.y(), t.x()}; }

/// Row i of Green's third identity, summed over the source and its three images:
///     sum_j twofold_ij phi_j = sum_j single_ij (d phi/dn)_j  [m^2/s]
/// The diagonal follows from a constant potential, which has no flow.
void add_row(const Surface& s, Eigen::Index i, Eigen::MatrixXd& single, Eigen::MatrixXd& twofold) {
    const Vec2d at = s.x[static_cast<std::size_t>(i)];
    for (const double mirror_x : {1.0, -1.0})
        for (const double mirror_z : {1.0, -1.0}) {
            const Vec2d source(mirror_x * at.x(), mirror_z * at.y());
            for (std::size_t e = 0; e + 1 < s.size(); ++e) {
                const Vec2d along = (s.x[e + 1] - s.x[e]).normalized(), to = s.x[e] - source,
                            past = s.x[e + 1] - source;
                const ElementIntegrals part = integrate(to.dot(along), past.dot(along), to.dot(turned_left(along)));
                for (Eigen::Index end = 0; end < 2; ++end) {
                    single(i, static_cast<Eigen::Index>(e) + end) += part.single[end];
                    twofold(i, static_cast<Eigen::Index>(e) + end) += part.twofold[end];
                }
            }
        }
    twofold(i, i) -= twofold.row(i).sum();
}

std::vector<double> normal_velocity(const Surface& s) {
    const auto n = static_cast<Eigen::Index>(s.size());
    Eigen::MatrixXd single = Eigen::MatrixXd::Zero(n, n), twofold = single;
    for (Eigen::Index i = 0; i < n; ++i) add_row(s, i, single, twofold);
    const Eigen::VectorXd q = single.partialPivLu().solve(twofold * Eigen::Map<const Eigen::VectorXd>(s.phi.data(), n));
    return {q.begin(), q.end()};
}

/// Tangent and d phi/ds at a node, from the parabola through its neighbours. At the wall the neighbour is the mirror
/// image. The toe becomes a sharp wedge, and takes both from the last element.
std::pair<Vec2d, double> along_surface(const Surface& s, std::size_t i) {
    const std::size_t last = s.size() - 1;
    if (i == last) {
        const Vec2d step = s.x[last] - s.x[last - 1];
        return {step.normalized(), (s.phi[last] - s.phi[last - 1]) / step.norm()};
    }
    const Vec2d before = i > 0 ? s.x[i - 1] : Vec2d(-s.x[1].x(), s.x[1].y());
    const double phi_before = s.phi[i > 0 ? i - 1 : 1];
    const double a = (s.x[i] - before).norm(), b = (s.x[i + 1] - s.x[i]).norm();
    const double from = -b / (a * (a + b)), to = a / (b * (a + b));
    const Vec2d t = from * (before - s.x[i]) + to * (s.x[i + 1] - s.x[i]);
    const double slope = from * (phi_before - s.phi[i]) + to * (s.phi[i + 1] - s.phi[i]);
    return {t.normalized(), slope / t.norm()};
}

Rate rate_of(const Surface& s, double gravity) {
    Rate rate{std::vector<Vec2d>(s.size()), std::vector<double>(s.size()), normal_velocity(s)};
    for (std::size_t i = 0; i < s.size(); ++i) {
        const auto [t, slope] = along_surface(s, i);
        rate.x[i] = slope * t + rate.normal[i] * turned_left(t);
    }
    rate.x.front().x() = 0;
    rate.x.back().y() = 0;
    for (std::size_t i = 0; i < s.size(); ++i) rate.phi[i] = 0.5 * rate.x[i].squaredNorm() - gravity * s.x[i].y();
    return rate;
}

Surface moved(Surface s, const Rate& rate, double dt) {
    for (std::size_t i = 0; i < s.size(); ++i) {
        s.x[i] += dt * rate.x[i];
        s.phi[i] += dt * rate.phi[i];
    }
    return s;
}

/// One step of the Runge-Kutta method of fourth order.
Surface advanced(const Surface& s, double gravity, double dt) {
    const Rate a = rate_of(s, gravity), b = rate_of(moved(s, a, dt / 2), gravity);
    const Rate c = rate_of(moved(s, b, dt / 2), gravity), d = rate_of(moved(s, c, dt), gravity);
    return moved(moved(moved(moved(s, a, dt / 6), b, dt / 3), c, dt / 3), d, dt / 6);
}

/// The second derivatives of the natural cubic spline through y at s (Thomas' algorithm).
std::vector<double> spline(const std::vector<double>& s, const std::vector<double>& y) {
    const std::size_t n = s.size();
    std::vector<double> diagonal(n, 1), right(n, 0), second(n, 0);
    for (std::size_t i = 1; i + 1 < n; ++i) {
        const double before = s[i] - s[i - 1], after = s[i + 1] - s[i], w = i > 1 ? before / diagonal[i - 1] : 0;
        diagonal[i] = 2 * (before + after) - w * before;
        right[i] = 6 * ((y[i + 1] - y[i]) / after - (y[i] - y[i - 1]) / before) - w * right[i - 1];
    }
    for (std::size_t i = n - 2; i > 0; --i) second[i] = (right[i] - (s[i + 1] - s[i]) * second[i + 1]) / diagonal[i];
    return second;
}

double interpolate(const std::vector<double>& s, const std::vector<double>& y, const std::vector<double>& second,
                   double at) {
    const auto above = static_cast<std::size_t>(std::ranges::upper_bound(s, at) - s.begin());
    const std::size_t i = std::clamp<std::size_t>(above, 1, s.size() - 1) - 1;
    const double h = s[i + 1] - s[i], a = (s[i + 1] - at) / h, b = 1 - a;
    return a * y[i] + b * y[i + 1] + ((a * a * a - a) * second[i] + (b * b * b - b) * second[i + 1]) * h * h / 6;
}

/// The same surface with `nodes` nodes, whose distances shrink by a factor of eight from the wall to the toe.
Surface redistributed(const Surface& s, std::size_t nodes) {
    std::vector<double> length(s.size(), 0), x, z;
    for (std::size_t i = 0; i < s.size(); ++i) {
        if (i > 0) length[i] = length[i - 1] + (s.x[i] - s.x[i - 1]).norm();
        x.push_back(s.x[i].x());
        z.push_back(s.x[i].y());
    }
    const std::vector<double> x2 = spline(length, x), z2 = spline(length, z), phi2 = spline(length, s.phi);
    Surface even;
    for (std::size_t i = 0; i < nodes; ++i) {
        const double part = static_cast<double>(i) / static_cast<double>(nodes - 1);
        const double at = length.back() * std::min(1.0, (1 - std::pow(8.0, -part)) / (1 - 1.0 / 8));
        even.x.emplace_back(interpolate(length, x, x2, at), std::max(0.0, interpolate(length, z, z2, at)));
        even.phi.push_back(interpolate(length, s.phi, phi2, at));
    }
    even.x.front().x() = 0;
    even.x.back().y() = 0;
    return even;
}

/// Top, rounded corner and side of the column, at rest.
Surface at_rest(const Column& column, std::size_t nodes) {
    constexpr int kPieces = 400;  // of the arc, far below any node distance
    const double r = 0.03 * column.height;
    Surface s;
    const auto line = [&](const Vec2d& from, const Vec2d& to) {
        for (int i = 0; i < kPieces; ++i) s.x.push_back(from + (to - from) * i / kPieces);
    };
    line({0, column.height}, {column.width - r, column.height});
    for (int i = 0; i < kPieces; ++i) {
        const double a = kPi / 2 * i / kPieces;
        s.x.emplace_back(column.width - r + r * std::sin(a), column.height - r + r * std::cos(a));
    }
    line({column.width, column.height - r}, {column.width, 0});
    s.x.emplace_back(column.width, 0);
    s.phi.assign(s.x.size(), 0);
    return redistributed(s, nodes);
}

/// The place beyond which the outermost `share` of the fluid lies.
double front_of(const Surface& s, double share, double area) {
    double beyond = 0;
    for (std::size_t i = s.size() - 1; i > 0; --i) {
        const Vec2d step = s.x[i] - s.x[i - 1];
        const double piece = 0.5 * step.x() * (s.x[i].y() + s.x[i - 1].y());
        if (beyond + piece >= share * area) return s.x[i].x() - (share * area - beyond) / piece * step.x();
        beyond += piece;
    }
    return 0;
}

State state_of(const Surface& s, const Column& column, double time, double energy_at_start) {
    const std::vector<double> normal = normal_velocity(s);
    double area = 0, potential = 0, kinetic = 0;
    for (std::size_t i = 0; i + 1 < s.size(); ++i) {
        const Vec2d step = s.x[i + 1] - s.x[i];
        const double z = s.x[i].y(), z1 = s.x[i + 1].y();
        area += 0.5 * step.x() * (z + z1);
        potential += column.gravity * step.x() * (z * z + z * z1 + z1 * z1) / 6;
        kinetic += 0.25 * step.norm() * (s.phi[i] * normal[i] + s.phi[i + 1] * normal[i + 1]);
    }
    return {time, s.x.back().x(), front_of(s, 1e-3, area), area, (potential + kinetic) / energy_at_start};
}

}  // namespace

std::vector<State> collapse(const Column& column, double until, double step, int nodes) {
    constexpr int kBetween = 5;  // steps between redistributions: nodes gather where the flow converges
    Surface s = at_rest(column, static_cast<std::size_t>(nodes));
    const double start = state_of(s, column, 0, 1).energy;
    std::vector<State> states{state_of(s, column, 0, start)};
    const int steps = static_cast<int>(std::lround(until / step));
    for (int k = 1; k <= steps; ++k) {
        s = advanced(s, column.gravity, step);
        if (k % kBetween == 0) s = redistributed(s, static_cast<std::size_t>(nodes));
        states.push_back(state_of(s, column, k * step, start));
    }
    return states;
}

}  // namespace thixo::potential_flow
