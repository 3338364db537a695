// The discs of surfels where their sheets end.
#pragma once

#include "sim/surface/liquid_shape.h"
#include "sim/surface/resample.h"

namespace thixo {

/// Moves surfels back that are nearer than kFromCrease radii to the crease where their sheet ends, by at most half a
/// spacing. If their discs were shortened in place, they would be slivers with a gap behind them. This opens gaps, and
/// must come before they are filled. Surfels at or past an edge where faces of partly molten solids meet are moved as
/// well. `support` h_s [m].
void retreat_from_creases(SurfelCloud& cloud, SurfelNotes& notes, const LiquidShape& shape, Real support);

/// Fits axes of length r_s in the planes of the normals, the first as near to its old direction as possible. At a
/// crease the first axis leads to it and is shortened. The disc then ends a little beyond it, and does not stand out of
/// the body. Coats of two walls cross each other inside the walls and need no shortening. Surfels that were pushed over
/// their crease return to it. Faces of partly molten matter still meet in edges, and discs end there (past_edge). Fills
/// notes.lift_share. Surfels of solid matter keep their axes.
void fit_axes(SurfelCloud& cloud, SurfelNotes& notes, const LiquidShape& shape, Real support);

/// Half-axis of a disc that ends at an edge of its body, at the distance `to`, both in radii. It reaches a little past
/// the edge: ellipses side by side must overlap there, not only touch it. In a `corner` two edges cut a disc short. An
/// ellipse as long as the distances would not cover the corner itself.
Real past_edge(Real to, bool corner);

}  // namespace thixo
