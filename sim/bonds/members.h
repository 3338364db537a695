// Elements that come, go, change places or move to another body in mid-run. The tables of solid matter follow, with
// every index that points at an element. Surfels and contact samples are bound to elements anew by sim/fracture.
#pragma once

#include <vector>

#include "sim/space/smoothing.h"
#include "sim/state/particles.h"
#include "sim/state/solids.h"

namespace thixo {

/// Adds an element to a body, all other fields zero and without bonds. Returns its index.
Index append_element(Elements& elements, std::int64_t particle, std::int32_t owner);

/// Bonds an element that has no bonds to all elements of its body within the mean of their supports, in both
/// directions. Measures the moments of all of them. Bases and visibility (1) follow.
void bond_element(Index element, Solids& solids);

/// Bonds elements that have been parted from others. `origin` holds, by element, the one that it was a part of; itself
/// for all others. Parts of two elements are bonded where these were, with the same visibility. Parts of one element are
/// bonded with each other. Bonds reach as far as the mean of the supports. Moments follow.
void bond_parts(const std::vector<Index>& origin, Solids& solids);

/// Keeps the elements `rows` (old indices, each at most once) in this order. Renumbers every index that points at an
/// element: bonds, bodies, handles, contact nodes, particles. Neighbourhoods that lose an element are measured anew.
/// A contact node that loses an element is removed. Contact samples must be made anew for bodies that lose elements.
void select_elements(const std::vector<Index>& rows, Solids& solids);

/// Drops all bonds between elements of different bodies, and measures the neighbourhoods that lose any.
void part_bonds(Elements& elements);

/// Chooses the elements that stand for a body. Bodies are sampled finest at the surface, and cells there are cut to all
/// sizes: a typical one has the size of the lattice's cells.
void choose_examples(const Elements& elements, const Smoothing& smoothing, SolidBody& body);

/// Notes which element a particle has.
void number_element(std::int64_t particle, Index element, Solids& solids);

/// Writes Solids::particle_of anew. It must be called after particles are sorted, added or removed.
void locate_particles(const Particles& particles, Solids& solids);

}  // namespace thixo
