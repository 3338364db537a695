// What a finished or running simulation could not do, from its cache alone.
#pragma once

#include <vector>

#include "pipeline/contract/cache.h"

namespace thixo {

/// The shortfalls of all frames together, and the energy that motion gained from nowhere.
///
/// Energy is watched where nothing drives the scene. Emitters, moving walls and handles do, and changes of a material, and
/// gravity along a periodic axis. Without them kinetic and potential energy together can only fall, but for what is
/// stored at the start. A gain is told above the sum of four allowances:
/// - a tenth of the largest kinetic energy: what integration may err by;
/// - the energy of the surface if every particle stood alone, 6 gamma V/d: tension gives it back;
/// - the weight times the larger of a spacing and 2 % of the matter's size: a packing that settles to its density;
/// - that of all matter if it moved by a millionth of its size in a frame: rounding.
/// Throws CacheError.
std::vector<Shortfall> shortfalls_of(const CacheReader& reader);

}  // namespace thixo
