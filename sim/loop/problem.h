// What a run is given.
#pragma once

#include <string>
#include <vector>

#include "pipeline/contract/scene.h"
#include "sim/external/outside.h"
#include "sim/heat/heat.h"
#include "sim/liquid/tension.h"
#include "sim/sources/emitter.h"
#include "sim/space/periodic.h"
#include "sim/space/smoothing.h"
#include "sim/state/materials.h"
#include "sim/state/strategy.h"
#include "sim/surface/mould.h"

namespace thixo {

/// What does not change during a run.
struct Problem {
    scene::Scene scene;
    Strategy strategy;
    std::string replay;  // words behind `thixo sim` that give this run again, for messages; empty: the scene's name
    Smoothing smoothing;
    TensionScale tension;
    Materials materials;
    HeatDrive heat;
    std::vector<Mould> moulds;
    Outside outside;
    Periodic periodic;
    double expected_speed = 0;            // U [m/s]
    std::vector<EmitterLayout> emitters;  // one per scene emitter
};

}  // namespace thixo
