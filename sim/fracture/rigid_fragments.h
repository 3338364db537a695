// Fragments that are too small to be elastic. Dissertation 5.9.1.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/fracture/fragments.h"

namespace thixo {

/// Fewer elements are no stable neighbourhood: a linear fit about a place asks for as many (element_fit.h).
inline constexpr std::size_t kFewestElastic = 8;
/// Strings and flakes of fewer elements are slack. A sheet of one layer of more is elastic in its plane.
inline constexpr std::size_t kFewestFlat = 32;

/// Makes rigid bodies of those marked by 1 that are too small to be elastic. They have fewer than kFewestElastic
/// elements, or fewer than kFewestFlat and none whose neighbours span space. So do pieces of rigid bodies. A body of which a handle holds a part stays elastic.
///
/// A rigid body keeps the shape that it has at that time. Stress in it has no force, and no crack begins in it. Elements
/// whose neighbours do not span space are split into four each (split_elements). So every body has an inertia about
/// every axis, and contact can turn it. Returns 1 for each body
/// that is rigid now.
std::vector<std::uint8_t> make_rigid(const std::vector<std::uint8_t>& bodies, const Matter& matter);

/// Splits elements into four, each with a quarter of mass and volume. The parts stand at the corners of a tetrahedron
/// about the element's place. Its radius is half of the element's width w, so that their moment of inertia is that of a
/// cube: m w^2/6. Mass, momentum and angular momentum stay. The first part is the element itself, the others are new,
/// with new particles. Parts have the element's support. Bonds follow (bond_parts). Surfels and contact samples have to
/// be bound anew.
void split_elements(const std::vector<Index>& which, const Matter& matter);

}  // namespace thixo
