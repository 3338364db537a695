// What the discs of surfels look like where their sheets end.
#pragma once

#include "sim/surface/liquid_shape.h"
#include "sim/surface/resample.h"

namespace thixo {

/// Takes surfels back that are nearer than kFromCrease radii to the crease where their sheet ends, by half a spacing at
/// most: shortened where they are, their discs would be slivers with a gap behind them. Before gaps are filled, which
/// this opens. `support` h_s [m].
void retreat_from_creases(SurfelCloud& cloud, SurfelNotes& notes, const LiquidShape& shape, Real support);

/// Axes of length r_s in the planes of the normals, the first as near to its old direction as can be. At a crease the
/// disc ends a little beyond it, or it would stand out of the body: the first axis then leads to the crease and is
/// shortened. Coats of two walls cross each other inside the walls and need no shortening; surfels that were pushed
/// over their crease come back to it. Fills notes.give. Surfels of solid matter keep theirs.
void fit_axes(SurfelCloud& cloud, SurfelNotes& notes, const LiquidShape& shape, Real support);

}  // namespace thixo
