// Checks that a scene gives the same bits at any thread count, interrupted or not.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "pipeline/base/parallel.h"
#include "sim/loop/step.h"
#include "sim/stage/checkpoint.h"
#include "sim/stage/setup.h"
#include "tests/sim/fixture.h"

namespace thixo::fixture {

/// Runs the scene by 1, 2 and 3 threads: the states that `run(simulation)` leaves are the same.
template <class Run>
void expect_same_at_any_thread_count(const scene::Scene& scene, Run&& run) {
    std::string first;
    for (const int threads : {1, 2, 3}) {
        set_thread_count(threads);
        Simulation s = make_simulation(scene);
        run(s);
        const std::string state = print_checkpoint(s, "hash");
        if (first.empty()) first = state;
        EXPECT_TRUE(state == first) << threads << " threads";
    }
    set_thread_count(0);
}

/// Continues `whole` by `frames`, and a new simulation of its scene from its checkpoint. Both end in the same state.
inline void expect_resumes(Simulation& whole, int frames) {
    const std::string half = print_checkpoint(whole, "hash");
    Simulation resumed = make_simulation(whole.problem.scene);
    parse_checkpoint(half, "half", "hash", resumed);
    for (int k = 0; k < frames; ++k) {
        advance_frame(whole);
        advance_frame(resumed);
    }
    EXPECT_TRUE(print_checkpoint(whole, "hash") == print_checkpoint(resumed, "hash"));
}

/// What `act` does to a simulation in mid-run leads to the same state at any thread count, and after a resume.
template <class Act>
void expect_identity_after(const scene::Scene& scene, const Act& act) {
    expect_same_at_any_thread_count(scene, [&](Simulation& s) {
        fixture::steps(s, 3, 1e-3);
        act(s);
        fixture::steps(s, 20, 1e-3);
    });
    Simulation whole = make_simulation(scene);
    advance_frame(whole);
    act(whole);
    advance_frame(whole);
    expect_resumes(whole, 2);
}

}  // namespace thixo::fixture
