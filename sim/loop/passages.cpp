#include "sim/loop/passages.h"

#include <algorithm>

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

}  // namespace

bool Probes::needs_paths() const {
    return std::any_of(list.begin(), list.end(), [](const Entry& e) { return e.probe.measure == Measure::flux; });
}

void note_positions(Probes& probes, const Particles& particles) {
    if (probes.needs_paths()) probes.before = particles.position;
}

void count_passages(Probes& probes, const Particles& particles, const Periodic& periodic) {
    for (std::size_t k = 0; k < probes.list.size(); ++k) {
        const Probes::Entry& e = probes.list[k];
        if (e.probe.measure != Measure::flux) continue;
        probes.passed[k] += parallel_sum(particles.size(), [&](std::size_t i) {
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
