// Matter that has frozen and may break: it is a solid like one of the scene again. Dissertation 5.6, 6.6.6.
#pragma once

#include "sim/fracture/fragments.h"
#include "sim/surface/mixed_surface.h"

namespace thixo {

/// Bodies that have frozen throughout and may break get the surface of a solid of the scene. Animated surfels that are
/// bound to the rest shape in which the body has frozen become embedded ones, with new ids. The rest shape is then
/// bounded by them, for cracks and contact. Bodies whose surface still joins that of a liquid wait. Called before the
/// surface is updated. Returns whether there were any: what was computed of Solids::breaking is then stale.
bool embed_frozen(const Matter& matter, MixedSurface& surface);

/// How frozen rest shapes break: as the matter of the scene body that they came from, within their own surface. Records
/// of frozen frames are made anew, from surfels and cracks alone, so that a resumed run has the same.
void make_frozen_breaking(const Matter& matter);

/// Surfels of fragments that have melted and gone back (return_fragments in phase) are those of the body that has their
/// matter now.
void follow_returned(const Solids& solids, MixedSurface& surface);

}  // namespace thixo
