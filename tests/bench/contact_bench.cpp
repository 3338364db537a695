// Contact of two bodies, each of 390 particles and 10k surfels as in fig. 5.26 of the dissertation, and of many small
// ones. Ratios are to work of the same bodies without contact in the same run, interleaved.
//     contact           steps of 5 ms while the bodies push each other
//       over_elastic    time of contact (finding nodes, penalty forces) over that of the elastic sub-steps
//       nodes           number of contact nodes
//     contact_surface   both surfaces with their contact surface
//       over_apart      time over that of the same surfaces apart
//     contact_of_many   steps of 1 ms of a block of small balls that touch their neighbours
//       us_per_body     time of contact of a step, by body [us]
//       over_30         that over the time by body of 30 balls
//       surface_us_per_body, surface_over_30    the same of the contact surface
//       nodes_per_body  contact nodes; a body inside the block has six neighbours, one at its corner three
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"
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

/// A block of nx x ny x nz balls of 33 particles each, a tenth of a particle's width apart. They move to and fro at
/// random, and touch all the time.
Simulation ball_block(int nx, int ny, int nz) {
    constexpr double kRadius = 0.02, kSpacing = 0.01, kPitch = 2 * kRadius + kSpacing / 10, kSpeed = 0.02;
    scene::Scene scene = fixture::empty_space();
    scene.solver.spacing = kSpacing;
    scene.materials[0].elastic.youngs_modulus = 5e5;
    scene.materials[0].viscosity = 10;
    scene.surface.enabled = true;
    std::uint64_t number = 0;
    const auto random = [&](std::uint64_t axis) { return 2 * random_unit(1, number, axis, 0x62616c6c) - 1; };
    for (int k = 0; k < nz; ++k)
        for (int j = 0; j < ny; ++j)
            for (int i = 0; i < nx; ++i, ++number) {
                scene::Body ball =
                    fixture::body(fmt::format("ball{}", number),
                                  fixture::shape_at({kPitch * i, kPitch * j, kPitch * k}, scene::Sphere{kRadius}));
                ball.velocity = kSpeed * Vec3d(random(0), random(1), random(2));
                ball.surfels = 100;
                scene.bodies.push_back(ball);
            }
    return make_simulation(scene);
}

/// Seconds of contact, and of the contact surface, of a step.
struct ContactSeconds {
    double forces = 0, surface = 0;
};
ContactSeconds contact_step(Simulation& s) {
    s.stats = StepStats{};
    fixture::steps(s, 1, 1e-3);
    displace_embedded(s.embedded, s.solids, s.surface, s.embedded_source);
    double surface = 0;
    {
        ScopedTimer timer(surface);
        draw_contacts(s.embedded, s.embedded_source, s.walls, s.solids, s.surface);
    }
    return {s.stats.contact_seconds, surface};
}

void contact_of_many(benchmark::State& state) {
    set_thread_count(1);
    const auto edge = [&](std::size_t axis) { return static_cast<int>(state.range(axis)); };
    Simulation many = ball_block(edge(0), edge(1), edge(2)), few = ball_block(5, 3, 2);
    const auto bodies = static_cast<double>(many.solids.bodies.size()), bodies_of_few = 30.0;
    // As many bodies in total, so that both are measured equally well. The first steps warm up.
    const int rounds = static_cast<int>(bodies / bodies_of_few);
    contact_step(many);
    contact_step(few);
    ContactSeconds of_many, of_few;
    const auto add = [](const ContactSeconds& more, ContactSeconds& sum) {
        sum.forces += more.forces;
        sum.surface += more.surface;
    };
    for (auto _ : state) {
        const ContactSeconds now = contact_step(many);
        add(now, of_many);
        for (int k = 0; k < rounds; ++k) add(contact_step(few), of_few);
        state.SetIterationTime(now.forces + now.surface);
    }
    const auto steps = static_cast<double>(state.iterations());
    const auto per_body = [&](double seconds) { return 1e6 * seconds / (steps * bodies); };
    const auto per_body_of_few = [&](double seconds) { return 1e6 * seconds / (steps * rounds * bodies_of_few); };
    state.counters["bodies"] = bodies;
    state.counters["particles"] = static_cast<double>(many.particles.size());
    state.counters["nodes_per_body"] = static_cast<double>(many.solids.contacts.nodes.size()) / bodies;
    state.counters["us_per_body"] = per_body(of_many.forces);
    state.counters["over_30"] = per_body(of_many.forces) / per_body_of_few(of_few.forces);
    state.counters["surface_us_per_body"] = per_body(of_many.surface);
    state.counters["surface_over_30"] = per_body(of_many.surface) / per_body_of_few(of_few.surface);
}

BENCHMARK(contact)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseManualTime();
BENCHMARK(contact_surface)->Arg(1)->Unit(benchmark::kMillisecond)->UseManualTime();
BENCHMARK(contact_of_many)
    ->Args({5, 3, 2})
    ->Args({10, 6, 5})
    ->Args({10, 10, 10})
    ->Iterations(5)
    ->Unit(benchmark::kMillisecond)
    ->UseManualTime();

}  // namespace
