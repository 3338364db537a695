// Whether what a checkpoint holds can be a state of this scene. Its checksum tells damage. A file with the right checksum
// may still be made by others: lengths are checked against each other here, indices against what they count.
#pragma once

#include <string>

#include "sim/loop/simulation.h"

namespace thixo {

/// Each throws CacheError that names the file and the array. They are called in this order while a checkpoint is read.
/// What follows from a table is made as soon as the table is known. `at_start`: the solids as the scene makes them.

/// Clock and sources.
void check_clock(const Simulation& sim, const std::string& file);

/// Lengths, ids, materials and values of particles. Which bodies there are is not known yet.
void check_particles(const Simulation& sim, const std::string& file);

/// Bodies, handles, elements, bonds and surfels: all that `rebind` and the adoption of particles use. For scenes whose
/// bodies have split, or whose elements have come or gone.
void check_altered(const Simulation& sim, const Solids& at_start, const std::string& file);

/// The fronts and sheets of cracks, and the bonds that cross them.
void check_cracks(const Simulation& sim, const std::string& file);

/// The cuts that blades are making.
void check_blades(const Simulation& sim, const std::string& file);

/// Particles against bodies and elements, and the state of these.
void check_solids(const Simulation& sim, const std::string& file);

/// What the surfaces keep between updates.
void check_surfaces(const Simulation& sim, const std::string& file);

}  // namespace thixo
