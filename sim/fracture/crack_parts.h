// What the parts of fracture ask of fronts and triangles.
#pragma once

#include <utility>

#include "sim/state/cracks.h"

namespace thixo {

/// The frame that a triangle of the sheets is in.
inline std::int32_t frame_of(const Cracks& cracks, Index triangle) {
    return cracks.cracks[static_cast<std::size_t>(cracks.triangles.crack[triangle])].frame;
}
/// Whether a front is of this matter and goes where the stress leads it. Those of blades do not.
inline bool runs(const CrackFront& front, const Breaking& breaking, const Cracks& cracks) {
    const Crack& crack = cracks.cracks[static_cast<std::size_t>(front.crack)];
    return crack.frame == breaking.frame && crack.strength < kUnbreakable;
}

/// The middle of a triangle [m].
inline Vec3 middle_of(const Cracks& cracks, Index k) {
    const CrackTriangles& t = cracks.triangles;
    return (cracks.vertex[t.a[k]] + cracks.vertex[t.b[k]] + cracks.vertex[t.c[k]]) / 3;
}

/// From the node before node i of a front to the one after it; at an end, from or to the end itself [m].
inline Vec3 between_neighbours(const CrackFront& front, std::size_t i) {
    const std::size_t n = front.nodes.size();
    const std::size_t next = i + 1 < n ? i + 1 : front.closed ? 0 : i;
    const std::size_t before = i > 0 ? i - 1 : front.closed ? n - 1 : 0;
    return front.nodes[next].tip() - front.nodes[before].tip();
}

}  // namespace thixo
