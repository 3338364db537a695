// Bodies that part in mid-run: one call moves everything that belongs to the matter. Dissertation 5.6.
#pragma once

#include <functional>
#include <vector>

#include "sim/space/smoothing.h"
#include "sim/state/particles.h"
#include "sim/state/solids.h"
#include "sim/surface/embedded_surface.h"

namespace thixo {

/// All tables that hold solid matter, and what is needed to bind it anew.
struct Matter {
    Particles& particles;
    Solids& solids;
    EmbeddedSurface& embedded;
    const Smoothing& smoothing;
    std::int64_t& next_id;      // of the next particle
    std::uint64_t seed = 1;     // of samples of surfaces
    double surfel_spacing = 0;  // of new faces [m]; 0: a third of a particle's width, as at set-up
};

/// Splits a body. The matter of body `b` for which `goes(m)` holds, m a place of its material frame, becomes a new
/// body. Returns its index. The new body has a new id, body `b` as parent, and the pose of `b`. No particle moves or
/// changes its velocity, so that mass and momenta stay. Elements, surfels, particles, bonds, contact samples and nodes
/// follow. From then on both bodies are bounded by their surfels. Throws InputError, before anything has changed, where
/// nothing would go, or nothing stay.
std::size_t split_body(std::size_t b, const std::function<bool(const Vec3& m)>& goes, const Matter& matter);

/// Whether a body has come apart: no bond of any weight joins some of its elements to others.
bool has_come_apart(const SolidBody& body, const Elements& elements);

/// Makes bodies of the pieces that the bodies marked by 1 have come apart into. The largest piece stays the body. Each
/// other piece becomes a new one, as in split_body. `nearest` gives the element that a surfel moves with, by its row.
/// Returns the number of new bodies.
std::size_t part_fragments(const std::vector<std::uint8_t>& bodies, const std::function<Index(Index)>& nearest,
                           const Matter& matter);

/// Cuts body `b` along the surface of `cutter`, a shape in the world at time 0: matter inside goes (split_body). Both
/// sides get surfels on the cut, of one new sheet, and lie behind it (TrimNode). Throws InputError, before anything has
/// changed, where a side would have no matter, or where the body has no surfels or no shape.
std::size_t cut_body(std::size_t b, const Shape& cutter, const Matter& matter);

/// Appends surfels of a body: places and discs of `cloud`, in the world at time 0, and the sheet of each. They are a
/// family of their own, with the temperature of the body's other surfels. They have no weights yet. Returns the first
/// row.
std::size_t append_family(const SurfelCloud& cloud, const std::vector<std::int32_t>& sheets, std::size_t b,
                          const Matter& matter);

/// Adds an element at the place m of the rest shape of body `b`, with a particle of this id. It moves with the matter
/// about it. Its bonds are made, and surfels and samples of the body are bound to it. Returns its index.
struct NewElement {
    Vec3 place{0, 0, 0};          // m [m]
    Real mass = 0, volume = 0;    // [kg], [m^3]
    Real support = 0, depth = 0;  // [m]
};
Index add_element(std::size_t b, const NewElement& element, std::int64_t particle, const Matter& matter);

/// Removes an element and its particle, with their mass. Surfels and samples bound to it are bound to its neighbours.
/// Throws InputError, before anything has changed, where it is the last of its body.
void remove_element(Index element, const Matter& matter);

/// Makes everything anew that depends on the elements of the bodies marked by 1: their examples, shapes of split
/// bodies, surfels' weights, contact samples. Removes contact nodes at them.
void bind_matter(const std::vector<std::uint8_t>& bodies, const Matter& matter);

/// The trim tree of a body: that of its scene body, behind every sheet it was cut along, and about cracks. None: all its
/// surfels bound it. `sheets` are those that the body has surfels of, ascending. Once it has split it may be without
/// some of the scene body's: these bound nothing of it, and are left out. A crack with one face on the body trims it as
/// a cut does, but only within `reach` of its surfels [m]. Of a crack that ends in the body both faces are there. The
/// matter is then behind either:
///     source and cuts and (upper or lower)
std::optional<TrimNode> trim_of_fragment(const std::optional<TrimNode>& source, const SolidBody& body,
                                         const std::vector<std::int32_t>& sheets, float reach);

/// The sheets that each body has surfels of, ascending, by its index.
std::vector<std::vector<std::int32_t>> sheets_of(const EmbeddedSurface& surface, std::size_t bodies);

}  // namespace thixo
