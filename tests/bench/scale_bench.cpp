// Blended surfels from ten thousand to ten million: time to make ready, memory, rays; then the same number with radii over
// five orders of magnitude. Each cloud in a process of its own. `scale_bench 1e6` stops at a million.
#include <fmt/core.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <functional>

#include "pipeline/base/timer.h"
#include "tests/bench/native_discs.h"
#include "tests/bench/ray_sets.h"

namespace {

using namespace thixo;
using namespace thixo::bench;
using render::Hit;
using render::RayScene;
using render::SurfelSet;

constexpr int kRays = 1 << 16;

double resident_bytes() {
    std::ifstream file("/proc/self/statm");
    std::size_t size = 0, resident = 0;
    file >> size >> resident;
    return double(resident) * double(sysconf(_SC_PAGESIZE));
}

void run_apart(const std::function<void()>& work) {
    std::fflush(stdout);
    const pid_t child = fork();
    if (child == 0) {
        work();
        std::fflush(stdout);
        _exit(0);
    }
    int status = 1;
    if (child < 0 || waitpid(child, &status, 0) != child || status != 0) {
        fmt::print(stderr, "scale_bench: a run failed\n");
        std::exit(1);
    }
}

double blended_ns(const RayScene& scene, const std::vector<Ray>& rays) {
    double best = 1e30;
    for (int turn = 0; turn < 3; ++turn) {
        std::size_t hits = 0;
        best = std::min(best, seconds_of(
                                  rays,
                                  [&](const Ray& ray) {
                                      Hit hit;
                                      return scene.intersect(ray, {}, hit);
                                  },
                                  hits));
    }
    return 1e9 * best / double(rays.size());
}
double native_ns(const NativeDiscs& discs, const std::vector<Ray>& rays) {
    double best = 1e30;
    for (int turn = 0; turn < 3; ++turn) {
        std::size_t hits = 0;
        best = std::min(best, seconds_of(
                                  rays,
                                  [&](const Ray& ray) {
                                      float t;
                                      return discs.intersect(ray.origin, ray.direction, t);
                                  },
                                  hits));
    }
    return 1e9 * best / double(rays.size());
}

void size(std::size_t n) {
    const std::vector<Ray> primary = primary_rays(kRays), crossing = crossing_rays(kRays);
    const double before = resident_bytes();
    // With what a cache gives: m0, velocity, temperature.
    SurfelSet set = shapes::one_object(shapes::sphere(n, 1, Vec3f::Zero(), 0.2f));
    set.cloud.normal = {};
    set.rest = set.velocity = set.cloud.position;
    set.temperature.assign(n, 20);
    const double begin = wall_seconds();
    const RayScene scene(std::move(set), {});
    const double ready = wall_seconds() - begin;
    const double memory = resident_bytes() - before;
    const double coherent = blended_ns(scene, primary), incoherent = blended_ns(scene, crossing);
    const NativeDiscs native(shapes::sphere(n, 1, Vec3f::Zero(), 0.2f));
    fmt::print("{:>9} surfels: ready in {:>7.1f} ms, {:>4.0f} bytes each; ray {:>5.0f} ns primary (discs {:>4.0f}), {:>5.0f} ns "
               "crossing (discs {:>4.0f})\n",
               n, 1e3 * ready, memory / double(n), coherent, native_ns(native, primary), incoherent,
               native_ns(native, crossing));
}

/// A plane whose surfels have `slope` times their distance from the origin as radius, from 1e-5 m to 1 m; slope 0: all
/// alike. Rays come down on it, as many to each ring.
void graded(float slope) {
    const std::size_t n = 500000;
    SurfelCloud cloud;
    std::vector<Vec3f> targets;
    if (slope > 0) {
        // Rings that grow by a constant factor: n surfels in all.
        const double rings = std::sqrt(double(n) * std::log(1e5) / (2 * kPi)), per_ring = double(n) / rings;
        const double growth = std::pow(1e5, 1 / rings);
        for (int ring = 0; ring < int(rings); ++ring) {
            const double radius = 1e-5 / double(slope) * std::pow(growth, ring);
            for (int i = 0; i < int(per_ring); ++i) {
                const double a = 2 * kPi * (i + 0.5 * (ring & 1)) / per_ring;
                shapes::add_disc(cloud, Vec3d(radius * std::cos(a), radius * std::sin(a), 0).cast<float>(), {0, 0, 1},
                                 float(1.2 * radius * (growth - 1)));
            }
        }
        for (std::uint64_t i = 0; i < kRays; ++i) {
            const double radius = 2e-5 / double(slope) * std::pow(5e4, random_unit(3, i, 0, 0)), a = 2 * kPi * random_unit(3, i, 0, 1);
            targets.push_back(Vec3d(radius * std::cos(a), radius * std::sin(a), 0).cast<float>());
        }
    } else {
        const int side = 707;
        for (int k = 0; k < side * side; ++k)
            shapes::add_disc(cloud, {float(k % side) / float(side) - 0.5f, float(k / side) / float(side) - 0.5f, 0}, {0, 0, 1},
                             1.2f / float(side));
        for (std::uint64_t i = 0; i < kRays; ++i)
            targets.push_back({0.9f * float(random_unit(3, i, 0, 0) - 0.5), 0.9f * float(random_unit(3, i, 0, 1) - 0.5), 0});
    }
    std::vector<Ray> rays;
    for (std::uint64_t i = 0; i < targets.size(); ++i) {
        const Vec3f down = Vec3f(float(random_unit(3, i, 1, 0)) - 0.5f, float(random_unit(3, i, 1, 1)) - 0.5f, -1).normalized();
        rays.push_back({targets[i] - (0.1f + targets[i].norm()) * down, down});
    }
    const double begin = wall_seconds();
    const RayScene scene(shapes::one_object(cloud), {});
    const double ready = wall_seconds() - begin;
    const NativeDiscs native(cloud);
    fmt::print("{:>9} surfels of {}: ready in {:.1f} ms; ray {:.0f} ns (discs {:.0f})\n", cloud.size(),
               slope > 0 ? "radii from 1e-5 to 1" : "one radius", 1e3 * ready, blended_ns(scene, rays), native_ns(native, rays));
}

}  // namespace

int main(int argc, char** argv) {
    const double last = argc > 1 ? std::atof(argv[1]) : 1e7;
    for (double n = 1e4; n <= last * 1.001; n *= 10) run_apart([&] { size(std::size_t(n)); });
    run_apart([] { graded(0); });
    run_apart([] { graded(0.02f); });
}
