#include "sim/surface/fit_discs.h"

#include <algorithm>
#include <limits>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/implicit_surface.h"
#include "pipeline/geometry/near_runs.h"

namespace thixo {
namespace {

// Largest half-axes of discs where the surface bends, and of the last row of a coat, in radii.
constexpr Real kBentDisc = Real(1.5), kLongestCoat = Real(1.35);

// Distance of a surfel from an edge of matter that is still solid, in radii: past the edge its disc would not be cut.
constexpr Real kFromEdge = Real(0.15);

/// The surfels of free surfaces near walls.
struct FreeRim {
    std::vector<Vec3> position, normal;
    PointGrid grid;
};

/// Finds how far a coat's disc may reach, and in which direction: up to the free surface as the surfels around show it.
/// That surface is smoothed; the field's is not. Coats of two walls may overlap.
void end_at_free_surface(SheetSample& sheet, const Vec3& x, const Vec3& n, const FreeRim& rim) {
    sheet.to_crease = std::numeric_limits<Real>::max();
    const Poly6 w(rim.grid.cell());
    // Of the nearest side alone: the other side of a dry spot that closes is of no use here.
    Index nearest = kNone;
    Real least = std::numeric_limits<Real>::max();
    rim.grid.for_each_neighbour(x, rim.grid.cell(), [&](Index j, Real r2) {
        if (!(std::abs(rim.normal[j].dot(n)) < Real(0.8)) || r2 >= least) return;
        least = r2;
        nearest = j;
    });
    if (nearest == kNone) return;
    SurfelAverage average;
    int count = 0;
    Real square_sum = 0;
    rim.grid.for_each_neighbour(x, rim.grid.cell(), [&](Index j, Real r2) {
        if (!(std::abs(rim.normal[j].dot(n)) < Real(0.8)) || rim.normal[j].dot(rim.normal[nearest]) < Real(0.5)) return;
        average.add(w.value(r2), rim.position[j] - x, rim.normal[j]);
        ++count;
        square_sum += w.value(r2) * square(rim.normal[j].dot(rim.position[j] - x));
    });
    if (count < 3 || !average.defined()) return;
    const Vec3 up = average.unit_normal(), across = up - n * n.dot(up);
    const Real rate = across.norm();
    if (rate < Real(0.2)) return;
    // Where the free surface bends, as about a dry spot, its discs stand off from the smooth surface through them.
    // Their planes tell how far. The coat reaches as far, or rays would pass between the two.
    const Real planes = average.planes / average.weight;
    const Real apart = std::sqrt(std::max(square_sum / average.weight - square(planes), Real(0)));
    sheet.to_crease = (apart - (average.value() + planes) / 2) / rate;
    sheet.towards_crease = across / rate;
}

/// The mean height of a surfel's neighbours of its side over its plane. It is large where the surface bends, and where
/// a coat becomes a free surface that almost touches the wall.
class Heights {
  public:
    Heights(const SurfelCloud& cloud, const std::vector<std::int32_t>& component, Real reach)
        : cloud_(cloud), reach_(reach) {
        grid_.build(cloud.position, reach);
        for (auto* a : {&nx_, &ny_, &nz_, &component_}) a->resize(cloud.size() + PointGrid::kPadding, 0);
        parallel_for(cloud.size(), [&](std::size_t slot) {
            const Index i = grid_.index(static_cast<Index>(slot));
            nx_[slot] = cloud.normal[i].x();
            ny_[slot] = cloud.normal[i].y();
            nz_[slot] = cloud.normal[i].z();
            component_[slot] = static_cast<Real>(component[i]);
        });
        own_ = &component;
    }
    Real at(std::size_t i) const {
        const Vec3& n = cloud_.normal[i];
        const Lanes same = all_lanes(static_cast<Real>((*own_)[i])), limit = all_lanes(square(reach_));
        Lanes count{}, sum{};
        for_each_near_run(grid_, cloud_.position[i], reach_, [&](Index slot, Lanes x, Lanes y, Lanes z, Lanes r2) {
            const Lanes agree =
                load_lanes(&nx_[slot]) * n.x() + load_lanes(&ny_[slot]) * n.y() + load_lanes(&nz_[slot]) * n.z();
            const auto counts = (r2 < limit) & (agree >= Real(0.7)) & (load_lanes(&component_[slot]) == same);
            const Lanes height = x * n.x() + y * n.y() + z * n.z();
            count += counts ? all_lanes(1) : Lanes{};
            sum += counts ? (height < 0 ? -height : height) : Lanes{};
        });
        return sum_of(sum) / std::max(sum_of(count), Real(1));
    }

  private:
    const SurfelCloud& cloud_;
    const std::vector<std::int32_t>* own_ = nullptr;
    Real reach_;
    PointGrid grid_;
    std::vector<Real> nx_, ny_, nz_, component_;  // by slot
};

/// The sheet of every surfel in the field.
std::vector<SheetSample> sheets_of(const SurfelCloud& cloud, SurfelNotes& notes, const LiquidShape& shape) {
    std::vector<SheetSample> sheets(cloud.size());
    parallel_for(cloud.size(), [&](std::size_t i) {
        sheets[i] = shape.sheet(cloud.position[i], cloud.normal[i], notes.component[i], notes.wall[i], notes.colour[i]);
    });
    return sheets;
}

/// Ends coats at the smoothed free surface.
void end_coats(std::vector<SheetSample>& sheets, const SurfelCloud& cloud, const SurfelNotes& notes, Real spacing,
               Real support) {
    FreeRim rim;
    for (Index i = 0; i < cloud.size(); ++i) {
        const SheetSample& at = sheets[i];
        if (notes.lost[i] || !at.defined || at.coat || at.phi >= kDeepest || at.to_crease >= 2 * support) continue;
        rim.position.push_back(cloud.position[i]);
        rim.normal.push_back(cloud.normal[i]);
    }
    rim.grid.build(rim.position, support);
    parallel_for(cloud.size(), [&](std::size_t i) {
        SheetSample& at = sheets[i];
        if (!at.coat || !(notes.melt[i] > 0)) return;
        // Where the field has liquid the coat continues, whatever the planes of farther surfels say there.
        const bool corner = at.stand_off == 0 && at.to_crease < std::numeric_limits<Real>::max();
        const Real by_field = corner ? -spacing : at.to_crease;
        end_at_free_surface(at, cloud.position[i], cloud.normal[i], rim);
        at.to_crease = std::max(at.to_crease, by_field - Real(0.25) * spacing);
    });
}

/// Convex edges between faces of a solid that has not wholly melted. Discs end there: otherwise fins would stand out
/// past them.
class Edges {
  public:
    Edges(const SurfelCloud& cloud, const SurfelNotes& notes, const std::vector<SheetSample>& sheets, Real reach)
        : cloud_(cloud), notes_(notes), sheets_(sheets) {
        if (std::ranges::any_of(notes.melt, [](Real b) { return b < 1; })) grid_.build(cloud.position, reach);
    }
    /// The nearest edge that ends a disc within a radius.
    struct Nearest {
        Real to = 1;            // < 0 past the edge, in radii
        Vec3 towards{0, 0, 0};  // unit tangent
    };
    Nearest nearest(Index i, Real radius) const {
        Nearest edge;
        if (!(notes_.melt[i] < 1)) return edge;
        for_each(i, [&](Real depth, const Vec3& tangent) {
            const Real rate = tangent.norm() * radius;
            if (depth >= edge.to * rate) return;
            edge.to = depth / rate;
            edge.towards = tangent.normalized();
        });
        return edge;
    }
    /// The reach of a disc in its radii: towards the nearest edge, and to its sides.
    struct Cut {
        Real ahead = 1, across = 1;
        Vec3 towards{0, 0, 0};
    };
    Cut cut(Index i, Real radius) const {
        const Nearest edge = nearest(i, radius);
        Cut cut{1, 1, edge.towards};
        if (!(edge.to < 1)) return cut;
        const Vec3 side = cloud_.normal[i].cross(edge.towards);
        for_each(i, [&](Real depth, const Vec3& tangent) {
            const Real rate = std::abs(tangent.dot(side));
            if (rate > Real(0.5)) cut.across = std::min(cut.across, depth / (rate * radius));
        });
        const bool corner = cut.across < 1;
        cut.ahead = past_edge(edge.to, corner);
        if (corner) cut.across = past_edge(cut.across, corner);
        return cut;
    }

  private:
    /// Calls f(d, m) for planes of other faces that disc i meets. Beyond d in the direction m it would be out of the
    /// body. The tangent m is as long as the sine of the angle between the two.
    template <class F>
    void for_each(Index i, F&& f) const {
        const Vec3 &x = cloud_.position[i], &n = cloud_.normal[i];
        grid_.for_each_neighbour(x, grid_.cell(), [&](Index j, Real) {
            const Vec3 &other = cloud_.normal[j], away = x - cloud_.position[j];
            const Real same = n.dot(other);
            if (notes_.component[j] != notes_.component[i] || same > Real(0.7) || same < Real(-0.5)) return;
            const Real depth = -other.dot(away);
            if (sheets_[j].coat || (depth < 0 && n.dot(away) < 0)) return;  // the second case: a hollow
            f(depth, Vec3(other - same * n));
        });
    }

    const SurfelCloud& cloud_;
    const SurfelNotes& notes_;
    const std::vector<SheetSample>& sheets_;
    PointGrid grid_;
};

/// Whether a coat's surfel lies beyond the crease with another coat.
bool over_corner(const SheetSample& at) { return at.coat && at.stand_off == 0 && at.to_crease < 0; }

}  // namespace

Real past_edge(Real to, bool corner) {
    constexpr Real kPast = Real(0.4), kShortest = Real(0.6);
    // Half-axes of an ellipse about a rectangle, over the rectangle's: of a disc in the corner of two edges.
    constexpr Real kIntoCorner = Real(1.4142136);
    return std::clamp(kPast + (corner ? kIntoCorner : Real(1.2)) * to, kShortest, Real(1));
}

void retreat_from_creases(SurfelCloud& cloud, SurfelNotes& notes, const LiquidShape& shape, Real support) {
    std::vector<SheetSample> sheets = sheets_of(cloud, notes, shape);
    end_coats(sheets, cloud, notes, shape.spacing, support);
    const Edges edges(cloud, notes, sheets, Real(0.6) * support);
    const Real most = Real(0.5) * shape.spacing;
    std::vector<Vec3> moved = cloud.position;
    parallel_for(cloud.size(), [&](std::size_t i) {
        if (!(notes.melt[i] > 0)) return;
        const SheetSample& at = sheets[i];
        const Real radius = notes.radius[i];
        const Real short_of = at.defined ? kFromCrease * radius - at.to_crease : 0;
        if (short_of > 0) moved[i] -= std::min(short_of, most) * at.towards_crease;
        const Edges::Nearest edge = edges.nearest(static_cast<Index>(i), radius);
        if (edge.to < kFromEdge)
            moved[i] -= clamp01(1 - 2 * notes.melt[i]) * std::min((kFromEdge - edge.to) * radius, most) * edge.towards;
    });
    cloud.position.swap(moved);
}

void fit_axes(SurfelCloud& cloud, SurfelNotes& notes, const LiquidShape& shape, Real support) {
    std::vector<SheetSample> sheets = sheets_of(cloud, notes, shape);
    notes.lift_share.resize(cloud.size());
    for (std::size_t i = 0; i < cloud.size(); ++i)
        notes.lift_share[i] = sheets[i].coat ? Real(0) : sheets[i].lift_share;
    // Neighbours in a corner may have pushed coats over their crease, deeper into the walls than necessary.
    const std::vector<SheetSample> field = sheets;
    std::vector<Vec3> moved = cloud.position;
    end_coats(sheets, cloud, notes, shape.spacing, support);
    const Edges edges(cloud, notes, sheets, Real(0.6) * support);
    const Heights heights(cloud, notes.component, Real(0.6) * support);
    parallel_for(cloud.size(), [&](std::size_t i) {
        if (!(notes.melt[i] > 0)) return;
        if (over_corner(field[i])) moved[i] += field[i].to_crease * field[i].towards_crease;
        const Vec3& n = cloud.normal[i];
        const SheetSample& at = sheets[i];
        // Where the surface bends, discs stand off from each other as tangent planes do: they are enlarged there.
        const Real own = notes.radius[i];
        const Real bend = std::max(Real(0.5) * notes.curvature[i] * own, heights.at(i) / own);
        const Real radius = own * std::min(1 + 2 * bend, kBentDisc);
        // Row and crease do not always agree, and a coat is flat: its last row reaches farther. Ellipses side by side
        // must overlap at the crease, not only touch it. The eighth is for that.
        const Real longest = at.coat ? kLongestCoat * radius : radius;
        const Real past = Real(at.coat ? 0.06 : 0.1) * shape.spacing;
        const bool at_crease = at.defined && Real(1.125) * at.to_crease + past < longest;
        Real ahead = at_crease ? std::max(Real(1.125) * at.to_crease + past, Real(1.5) * past) : radius;
        const Edges::Cut edge = edges.cut(static_cast<Index>(i), radius);
        const bool at_edge = edge.ahead * radius < ahead;
        if (at_edge) ahead = edge.ahead * radius;
        Vec3 t = at_edge ? edge.towards : at_crease ? at.towards_crease : cloud.axis1[i];
        const Real length = at_edge || at_crease ? Real(1) : own;  // of t: a direction, or an old half-axis
        t -= n * n.dot(t);
        if (!(t.squaredNorm() > square(Real(1e-3) * length))) {
            Vec3 unused;
            orthonormal_basis(n, t, unused);
        }
        t.normalize();
        cloud.axis1[i] = ahead * t;
        cloud.axis2[i] = (at_edge ? edge.across : 1) * radius * n.cross(t);
    });
    cloud.position.swap(moved);
}

}  // namespace thixo
