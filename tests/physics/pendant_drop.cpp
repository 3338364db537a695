#include "tests/physics/pendant_drop.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/physics/gate.h"

namespace thixo::pendant {
namespace {

using State = Eigen::Vector4d;  // r, z [m], phi [1], volume [m^3]

State slope(const State& s, const Drop& drop) {
    const double r = s[0], z = s[1], phi = s[2];
    const double across = r > 0 ? std::sin(phi) / r : 1 / drop.radius;
    const double along = 2 / drop.radius - z / (drop.capillary_length * drop.capillary_length) - across;
    return {std::cos(phi), std::sin(phi), along, std::numbers::pi * r * r * std::sin(phi)};
}

State stepped(const State& s, double ds, const Drop& drop) {
    const State a = slope(s, drop), b = slope(s + ds / 2 * a, drop), c = slope(s + ds / 2 * b, drop),
                d = slope(s + ds * c, drop);
    return s + ds / 6 * (a + 2 * b + 2 * c + d);
}

/// Volumes below levels an eighth of a spacing apart. The particles are smeared over their spacing.
std::vector<Below> volumes_of(const Simulation& s, double from, double to) {
    const double d = static_cast<double>(s.problem.smoothing.spacing);
    std::vector<Below> out;
    for (double z = from; z <= to; z += d / 8) {
        double sum = 0;
        for (std::size_t i = 0; i < s.particles.size(); ++i)
            sum += static_cast<double>(s.particles.mass[i]) / 1000 *
                   std::clamp((z - static_cast<double>(s.particles.position[i].z())) / d + 0.5, 0.0, 1.0);
        out.push_back({z, sum});
    }
    return out;
}

double lowest(const Simulation& s) {
    double z = 0;
    for (const Vec3& x : s.particles.position) z = std::min(z, static_cast<double>(x.z()));
    return z - static_cast<double>(s.problem.smoothing.spacing) / 2;
}

}  // namespace

std::vector<Below> volumes(const Drop& drop, const std::vector<double>& heights) {
    constexpr int kSteps = 400, kRadii = 8;  // a drop's meridian is a few radii long
    const double ds = kRadii * drop.radius / kSteps;
    std::vector<Below> out;
    State before(0, 0, 0, 0), now = before;
    int steps = 0;
    for (const double height : heights) {
        const double z = height - drop.bottom;
        while (now[1] < z && steps < kSteps && now[2] < std::numbers::pi && now[0] >= 0) {
            before = now;
            now = stepped(now, ds, drop);
            ++steps;
        }
        const double part = now[1] > before[1] ? (z - before[1]) / (now[1] - before[1]) : 1;
        out.push_back({height, z <= 0 ? 0 : before[3] + std::min(part, 1.0) * (now[3] - before[3])});
    }
    return out;
}

Drop fit(const std::vector<Below>& measured, const Drop& guess) {
    std::vector<double> heights;
    for (const Below& m : measured) heights.push_back(m.height);
    const auto n = static_cast<Eigen::Index>(measured.size());
    const auto misfit = [&](const Eigen::Vector3d& p) {
        const std::vector<Below> model = volumes({p[0], p[1], p[2]}, heights);
        Eigen::VectorXd off(n);
        for (Eigen::Index k = 0; k < n; ++k)
            off[k] = model[static_cast<std::size_t>(k)].volume - measured[static_cast<std::size_t>(k)].volume;
        return off;
    };
    Eigen::Vector3d best(guess.bottom, guess.radius, guess.capillary_length);
    Eigen::VectorXd off = misfit(best);
    double damping = 1e-3;
    for (int k = 0; k < 200; ++k) {
        Eigen::MatrixXd jacobian(n, 3);
        for (int a = 0; a < 3; ++a) {
            const double by = 1e-5 * guess.radius;
            jacobian.col(a) = (misfit(best + by * Eigen::Vector3d::Unit(a)) - off) / by;
        }
        Eigen::Matrix3d normal = jacobian.transpose() * jacobian;
        normal.diagonal() *= 1 + damping;
        const Eigen::Vector3d next = best - normal.ldlt().solve(jacobian.transpose() * off);
        if (const Eigen::VectorXd there = misfit(next); next[1] > 0 && next[2] > 0 && there.norm() < off.norm()) {
            best = next;
            off = there;
            damping /= 3;
        } else {
            damping *= 4;
        }
    }
    return {best[0], best[1], best[2]};
}

Hanging hang(const std::vector<std::string>& set) {
    constexpr int kSettled = 40;  // frames: its swings have faded by exp(-30)
    Simulation s = make_simulation(gate::load("pendant_drop", set));
    while (s.clock.frame < kSettled) advance_frame(s);
    const double d = static_cast<double>(s.problem.smoothing.spacing), bottom = lowest(s);
    std::vector<Below> mean = volumes_of(s, bottom - d, -2 * d);
    int frames = 1;
    for (; s.clock.frame < s.problem.scene.frames.last; ++frames) {
        advance_frame(s);
        const std::vector<Below> now = volumes_of(s, bottom - d, -2 * d);
        for (std::size_t k = 0; k < mean.size(); ++k) mean[k].volume += now[k].volume;
    }
    std::vector<double> heights;
    for (Below& m : mean) {
        m.volume /= frames;
        heights.push_back(m.height);
    }
    Hanging out{.drop = fit(mean, {bottom, 0.1, 0.15})};
    const std::vector<Below> model = volumes(out.drop, heights);
    for (std::size_t k = 0; k < mean.size(); ++k)
        out.misfit = std::max(out.misfit, std::abs(model[k].volume - mean[k].volume) / mean.back().volume);
    const scene::Material& liquid = s.problem.scene.materials.front();
    out.tension = liquid.density * s.problem.scene.world.gravity.norm() * square(out.drop.capillary_length) /
                  liquid.surface_tension;
    return out;
}

}  // namespace thixo::pendant
