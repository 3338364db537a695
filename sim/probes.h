// What the scene asks to be measured while it runs (block `probes`), written to probes.csv.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/contract/scene.h"
#include "pipeline/geometry/shape.h"
#include "sim/particles.h"
#include "sim/periodic.h"

namespace thixo {

struct Simulation;

/// The scene's probes with their shapes built, and what passed the flux probes since the last frame.
struct Probes {
    struct Entry {
        scene::Probe probe;
        std::int32_t material = -1;  // index; -1: all
        std::optional<Shape> region;
    };
    std::vector<Entry> list;
    std::vector<double> passed;  // mass through each flux probe since the last frame, forward minus backward [kg]
    std::vector<Vec3> before;    // positions at the beginning of the step; empty where no probe needs them [m]
    bool needs_paths() const;
};

/// Throws InputError where a region's shape is bad.
Probes make_probes(const scene::Scene& scene);

/// Call around what moves the particles, in the same order of particles: mass whose path of this step crosses a disc is
/// counted there; through a periodic face it goes on at the other side.
void note_positions(Probes& probes, const Particles& particles);
void count_passages(Probes& probes, const Particles& particles, const Periodic& periodic);

/// The value of every probe at the present time, in the order of the scene; nothing where there is no mass to measure.
/// Requires evaluate() at this time. Ends the interval of the flux probes.
///   point   sum_j V_j a_j w(x - x_j) / sum_j V_j w(x - x_j)         (CSPM, dissertation 2.24)
///   mean    sum m a / sum m,   total  sum m a   over particles in the region, in double
///   extent  coordinate along the direction that the given share of the mass does not exceed [m]
///   flux    mass a second [kg/s]
std::vector<std::optional<double>> measure(Simulation& s);

/// probes.csv: a line a frame, `frame,time` and one column a probe; an empty cell is no value. Where a run goes on from
/// `frame`, later lines are dropped. Nothing is written for a scene without probes. Throws ResourceError.
void begin_probe_file(const std::filesystem::path& out, const Simulation& s, int frame);
void append_probes(const std::filesystem::path& out, Simulation& s);

}  // namespace thixo
