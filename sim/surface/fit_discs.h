// What the discs of surfels look like where their sheets end.
#pragma once

#include "sim/surface/liquid_shape.h"
#include "sim/surface/resample.h"

namespace thixo {

/// Takes surfels back that are nearer than kFromCrease radii to the crease where their sheet ends, by half a spacing at
/// most: shortened where they are, their discs would be slivers with a gap behind them. Before gaps are filled, which
/// this opens. So also those that are past an edge where faces of solid matter meet that has melted in part, or just at
/// it. `support` h_s [m].
void retreat_from_creases(SurfelCloud& cloud, SurfelNotes& notes, const LiquidShape& shape, Real support);

/// Axes of length r_s in the planes of the normals, the first as near to its old direction as can be. At a crease the
/// disc ends a little beyond it, or it would stand out of the body: the first axis then leads to the crease and is
/// shortened. Coats of two walls cross each other inside the walls and need no shortening; surfels that were pushed
/// over their crease come back to it. Where matter has melted in part its faces still meet in edges, and discs end
/// there (past_edge). Fills notes.give. Surfels of solid matter keep theirs.
void fit_axes(SurfelCloud& cloud, SurfelNotes& notes, const LiquidShape& shape, Real support);

/// Half-axis of a disc that ends at an edge of its body, `to` the way to the edge, both in radii: a little past it, for
/// ellipses side by side must overlap at the edge, not only touch it. In a `corner`, where two edges cut a disc short,
/// an ellipse as long as the ways would leave out the corner itself.
Real past_edge(Real to, bool corner);

}  // namespace thixo
