// What probes count between frames: mass that passes discs, and the push of liquids on walls.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "pipeline/contract/scene.h"
#include "pipeline/geometry/shape.h"
#include "sim/space/periodic.h"
#include "sim/state/particles.h"

namespace thixo {

/// The scene's probes with their shapes built, and what they have counted since the last frame.
struct Probes {
    struct Entry {
        scene::Probe probe;
        std::int32_t material = -1;  // index; -1: all
        std::optional<Shape> region;
        std::int64_t followed = -1;  // id of the particle; -1: none
    };
    std::vector<Entry> list;
    // Mass through each disc, forward minus backward [kg], and each probe's push on walls [N s].
    std::vector<double> counted;
    double pressed = 0;        // the time in which walls were pressed [s]
    std::vector<Vec3> before;  // positions at the beginning of the step; empty where no probe needs them [m]
    bool needs_paths() const;
    bool needs_pushes() const;
};

/// These are called before and after particles move, in the same order of particles. Mass whose path of this step
/// crosses a disc is counted there. A path through a periodic face continues at the other side.
void note_positions(Probes& probes, const Particles& particles);
void count_passages(Probes& probes, const Particles& particles, const Periodic& periodic);

/// Adds a step's push of each particle on walls [N s]. A wall_pressure probe counts particles no farther than `support`
/// [m] from its disc. The share of those near the edge falls from 1 to 0 over that width. At a sharp edge it would tell
/// whether a particle more or fewer lies within.
void count_pushes(Probes& probes, const Particles& particles, const std::function<Vec3(std::size_t)>& push,
                  Real support);
/// The area over which wall_pressure is the mean: the integral of that share [m^2].
double pressed_area(double radius, double support);

}  // namespace thixo
