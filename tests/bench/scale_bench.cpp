// Blended surfels from ten thousand to ten million: time to make them ready, memory, and rays. Then half a million
// surfels of one radius, and as many with radii over five orders of magnitude. Each cloud has a process of its own.
// `scale_bench 1e6` stops at a million.
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

/// Nanoseconds a ray, the best of three turns.
template <class Meet>
double best_ns(const std::vector<Ray>& rays, Meet&& meet) {
    double best = 1e30;
    for (int turn = 0; turn < 3; ++turn) {
        std::size_t hits = 0;
        best = std::min(best, seconds_of(rays, meet, hits));
    }
    return 1e9 * best / double(rays.size());
}
double blended_ns(const RayScene& scene, const std::vector<Ray>& rays) {
    return best_ns(rays, [&](const Ray& ray) {
        Hit hit;
        return scene.intersect(ray, {}, hit);
    });
}
double native_ns(const NativeDiscs& discs, const std::vector<Ray>& rays) {
    return best_ns(rays, [&](const Ray& ray) {
        float t;
        return discs.intersect(ray.origin, ray.direction, t);
    });
}

void size(std::size_t n) {
    const std::vector<Ray> primary = primary_rays(kRays), crossing = crossing_rays(kRays);
    const double before = resident_bytes();
    // With the attributes of a cache: m0, velocity, temperature.
    SurfelSet set = shapes::one_object(shapes::sphere(n, 1, Vec3f::Zero(), 0.2f));
    set.cloud.normal = std::vector<Vec3f>();
    set.rest = set.velocity = set.cloud.position;
    set.temperature.assign(n, 20);
    const double begin = wall_seconds();
    const RayScene scene(std::move(set), {});
    const double ready = wall_seconds() - begin;
    const double memory = resident_bytes() - before;
    const double coherent = blended_ns(scene, primary), incoherent = blended_ns(scene, crossing);
    const NativeDiscs native(shapes::sphere(n, 1, Vec3f::Zero(), 0.2f));
    fmt::print(
        "{:>9} surfels: ready in {:>7.1f} ms, {:>4.0f} bytes each; ray {:>5.0f} ns primary (discs {:>4.0f}), {:>5.0f} "
        "ns "
        "crossing (discs {:>4.0f})\n",
        n, 1e3 * ready, memory / double(n), coherent, native_ns(native, primary), incoherent,
        native_ns(native, crossing));
}

/// Half a million surfels in a plane, of one radius or of radii from 1e-5 m to 1 m.
void plane(bool graded) {
    const SurfelCloud cloud = graded ? shapes::graded_plane(500000) : shapes::even_plane(707);
    const std::vector<Ray> rays = shapes::rays_down(kRays, graded);
    const double begin = wall_seconds();
    const RayScene scene(shapes::one_object(cloud), {});
    const double ready = wall_seconds() - begin;
    const NativeDiscs native(cloud);
    fmt::print("{:>9} surfels of {}: ready in {:.1f} ms; ray {:.0f} ns (discs {:.0f})\n", cloud.size(),
               graded ? "radii from 1e-5 to 1" : "one radius", 1e3 * ready, blended_ns(scene, rays),
               native_ns(native, rays));
}

}  // namespace

int main(int argc, char** argv) {
    const double last = argc > 1 ? std::atof(argv[1]) : 1e7;
    for (double n = 1e4; n <= last * 1.001; n *= 10) run_apart([&] { size(std::size_t(n)); });
    run_apart([] { plane(false); });
    run_apart([] { plane(true); });
}
