// Mass that passes the probes that measure flux, counted as particles move.
#pragma once

#include <optional>
#include <vector>

#include "pipeline/contract/scene.h"
#include "pipeline/geometry/shape.h"
#include "sim/space/periodic.h"
#include "sim/state/particles.h"

namespace thixo {

/// The scene's probes with their shapes built, and the mass that has passed the flux probes since the last frame.
struct Probes {
    struct Entry {
        scene::Probe probe;
        std::int32_t material = -1;  // index; -1: all
        std::optional<Shape> region;
        std::int64_t followed = -1;  // id of the particle; -1: none
    };
    std::vector<Entry> list;
    std::vector<double> passed;  // mass through each flux probe since the last frame, forward minus backward [kg]
    std::vector<Vec3> before;    // positions at the beginning of the step; empty where no probe needs them [m]
    bool needs_paths() const;
};

/// These are called before and after particles move, in the same order of particles. Mass whose path of this step
/// crosses a disc is counted there. A path through a periodic face continues at the other side.
void note_positions(Probes& probes, const Particles& particles);
void count_passages(Probes& probes, const Particles& particles, const Periodic& periodic);

}  // namespace thixo
