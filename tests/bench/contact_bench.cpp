// Contact of two bodies, each of 390 particles and 10k surfels as in fig. 5.26 of the dissertation. Ratios are to work
// of the same bodies without contact in the same run, interleaved.
//     contact           steps of 5 ms while the bodies push each other
//       over_elastic    time of contact (finding nodes, penalty forces) over that of the elastic sub-steps
//       nodes           number of contact nodes
//     contact_surface   both surfaces with their contact surface
//       over_apart      time over that of the same surfaces apart
#include <benchmark/benchmark.h>

#include "pipeline/base/parallel.h"
#include "pipeline/base/timer.h"
#include "sim/surface/contact_surface.h"
#include "tests/sim/fixture.h"

namespace {

using namespace thixo;

Simulation two_balls(double apart) {
    scene::Scene scene = fixture::empty_space();
    scene.materials[0].elastic.youngs_modulus = 5e5;
    scene.materials[0].elastic.poisson_ratio = 0.33;
    scene.materials[0].viscosity = 100;
    scene.solver.spacing = std::cbrt(4 / 3.0 * kPi * cube(0.2) / 390);
    scene.surface.enabled = true;
    // Their weight pushes them together on a floor, so that they stay in contact.
    scene.world.gravity = {0, 0, -30};
    scene::Boundary floor;
    floor.name = "floor";
    floor.shape = fixture::shape_at({0, 0, -0.2}, scene::Plane{});
    scene.world.boundaries = {floor};
    scene.bodies = {fixture::body("lower", fixture::shape_at({0, 0, 0}, scene::Sphere{0.2})),
                    fixture::body("upper", fixture::shape_at({0, 0, 0.4 + apart}, scene::Sphere{0.2}))};
    for (scene::Body& b : scene.bodies) b.surfels = 10'000;
    return make_simulation(scene);
}

void contact(benchmark::State& state) {
    set_thread_count(static_cast<int>(state.range(0)));
    Simulation s = two_balls(0.001);
    fixture::steps(s, 30, 0.005);  // settled in the dent
    double elastic = 0, contacts = 0, nodes = 0;
    std::int64_t sub_steps = 0;
    for (auto _ : state) {
        s.stats = StepStats{};
        fixture::steps(s, 1, 0.005);
        contacts += s.stats.contact_seconds;
        elastic += s.stats.solids_seconds - s.stats.contact_seconds;
        sub_steps += s.stats.solid_sub_steps;
        nodes += static_cast<double>(s.solids.contacts.nodes.size());
        state.SetIterationTime(s.stats.solids_seconds);
    }
    const auto n = static_cast<double>(state.iterations());
    state.counters["particles"] = static_cast<double>(s.particles.size());
    state.counters["over_elastic"] = contacts / elastic;
    state.counters["sub_steps"] = static_cast<double>(sub_steps) / n;
    state.counters["nodes"] = nodes / n;
}

void contact_surface(benchmark::State& state) {
    set_thread_count(static_cast<int>(state.range(0)));
    Simulation s = two_balls(0.001), apart = two_balls(0.5);
    fixture::steps(s, 30, 0.005);
    fixture::steps(apart, 1, 0.005);
    double together = 0, alone = 0;
    for (auto _ : state) {
        double seconds = 0;
        {
            ScopedTimer timer(seconds);
            refresh_surface(s);
        }
        {
            ScopedTimer timer(alone);
            refresh_surface(apart);
        }
        together += seconds;
        state.SetIterationTime(seconds);
    }
    state.counters["surfels"] = static_cast<double>(s.surface.size());
    state.counters["over_apart"] = together / alone;
}

BENCHMARK(contact)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseManualTime();
BENCHMARK(contact_surface)->Arg(1)->Unit(benchmark::kMillisecond)->UseManualTime();

}  // namespace
