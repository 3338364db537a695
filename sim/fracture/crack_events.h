// What happens to fronts where they meet the surface, other cracks, or each other. Dissertation 5.6.5.
#pragma once

#include "sim/fracture/tension.h"

namespace thixo {

/// Rows: how far outside of the body the ends of fronts and the rims of sheets stand.
inline constexpr Real kEndLevel = Real(0.3);

/// Marks nodes that a row takes out of the body, onto another sheet, or onto an oncoming part of a front. `to` are the
/// new places of all nodes of the fronts `which`, by front. They are changed where nodes end:
/// - Two nodes meet that are no neighbours, run against each other, and are nearer than one and a half rows. Both end, at
///   the mean of their places.
/// - A node crosses another sheet: it ends a little beyond. It has come within one and a half rows of one: it ends there.
/// - A node leaves the body: it ends on the surface, a third of a row outside.
void meet(const CrackedMatter& matter, const std::vector<std::size_t>& which, std::vector<std::vector<Vec3>>& to,
          Cracks& cracks);

/// A place near m on the level at which ends stand: a third of a row outside of the body. It is reached within the plane
/// of this normal, or straight outwards where that plane lies along the surface.
Vec3 at_end_level(const Breaking& breaking, const Vec3& normal, const Vec3& m);

/// Splits fronts where nodes have ended. Each run of nodes inside becomes a front of its own, with the ended nodes beside
/// it as its ends. Fronts without a node inside terminate. So do those that have shrunk to about a row's length. The
/// hole within a closed one is filled. An open one is in a corner, and its nodes run out of it. All parts go on with the
/// same two sheets.
void split_fronts(const CrackedMatter& matter, Cracks& cracks);

/// Spaces the nodes of the matter's fronts evenly. Where two are farther apart than one and a half rows, a node is put in
/// on a cubic spline through its neighbours. A node nearer than two fifths of a row to the one before is taken out.
void space_nodes(const Breaking& breaking, Cracks& cracks);

}  // namespace thixo
