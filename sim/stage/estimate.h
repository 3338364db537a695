// What a run will need, and what it will not be able to do, before its first step.
#pragma once

#include <vector>

#include "pipeline/contract/shortfall.h"
#include "sim/loop/simulation.h"

namespace thixo {

/// The size of a scene at its end. Particles are those of bodies, counted, and those that emitters release by the last
/// frame. Surfels are those on solids at the start. Where cracks will run, and how often, is not known before.
/// `cut` are the surfels on both faces of one cut through each body that can break. It is the least section across its
/// longest side, or what is painted where that is larger. `shattered` are those of cracks that lie everywhere as near to
/// each other as fronts can run.
struct Size {
    double particles = 0, surfels = 0;
    double cut = 0, shattered = 0;
};
/// Of a simulation at its first frame.
Size final_size(const scene::Scene& scene, const Simulation& at_start);
/// Memory of a simulation of this size [bytes].
double memory_of(const Size& size);

struct Estimate {
    Size size;                          // surfels by the area of solids, to a quarter
    std::vector<Shortfall> shortfalls;  // expect_shortfalls
};
/// For `--estimate`. Nothing is simulated and no surface is sampled. Throws InputError.
Estimate estimate_run(const scene::Scene& scene);

}  // namespace thixo
