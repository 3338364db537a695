// Checks that a scene gives the same bits at any thread count, interrupted or not.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "pipeline/base/parallel.h"
#include "sim/loop/step.h"
#include "sim/stage/checkpoint.h"
#include "sim/stage/setup.h"

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

}  // namespace thixo::fixture
