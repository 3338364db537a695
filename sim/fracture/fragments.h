// Bodies that part in mid-run: one call moves everything that belongs to the matter. Dissertation 5.6.
#pragma once

#include <functional>
#include <vector>

#include "sim/space/smoothing.h"
#include "sim/state/particles.h"
#include "sim/state/solids.h"
#include "sim/surface/embedded_surface.h"

namespace thixo {

/// All tables that hold solid matter, and what binding it anew asks for.
struct Matter {
    Particles& particles;
    Solids& solids;
    EmbeddedSurface& embedded;
    const Smoothing& smoothing;
    std::uint64_t seed = 1;       // of samples of surfaces
    double surfel_spacing = 0;    // of new faces [m]; 0: as wide as surfels are made for a particle, a third
};

/// Matter of body `b` for which `goes(m)` holds, m a place of its material frame, becomes a body of its own; returns its
/// index. It has a new id, the other's as parent, and its pose: no particle moves or changes its velocity, so that mass
/// and momenta stay. Elements, surfels, particles, bonds, contact samples and nodes follow. Both bodies are from then on
/// bounded by their surfels. Throws an assertion where nothing would go, or nothing stay.
std::size_t split_body(std::size_t b, const std::function<bool(const Vec3& m)>& goes, const Matter& matter);

/// Cuts body `b` along the surface of `cutter`, a shape in the world at time 0: what lies inside goes (split_body). Both
/// sides get surfels on the cut, of one new sheet, and lie behind it (TrimNode). Requires a scene with surfels.
std::size_t cut_body(std::size_t b, const Shape& cutter, const Matter& matter);

/// One more element, at the place m of body `b` at rest, with a particle of this id; moves with the matter about it.
/// Its bonds, and those of surfels and samples of the body to it, are made. Returns its index.
struct NewElement {
    Vec3 place{0, 0, 0};           // m [m]
    Real mass = 0, volume = 0;     // [kg], [m^3]
    Real support = 0, depth = 0;   // [m]
};
Index add_element(std::size_t b, const NewElement& element, std::int64_t particle, const Matter& matter);

/// Removes an element and its particle, with their mass. What was bound to it is bound to its neighbours.
void remove_element(Index element, const Matter& matter);

/// Makes everything anew that the elements of the bodies marked by 1 carry: their examples, shapes of bodies that have
/// split, surfels' weights, contact samples; forgets contact nodes at them.
void bind_matter(const std::vector<std::uint8_t>& bodies, const Matter& matter);

/// The trim tree of a body: its scene body's, behind every sheet it was cut along. None: all of its surfels bound it.
std::optional<TrimNode> trim_of_fragment(const std::optional<TrimNode>& source, const SolidBody& body);

}  // namespace thixo
