// The surface of a solid: surfels bound to its matter. Dissertation 5.5.
#pragma once

#include <algorithm>
#include <concepts>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "pipeline/contract/scene.h"
#include "pipeline/contract/trim.h"
#include "pipeline/geometry/point_grid.h"
#include "sim/state/solids.h"
#include "sim/surface/surface.h"

namespace thixo {

/// The part of a disc beside an edge of the body that lies on the body. `along` is the remaining part of the half-axis
/// in the direction `angle` from the first axis, `across` that of the other. A disc with its centre past the edge is
/// first moved `shift` radii in the direction `shift_angle`, onto the body.
struct EdgeCut {
    Real angle = 0, along = 1, across = 1;
    Real shift_angle = 0, shift = 0;
};

/// An element's weights in the displacement of a surfel: w_poly6 over their sum.
struct SurfelWeight {
    Real at, along1, along2;  // at m, m + t1, m + t2
    Index element;
};

/// Surfels made at one time: consecutive rows from `first` on, with the ids base, base + 1, ... Halves of surfel i have
/// the ids 2 i + shift and 2 i + shift + 1, so that no two surfels ever have the same id.
struct SurfelFamily {
    Index first = 0;
    std::int64_t base = 0, shift = 0;
};

/// The surfels of all solids, made from the shapes of the bodies in their order. New faces of bodies that are cut are
/// appended. The state of the surface is that of the elements.
struct EmbeddedSurface {
    SurfelCloud rest;                        // in the material frame of the owner [m]
    std::vector<std::int32_t> owner, sheet;  // index of the SolidBody; sheet of its surface, from 0 on
    std::vector<std::int32_t> frame;         // that `rest` is in (SolidBody::frame)
    std::vector<Vec3> first;                 // m0: where the surfel was made, in the world [m]
    std::vector<std::uint8_t> beyond;        // 1: the disc reaches past an edge of the body; the trim tree cuts it
    std::vector<EdgeCut> edge;               // where no trim tree cuts; along = 0: the disc is off the body
    std::vector<Real> support;               // of its weights: the elements', larger where too few are near [m]
    std::vector<Real> temperature;           // degC
    std::vector<SurfelFamily> families;
    std::int64_t families_made = 0;             // so far, with those of which no surfel is left
    std::vector<std::optional<TrimNode>> trim;  // by body
    std::vector<PointGrid> grid;                // of every body's elements in the rest shape, in their order
    std::vector<std::size_t> begin{0};  // of every surfel's weights, then the end; the rest shape does not change
    std::vector<SurfelWeight> weight;
    std::vector<std::uint8_t> screened;  // 1: a crack weakens some of a surfel's weights
    std::size_t size() const { return owner.size(); }
    const SurfelFamily& family(std::size_t surfel) const {
        const auto after = std::ranges::upper_bound(families, surfel, {}, &SurfelFamily::first);
        return *std::prev(after);
    }
    std::int64_t id(std::size_t surfel) const {
        const SurfelFamily& f = family(surfel);
        return f.base + static_cast<std::int64_t>(surfel - f.first);
    }
};

template <class E, class F>
void for_each_field(E& e, F&& f) requires std::same_as<std::remove_const_t<E>, EmbeddedSurface> {
    f("embedded.place", Life::made, e.rest.position);
    f("embedded.axis1", Life::made, e.rest.axis1);
    f("embedded.axis2", Life::made, e.rest.axis2);
    f("embedded.normal", Life::made, e.rest.normal);
    f("embedded.owner", Life::made, e.owner);
    f("embedded.sheet", Life::made, e.sheet);
    f("embedded.frame", Life::made, e.frame);
    f("embedded.first", Life::made, e.first);
    f("embedded.beyond", Life::made, e.beyond);
    f("embedded.edge", Life::made, e.edge);
    f("embedded.support", Life::made, e.support);
    f("embedded.temperature", Life::made, e.temperature);
}

/// Surfels on all solids of the scene: Body::surfels of them, or as dense as surface.radius asks for.
EmbeddedSurface make_embedded_surface(const scene::Scene& scene, const Solids& solids);

/// Appends surfels of a body, by its index: places, discs, m0, owner and frame. Other fields are zero until they are
/// written or bound. `cloud` is in the world at time 0.
void append_surfels(const SurfelCloud& cloud, const SolidBody& body, std::int32_t owner, EmbeddedSurface& surface);

/// What stands between a surfel at m and elements of its body. It gives the shares of their weights with which they move
/// the surfel, in their order [1]. False: nothing stands there. Empty: nothing anywhere.
using ElementSight =
    std::function<bool(const Vec3& m, const Vec3& normal, std::span<const Index> elements, std::vector<Real>& share)>;

/// Finds the supports, grids and weights of all surfels of the bodies marked by 1 anew, from these bodies' elements.
/// Surfels of other bodies stay.
void bind_surfels(const Solids& solids, const std::vector<std::uint8_t>& bodies, EmbeddedSurface& surface,
                  const ElementSight& sight = {});
/// The same for the surfels `which` alone, ascending rows. Rows that were just appended are among them.
void bind_some_surfels(const Solids& solids, const std::vector<Index>& which, EmbeddedSurface& surface,
                       const ElementSight& sight);

/// The body bounded by its surfels, without those that reach past its edges, in the world at time 0. The faces of a crack
/// that ends within the body are left out: they bound nothing as long as it is closed. Empty where too few surfels are
/// left.
std::optional<Shape> shape_of_surfels(const EmbeddedSurface& surface, const SolidBody& body, std::int32_t index);

/// Computes the present surfels. The displacement is of first order, and exact under rigid motion (5.28):
///     u(m) = sum_j w_poly6(m - m_j, h) (u_j + H_j (m - m_j)) / sum_j w_poly6(m - m_j, h)
///     s = m + u(m),   t' = t + u(m + t) - u(m),   n = unit(t1' x t2')
/// Velocities have the same weights. A surfel that is stretched too far is split into two halves side by side along its
/// longest direction, and these again (5.5.2). The criterion is the squared half-axes of the drawn disc over the
/// squared radius of the original surfel. The squared half-axes are the eigenvalues of
///     [t1'.t1' t1'.t2'; t1'.t2' t2'.t2']
/// A surfel splits where they exceed kSplitStretch, or differ by more than kSplitRatio with the longer one above 1.2.
/// This depends on the present displacement alone. Matter that is released has its old surfels, ids and axes again, and
/// there is no state to keep. Ids of halves follow from their parent's (SurfelFamily). Writes every array of `surface`,
/// in the order of the original surfels, and the original of each into `source`. Bodies with another Skin have no such
/// surfels.
void displace_embedded(const EmbeddedSurface& embedded, Solids& solids, SurfaceState& surface,
                       std::vector<Index>& source);

/// The support of a surfel's weights: `usual` [m], or one that reaches a few elements from everywhere on its disc.
Real weights_support(const PointGrid& grid, const Vec3& m, Real disc, Real usual);

/// u(m) of that field with weights of this support [m]. `grid` holds the body's elements in the rest shape, one of them
/// within the support. Requires displace_embedded.
Vec3 displacement(const PointGrid& grid, const SolidBody& body, const Solids& solids, const Vec3& m, Real support);

/// The same for a body with a surface; empty where no element is within the support.
std::optional<Vec3> displacement_at(const EmbeddedSurface& embedded, const Solids& solids, std::size_t owner,
                                    const Vec3& m, Real support);

/// Bound of the distance between a surfel and the elements of its pieces and of the ends of their axes [m]. Pieces lie
/// within 1.25 axes of it (1/2 + 0.6/2 + ...) either way, and their axes are no longer.
inline Real reach_of_pieces(const EmbeddedSurface& embedded, std::size_t surfel) {
    return embedded.support[surfel] +
           Real(2.8) * std::max(embedded.rest.axis1[surfel].norm(), embedded.rest.axis2[surfel].norm());
}

inline constexpr Real kSplitStretch = 2;  // squared stretch
inline constexpr Real kSplitRatio = 3;    // of squared stretches

}  // namespace thixo
