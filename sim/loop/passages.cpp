#include "sim/loop/passages.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/parallel.h"

namespace thixo {
namespace {

using scene::Measure;

/// +1 where the path crosses the disc forwards, -1 backwards, 0 where it does not.
int crossing(const scene::Probe& disc, const Vec3d& from, const Vec3d& to) {
    const Vec3d n = disc.direction.normalized();
    const double a = n.dot(from - disc.position), b = n.dot(to - disc.position);
    if ((a < 0) == (b < 0)) return 0;
    const Vec3d at = from + a / (a - b) * (to - from) - disc.position;
    return (at - n * n.dot(at)).norm() <= disc.radius ? (a < 0 ? 1 : -1) : 0;
}

bool counts_pushes(const scene::Probe& p) {
    return p.measure == Measure::wall_force || p.measure == Measure::wall_pressure;
}

/// How much of a particle's push on walls counts.
double share_of_push(const Probes::Entry& e, const Particles& particles, std::size_t i, double support) {
    if (e.material >= 0 && particles.material[i] != e.material) return 0;
    if (e.probe.measure == Measure::wall_force) return !e.region || e.region->distance(particles.position[i]) <= 0;
    const Vec3d n = e.probe.direction.normalized(), off = particles.position[i].cast<double>() - e.probe.position;
    const double height = n.dot(off), within = e.probe.radius - (off - height * n).norm();
    return std::abs(height) <= support ? std::clamp(0.5 + within / support, 0.0, 1.0) : 0;
}

}  // namespace

bool Probes::needs_paths() const {
    return std::any_of(list.begin(), list.end(), [](const Entry& e) { return e.probe.measure == Measure::flux; });
}

bool Probes::needs_pushes() const {
    return std::any_of(list.begin(), list.end(), [](const Entry& e) { return counts_pushes(e.probe); });
}

void count_pushes(Probes& probes, const Particles& particles, const std::function<Vec3(std::size_t)>& push,
                  Real support) {
    for (std::size_t k = 0; k < probes.list.size(); ++k) {
        const Probes::Entry& e = probes.list[k];
        if (!counts_pushes(e.probe)) continue;
        const Vec3d n = e.probe.direction.normalized();
        probes.counted[k] += parallel_sum(particles.size(), [&](std::size_t i) {
            const Vec3d p = push(i).cast<double>();
            return p.isZero(0) ? 0.0 : share_of_push(e, particles, i, static_cast<double>(support)) * n.dot(p);
        });
    }
}

double pressed_area(double radius, double support) {
    const double end = radius + support / 2;  // where the share is 0
    return radius >= support / 2 ? kPi * (square(radius) + square(support) / 12) : kPi * cube(end) / (3 * support);
}

void note_positions(Probes& probes, const Particles& particles) {
    if (probes.needs_paths()) probes.before = particles.position;
}

void count_passages(Probes& probes, const Particles& particles, const Periodic& periodic) {
    for (std::size_t k = 0; k < probes.list.size(); ++k) {
        const Probes::Entry& e = probes.list[k];
        if (e.probe.measure != Measure::flux) continue;
        probes.counted[k] += parallel_sum(particles.size(), [&](std::size_t i) {
            const Vec3 &from = probes.before[i], &to = particles.position[i];
            if (e.material >= 0 && particles.material[i] != e.material) return 0.0;
            const auto passed = [&](const Vec3& a, const Vec3& b) {
                return crossing(e.probe, a.cast<double>(), b.cast<double>());
            };
            // A path through a periodic face has two parts: the way out, and the way in at the other side.
            const Vec3 out = periodic.nearest_image(to, from);
            const int count = out == to ? passed(from, to) : passed(from, out) + passed(from + to - out, to);
            return static_cast<double>(particles.mass[i]) * count;
        });
    }
}

}  // namespace thixo
