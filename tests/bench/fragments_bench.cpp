// What breaking costs. Ratios are to work of the same run, interleaved.
//     can_break/substeps  a beam of 13 000 particles, step by step beside one that can never break. No crack ever begins.
//                         0: implicit steps of 5 ms; else steps of so many explicit sub-steps
//       over_unbreakable  time of a step over that of the other beam's
//     fragments/n         steps of 1 ms of a bar that cracks part into n blocks of 64 particles, which push each other
//       us_per_fragment   time of a step, by fragment [us]
//       over_50           that over the time by fragment of 50
//       bodies            how many there are
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"
#include "pipeline/base/timer.h"
#include "sim/solid/stable_step.h"
#include "tests/bench/beam.h"

namespace {

using namespace thixo;

/// The beam, of matter that can break but does not.
Simulation beam(bool breaks, bool implicit) {
    scene::Scene scene = fixture::held_beam(13'000);
    if (breaks) scene.materials[0].fracture.strength = 1e12;
    if (implicit) scene.solver.solids = scene::SolidSteps::implicit_euler;
    return make_simulation(scene);
}

void can_break(benchmark::State& state) {
    set_thread_count(1);
    const bool implicit = state.range(0) == 0;
    Simulation brittle = beam(true, implicit), plain = beam(false, implicit);
    double dt = 5e-3;
    if (!implicit) {
        for (Simulation* s : {&brittle, &plain}) fixture::steps(*s, 1, 1e-3);
        dt = static_cast<double>(state.range(0)) * stable_sub_step(plain.solids, false);
    }
    for (Simulation* s : {&brittle, &plain}) fixture::steps(*s, 2, dt);
    double with = 0, without = 0;
    const auto timed = [&](Simulation& s, double& seconds) {
        const ScopedTimer timer(seconds);
        fixture::steps(s, 1, dt);
    };
    for (auto _ : state) {
        const double before = with;
        timed(brittle, with);
        timed(plain, without);
        state.SetIterationTime(with - before);
    }
    state.counters["over_unbreakable"] = with / without;
    state.counters["particles"] = static_cast<double>(brittle.particles.size());
}

/// A bar of n blocks of 4 x 4 x 4 particles. Cuts from its top to its bottom part it in the first steps.
Simulation parted_bar(int n) {
    constexpr double kSpacing = 0.01, kBlock = 4 * kSpacing, kHalf = kBlock / 2;
    scene::Scene scene = fixture::empty_space();
    scene.solver.spacing = kSpacing;
    scene.materials[0].elastic.youngs_modulus = 5e5;
    scene.materials[0].viscosity = 10;
    scene.materials[0].fracture.strength = 1e12;
    scene.surface.enabled = true;
    scene.bodies = {
        fixture::body("bar", fixture::shape_at({0, 0, 0}, scene::BoxShape{{n * kBlock, kBlock, kBlock}, 0}))};
    scene.bodies[0].surfels = 100 * n;
    for (int k = 1; k < n; ++k) {
        const double x = k * kBlock - n * kHalf + 0.1 * kSpacing;  // off the planes of the lattice
        scene.bodies[0].cracks.push_back(
            {.points = {{{x, -kHalf, kHalf}}, {{x, kHalf, kHalf}}}, .image = {}, .depth = 1.2 * kBlock});
    }
    Simulation s = make_simulation(scene);
    fixture::steps(s, 9, 1e-4);
    // Neighbours run against each other, so that all blocks push.
    for (std::size_t i = 0; i < s.solids.elements.size(); ++i) {
        const bool even = s.solids.elements.owner[i] % 2 == 0;
        s.solids.elements.velocity[i] = quad(Vec3(even ? Real(0.02) : Real(-0.02), 0, 0));
    }
    fixture::steps(s, 3, 1e-3);
    return s;
}

void fragments(benchmark::State& state) {
    set_thread_count(1);
    const int number = static_cast<int>(state.range(0));
    Simulation many = parted_bar(number), few = parted_bar(50);
    const auto bodies = static_cast<double>(many.solids.bodies.size()),
               of_few = static_cast<double>(few.solids.bodies.size());
    const int rounds = number / 50;  // so that both are measured equally well
    double with_many = 0, with_few = 0;
    const auto timed = [&](Simulation& s, double& seconds) {
        const ScopedTimer timer(seconds);
        fixture::steps(s, 1, 1e-3);
    };
    for (auto _ : state) {
        const double before = with_many;
        timed(many, with_many);
        for (int k = 0; k < rounds; ++k) timed(few, with_few);
        state.SetIterationTime(with_many - before);
    }
    const auto steps = static_cast<double>(state.iterations());
    state.counters["bodies"] = bodies;
    state.counters["nodes"] = static_cast<double>(many.solids.contacts.nodes.size()) / bodies;
    state.counters["us_per_fragment"] = 1e6 * with_many / (steps * bodies);
    state.counters["over_50"] = with_many / bodies / (with_few / (rounds * of_few));
}

BENCHMARK(can_break)->Arg(0)->Arg(8)->Arg(64)->Unit(benchmark::kMillisecond)->UseManualTime();
BENCHMARK(fragments)->Arg(50)->Arg(100)->Arg(200)->Iterations(5)->Unit(benchmark::kMillisecond)->UseManualTime();

}  // namespace
