// Elements that come, go, change places or move to another body in mid-run, with all that points at them in the tables
// of solid matter. What is bound to elements from outside (surfels, contact samples) is bound anew by sim/fracture.
#pragma once

#include <vector>

#include "sim/space/smoothing.h"
#include "sim/state/particles.h"
#include "sim/state/solids.h"

namespace thixo {

/// One more element of a body, all else zero and without bonds; returns its index.
Index append_element(Elements& elements, std::int64_t particle, std::int32_t owner);

/// Bonds an element that has none to all elements of its body within the mean of their supports, and these to it, and
/// measures the moments of all of them. Bases and visibility (1) follow.
void bond_element(Index element, Solids& solids);

/// Keeps the elements `rows` (old indices, each at most once) in this order, and renumbers every index that points at
/// an element: bonds, bodies, handles, contact nodes, particles. Neighbourhoods that lose an element are measured anew.
/// Contact nodes that lose one end. Contact samples must be made anew for bodies that lose elements.
void select_elements(const std::vector<Index>& rows, Solids& solids);

/// Drops all bonds between elements of different bodies, and measures the neighbourhoods that lose any.
void part_bonds(Elements& elements);

/// Chooses the elements that stand for a body: bodies are sampled finest at the surface; cells there are cut to all
/// sizes, of which a typical one is the lattice's.
void choose_examples(const Elements& elements, const Smoothing& smoothing, SolidBody& body);

/// Notes which element a particle has.
void number_element(std::int64_t particle, Index element, Solids& solids);

/// Writes Solids::particle_of anew. Call it when particles have been sorted, added or removed.
void locate_particles(const Particles& particles, Solids& solids);

}  // namespace thixo
