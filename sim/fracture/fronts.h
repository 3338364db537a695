// Fronts of cracks: how they begin, move, and lay their sheets. Dissertation 5.6.3, 5.6.4.
#pragma once

#include "sim/fracture/tension.h"

namespace thixo {

/// What moves fronts in a step.
struct FrontStep {
    const CrackedMatter& matter;
    const std::vector<Symmetric>& stress;  // of elements [Pa]
    const std::vector<Tension>& tension;   // of elements (find_tension)
    const PointGrid& gaping;               // places where the crack gapes (gaping_places)
    double dt;                             // [s]
};

/// Begins a crack at the place m, across the axis of the tension there. Near the surface of the body it is a surface
/// crack: two ends just outside and a node inside. Elsewhere it is a triangle, closed. Returns its row.
std::size_t begin_crack(const Vec3& m, const Vec3& axis, const Breaking& breaking, Cracks& cracks);

/// Begins cracks at elements whose largest principal stress exceeds their strength, the most loaded first. An element
/// near a sheet, or near another new crack, begins none: no branches that the stress does not ask for. A crack begins
/// a little off its element, across the axis, so that it does not pass through a plane of the lattice. Returns the
/// largest tension over the strength of any element [1].
Real begin_cracks(const FrontStep& step, std::uint64_t seed, std::uint64_t number, const Elements& elements,
                  Cracks& cracks);

/// Moves the nodes of the matter's fronts. The largest principal stress just ahead of node i is lambda, with the axis e.
/// There k is the strength times that of the crack (Crack::strength), t the tangent of the front, and v the speed of the material:
///     d = v min(lambda/k, 2) (e x t),   0 where lambda < arrest k      [m/s]
///     c <- c + dt d
/// The sign is that of the last motion. The direction is blended with the last one by `history`, over the distance
/// gone. Ends on the surface have the inward normal for t. No node goes farther than a row of the sheet.
/// Where the crack gapes just behind a node, matter has parted that no element lies in: the stress does not know. There
/// the node runs on as it did, at v. Returns the largest speed [m/s].
Real move_fronts(const FrontStep& step, Cracks& cracks);

/// Whether a node has moved so far that a new row of the sheets is due.
bool row_is_due(const Breaking& breaking, const Cracks& cracks);

/// Lays the next row of all sheets of the matter: places of nodes become those of the fronts, and triangles fill what
/// lies between. Then come the events (crack_events.h), and nodes are spaced evenly again.
void lay_rows(const CrackedMatter& matter, Cracks& cracks);

/// Triangle rows are appended by this alone. `ahead` is the direction in which the front moves there, and `along` that
/// in which its nodes are ordered. A triangle that lies folded back on the sheet is never drawn.
void add_triangle(std::int32_t crack, const std::array<Index, 3>& vertices, const Vec3& along, const Vec3& ahead,
                  Cracks& cracks);
Index add_vertex(const Vec3& place, Cracks& cracks);

}  // namespace thixo
