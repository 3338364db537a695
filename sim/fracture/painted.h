// Cracks that are there from the start: lines on the surface of a body, cut inwards. Dissertation 5.6.6.
#pragma once

#include <vector>

#include "sim/state/solids.h"

namespace thixo {

struct PaintedCut {
    Real depth = 0;     // below the surface [m]
    Real strength = 1;  // Crack::strength [1]
};

/// The polyline in even steps of about a row, at least two. The last of them is left out of a ring.
std::vector<Vec3> even_steps(const std::vector<Vec3>& line, Real row, bool ring);

/// Cuts along a polyline on the surface of the matter, in its material frame [m]. The new crack has a sheet down to the
/// depth, and a front there. Where the last point is the first, the line is a ring, and the front is closed. Otherwise its ends stand
/// on the surface. The line is laid in steps of a row, each projected on the surface. A front that comes out of the body,
/// or on another sheet, ends there. Throws InputError, before anything has changed, where the line leaves the surface.
void paint_crack(const std::vector<Vec3>& line, const PaintedCut& cut, const Breaking& breaking, Solids& solids);

}  // namespace thixo
