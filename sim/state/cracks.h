// Cracks in solid matter: fronts that move through it, and the sheets that they leave behind. Dissertation 5.6.3.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "pipeline/base/math.h"
#include "pipeline/contract/trim.h"
#include "pipeline/geometry/shape.h"
#include "sim/state/table.h"

namespace thixo {

/// The strength at a temperature [degC], over that of the material [1].
struct StrengthFactor {
    double temperature, factor;
};

/// How the matter of a rest shape breaks: that of a scene body, or one in which it has frozen.
struct Breaking {
    std::int32_t source = 0;      // the scene body
    std::int32_t frame = 0;       // of its rest shape (SolidBody::frame)
    Real arrest = 0;              // [1]
    Real speed = 0;               // of a crack at its strength [m/s]
    Real history = 0;             // over a particle's width [1]
    Real opaque = 0;              // kappa h/2: distance behind a front at which a crack is opaque for q = 0 [m]
    Real support = 0, width = 0;  // of a particle [m]
    Real row = 0;                 // distance of nodes and of rows of sheets [m]
    Real surfel = 0;              // radius of the body's surfels; 0: it has none [m]
    Shape shape;                  // of the whole body, in the world at time 0
    Vec3 origin{0, 0, 0};         // of the material frame there [m]
    std::vector<StrengthFactor> by_temperature{};  // ascending; linear in between
    /// Signed distance of a place of the material frame to the surface of the whole body [m].
    Real distance(const Vec3& m) const { return shape.distance(m + origin); }
    Vec3 outward(const Vec3& m) const { return shape.gradient(m + origin, width / 16); }
};

/// What a node of a front does.
enum class NodeState : std::uint32_t {
    inside,   // it runs through the matter
    surface,  // the end of a front, just outside of the body: it runs along the surface
    met       // the end of a front at another crack, or where two parts of fronts have met
};

/// A node of a front. Places are in the material frame of the rest shape.
struct CrackNode {
    Vec3 place{0, 0, 0};    // c, where the sheet ends [m]
    Vec3 advance{0, 0, 0};  // of the front since that row of the sheet was laid [m]
    Vec3 heading{0, 0, 0};  // unit direction of its motion
    Index vertex = 0;       // of the sheet, at `place`
    NodeState state = NodeState::inside;
    Vec3 tip() const { return place + advance; }
};

/// An ordered polyline of nodes. Fronts are few, and read whole.
struct CrackFront {
    std::int32_t crack = 0;
    std::int32_t closed = 0;  // 1: the last node is followed by the first
    std::vector<CrackNode> nodes;
};

inline constexpr Real kUnbreakable = std::numeric_limits<Real>::max();  // a strength that nothing reaches

/// A crack has two sheets of surfels: `sheet` bounds the matter on one side, `sheet` + 1 that on the other.
struct Crack {
    std::int32_t source = 0;  // the scene body that the matter came from
    std::int32_t frame = 0;   // in which it is (SolidBody::frame)
    std::int32_t sheet = 0;
    Real strength = 1;  // of what its front runs through, over that of the material [1]; kUnbreakable: a blade's cut
};

/// The sheets as triangles, by which sight through cracks is decided. Vertices are shared: sheets have no holes.
struct CrackTriangles {
    std::vector<Index> a, b, c;       // vertices
    std::vector<std::int32_t> crack;  // its row
    std::vector<Real> behind;         // distance to the front, never less than it was [m]
    std::vector<std::uint8_t> drawn;  // 1: surfels of both sheets are laid
    std::vector<Real> bound;          // `behind` when the surfels about it were bound; < 0: not yet [m]
    std::size_t size() const { return a.size(); }
};
template <class T, class F>
void for_each_field(T& t, F&& f) requires requires {
    t.behind;
    t.drawn;
}
{
    f("cracks.a", Life::state, t.a);
    f("cracks.b", Life::state, t.b);
    f("cracks.c", Life::state, t.c);
    f("cracks.of", Life::state, t.crack);
    f("cracks.behind", Life::state, t.behind);
    f("cracks.drawn", Life::state, t.drawn);
    f("cracks.bound", Life::state, t.bound);
}

/// Where a bond crosses a sheet, as long as the bond is not parted.
struct BondCrossings {
    std::vector<Index> first, second;  // elements, first < second
    std::vector<Index> triangle;
    std::size_t size() const { return first.size(); }
};
template <class T, class F>
void for_each_field(T& t, F&& f) requires requires {
    t.second;
    t.triangle;
}
{
    f("crossings.first", Life::state, t.first);
    f("crossings.second", Life::state, t.second);
    f("crossings.triangle", Life::state, t.triangle);
}

inline constexpr Real kParted = std::numeric_limits<Real>::max();  // CrackTriangles::behind where no front is left

/// State; part of a checkpoint.
struct Cracks {
    std::vector<Crack> cracks;
    std::vector<CrackFront> fronts;
    std::vector<Vec3> vertex;  // of triangles [m]
    CrackTriangles triangles;
    BondCrossings crossings;
    double step = 1e30;  // the next step must not be longer, for fronts and new cracks to be followed [s]
    double load = 0;     // largest tension over strength at the last step (largest_load, tension.h) [1]

    bool any() const { return !cracks.empty(); }
};

}  // namespace thixo
