// Measurements that the scene asks for while it runs (block `probes`), written to probes.csv.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "sim/loop/simulation.h"

namespace thixo {

/// `particles` are those at the start, among which probes choose whom they follow. Throws InputError where a region's
/// shape is bad.
Probes make_probes(const scene::Scene& scene, const Particles& particles);

/// The value of every probe at the present time, in the order of the scene; none where there is no mass to measure.
/// Requires evaluate() at this time. Ends the interval of what probes count.
///     point   sum_j V_j a_j w(x - x_j) / sum_j V_j w(x - x_j)         (CSPM, dissertation 2.24)
///     mean    sum m a / sum m,   total  sum m a   over particles in the region, in double
///     extent  coordinate along the direction that the given share of the mass does not exceed [m]
///     flux    mass a second [kg/s]
///     wall_force, wall_pressure    of the pressure of liquids on walls [N], [Pa]
///     follow  a of one particle
/// Counts and areas are those of the solids' tables.
std::vector<std::optional<double>> measure(Simulation& sim);

/// probes.csv has a line a frame: `frame,time` and one column a probe; an empty cell is no value. Where a run continues
/// from `frame`, later lines are dropped. A scene without probes has no such file. Throws ResourceError.
void begin_probe_file(const std::filesystem::path& out, const Simulation& sim, int frame);
void append_probes(const std::filesystem::path& out, Simulation& sim);

}  // namespace thixo
