// The faces of cracks: surfels on the sheets that fronts have left behind. Dissertation 5.6.3.
#pragma once

#include "sim/fracture/fragments.h"
#include "sim/fracture/sight.h"

namespace thixo {

/// Lays surfels on both sides of triangles that have none yet, and binds them. A surfel of a sheet belongs to the body of
/// the nearest element that it sees. Scenes without surfels have none.
///
/// A triangle is parted into smaller ones, of about the size of the body's surfels. Each gets a round disc about its
/// middle that reaches its corners: sheets have no holes.
void lay_sheets(const CrackSight& sight, const Matter& matter);

/// The same. Besides, it finds the weights of all surfels anew that fronts have passed since the last call. It comes
/// before surfels are looked at, or a checkpoint is written.
void refresh_sheets(const CrackSight& sight, const Matter& matter);

/// What sight a binding of surfels needs: none where nothing is cracked.
ElementSight element_sight(const CrackSight& sight);

/// The area of all cracks within their bodies, one side of each, in the material frames [m^2].
double area_of_sheets(const Solids& solids);

}  // namespace thixo
