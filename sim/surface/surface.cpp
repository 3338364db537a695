#include "sim/surface/surface.h"

#include <algorithm>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/implicit_surface.h"
#include "pipeline/geometry/near_runs.h"
#include "sim/surface/displace.h"
#include "sim/surface/liquid_shape.h"
#include "sim/surface/potentials.h"
#include "sim/surface/resample.h"
#include "sim/surface/volume.h"
#include "sim/surface/zombies.h"

namespace thixo {
namespace {

// Half-axes of discs where the surface bends, and of the last of a coat, in radii.
constexpr Real kBentDisc = Real(1.5), kLongestCoat = Real(1.35);

/// The surfels of free surfaces near walls.
struct FreeRim {
    std::vector<Vec3> position, normal;
    PointGrid grid;
};

/// How far a coat's disc may reach and which way: up to the free surface as the surfels around have it, smoothed, not
/// as the field has it. Coats of two walls may overlap.
void end_at_free_surface(SheetSample& sheet, const Vec3& x, const Vec3& n, const FreeRim& rim) {
    sheet.to_crease = std::numeric_limits<Real>::max();
    const Poly6 w(rim.grid.cell());
    // Of the side that is nearest: the other one of a dry spot that closes says nothing here.
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
    // Where the free surface bends, as about a dry spot, its discs are apart from the smooth surface through them: by
    // how much, their planes tell. The coat goes as far, or rays would pass between the two.
    const Real planes = average.planes / average.weight;
    const Real apart = std::sqrt(std::max(square_sum / average.weight - square(planes), Real(0)));
    sheet.to_crease = (apart - (average.value() + planes) / 2) / rate;
    sheet.towards_crease = across / rate;
}

/// How far the neighbours of a surfel's side are from its plane, in the mean: where the surface bends, and where it
/// goes over from a coat to a free surface that all but touches the wall.
class Heights {
  public:
    Heights(const SurfelCloud& cloud, const std::vector<std::int32_t>& component, Real reach)
        : cloud_(cloud), reach_(reach) {
        grid_.build(cloud.position, reach);
        for (auto* a : {&nx_, &ny_, &nz_, &component_}) a->resize(cloud.size() + PointGrid::kPadding, 0);
        parallel_for(cloud.size(), [&](std::size_t s) {
            const Index i = grid_.index(static_cast<Index>(s));
            nx_[s] = cloud.normal[i].x();
            ny_[s] = cloud.normal[i].y();
            nz_[s] = cloud.normal[i].z();
            component_[s] = static_cast<Real>(component[i]);
        });
        own_ = &component;
    }
    Real at(std::size_t i) const {
        const Vec3& n = cloud_.normal[i];
        const Lanes same = all_lanes(static_cast<Real>((*own_)[i])), limit = all_lanes(square(reach_));
        Lanes count{}, sum{};
        for_each_near_run(grid_, cloud_.position[i], reach_, [&](Index s, Lanes x, Lanes y, Lanes z, Lanes r2) {
            const Lanes agree = load_lanes(&nx_[s]) * n.x() + load_lanes(&ny_[s]) * n.y() + load_lanes(&nz_[s]) * n.z();
            const auto counts = (r2 < limit) & (agree >= Real(0.7)) & (load_lanes(&component_[s]) == same);
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

/// Axes of length r_s in the planes of the normals, the first as near to its old direction as can be. At a crease the
/// disc ends a little beyond it, or it would stand out of the body: the first axis then leads to the crease and is
/// shortened. Coats of two walls cross each other inside the walls and need no shortening.
/// Surfels of solid matter keep theirs.
void fit_axes(SurfelCloud& cloud, SurfelNotes& notes, const LiquidShape& shape, Real support) {
    std::vector<SheetSample> sheets(cloud.size());
    parallel_for(cloud.size(), [&](std::size_t i) {
        sheets[i] = shape.sheet(cloud.position[i], cloud.normal[i], notes.component[i], notes.wall[i], notes.colour[i]);
    });
    notes.give.resize(cloud.size());
    for (std::size_t i = 0; i < cloud.size(); ++i) notes.give[i] = sheets[i].coat ? Real(0) : sheets[i].give;
    FreeRim rim;
    for (Index i = 0; i < cloud.size(); ++i)
        if (sheets[i].defined && !sheets[i].coat && sheets[i].phi < kDeepest && sheets[i].to_crease < 2 * support) {
            rim.position.push_back(cloud.position[i]);
            rim.normal.push_back(cloud.normal[i]);
        }
    rim.grid.build(rim.position, support);
    const Heights heights(cloud, notes.component, Real(0.6) * support);
    std::vector<Vec3> moved = cloud.position;
    parallel_for(cloud.size(), [&](std::size_t i) {
        if (!(notes.melt[i] > 0)) return;
        const Vec3& n = cloud.normal[i];
        SheetSample at = sheets[i];
        // Neighbours in a corner may have pushed it over the crease of two coats, deeper into the walls than need be.
        if (at.coat && at.stand_off == 0 && at.to_crease < 0) moved[i] += at.to_crease * at.towards_crease;
        if (at.coat) {
            // Where the field has liquid the coat goes on, whatever the planes of surfels farther off say there.
            const bool corner = at.stand_off == 0 && at.to_crease < std::numeric_limits<Real>::max();
            const Real by_field = corner ? -shape.spacing : at.to_crease;
            end_at_free_surface(at, cloud.position[i], n, rim);
            at.to_crease = std::max(at.to_crease, by_field - Real(0.25) * shape.spacing);
        }
        // Ellipses side by side must overlap at the crease, not only touch it: hence the eighth more. A disc too near
        // the crease is taken back: shortened about its place it would be a sliver and leave a gap behind it.
        const Real past = Real(at.coat ? 0.06 : 0.1) * shape.spacing;
        // Where the surface bends discs stand off from each other as tangent planes do: they are drawn larger there.
        const Real own = notes.radius[i];
        const Real bend = std::max(Real(0.5) * notes.curvature[i] * own, heights.at(i) / own);
        const Real radius = own * std::min(1 + 2 * bend, kBentDisc);
        // Row and crease do not always agree, and a coat is flat: its last row reaches farther.
        const Real longest = at.coat ? kLongestCoat * radius : radius;
        const bool at_crease = at.defined && Real(1.125) * at.to_crease + past < longest;
        if (at_crease && at.to_crease < kFromCrease * radius) {
            const Real back = std::min(kFromCrease * radius - at.to_crease, Real(0.5) * shape.spacing);
            moved[i] -= back * at.towards_crease;
            at.to_crease += back;
        }
        const Real reach = std::clamp(Real(1.125) * at.to_crease + past, Real(1.5) * past, longest);
        Vec3 t = at_crease ? at.towards_crease : cloud.axis1[i];
        t -= n * n.dot(t);
        if (!(t.squaredNorm() > square(Real(1e-3) * radius))) {
            Vec3 unused;
            orthonormal_basis(n, t, unused);
        }
        t.normalize();
        cloud.axis1[i] = (at_crease ? reach : radius) * t;
        cloud.axis2[i] = radius * n.cross(t);
    });
    cloud.position.swap(moved);
}

template <class T>
void permute(std::vector<T>& array, const std::vector<Index>& order) {
    std::vector<T> sorted(array.size());
    for (std::size_t k = 0; k < order.size(); ++k) sorted[k] = array[order[k]];
    array.swap(sorted);
}

void sort_by_cell_and_id(SurfaceState& surface, Real support) {
    const auto order = PointGrid::sort_order(surface.surfels.position, surface.id, support);
    for_each_array(surface, [&](const char*, auto& array) { permute(array, order); });
}

/// b of every surfel: the normalised interpolation of the particles' (6.6.6).
std::vector<Real> melt_of(const SurfaceState& surface, const Particles& particles,
                          const std::vector<std::int32_t>& component, Real support) {
    std::vector<Real> melt(surface.size(), 1);
    if (std::ranges::all_of(particles.melt, [](Real b) { return b == 1; })) return melt;
    PointGrid grid;
    grid.build(particles.position, support);
    const Poly6 w(support);
    parallel_for(surface.size(), [&](std::size_t i) {
        Real weight = 0, sum = 0;
        grid.for_each_neighbour(surface.surfels.position[i], support, [&](Index j, Real r2) {
            if (particles.material[j] != component[i]) return;
            const Real a = particles.rest_volume[j] * w.value(r2);
            weight += a;
            sum += a * particles.melt[j];
        });
        if (weight > 0) melt[i] = std::min(sum / weight, Real(1));
    });
    return melt;
}

/// s = (1 - b) s_displaced + b s_deformed, n likewise (6.6.6).
void blend_with_solid(const SurfelCloud& displaced, SurfelCloud& cloud, SurfelNotes& notes) {
    parallel_for(cloud.size(), [&](std::size_t i) {
        const Real b = notes.melt[i];
        if (!(b < 1)) return;
        if (notes.lost[i]) {
            // Solid matter keeps its surface, but for what is buried as it melts: where it has folded or two faces were
            // pressed together, nothing is left to see, and what stays would cut the coats of walls short.
            notes.lost[i] = b > (static_cast<Fate>(notes.lost[i]) == Fate::buried ? Real(0) : Real(0.5));
            cloud.position[i] = displaced.position[i];
            cloud.normal[i] = displaced.normal[i];
            return;
        }
        cloud.position[i] = (1 - b) * displaced.position[i] + b * cloud.position[i];
        const Vec3 n = (1 - b) * displaced.normal[i] + b * cloud.normal[i];
        cloud.normal[i] = n.norm() > 0 ? Vec3(n.normalized()) : displaced.normal[i];
    });
}

}  // namespace

SurfaceReport update_surface(SurfaceState& surface, Particles& particles, const Walls& walls,
                             const scene::Surface& params, Real spacing, Real support, const std::vector<Mould>& moulds,
                             Zombies* zombies) {
    const Real full_radius = Real(params.radius) * spacing;
    const bool first = surface.size() == 0;
    SurfelNotes notes;
    notes.component = components(surface, particles);
    notes.lost.assign(surface.size(), 0);
    displace(surface, particles, notes.component, support);
    notes.melt = melt_of(surface, particles, notes.component, support);
    if (zombies) displace_zombies(particles, support, *zombies);

    LiquidPoints points = gather_liquid(particles, walls, support);
    set_colours(points, support);
    for (std::size_t c = 0; c < std::min(points.part.size(), surface.lift.size()); ++c)
        points.part[c].lift = surface.lift[c];
    const LiquidShape shape{points, walls, support, spacing, Real(params.iso)};
    SurfelCloud& cloud = surface.surfels;
    notes.curvature.resize(surface.size());
    notes.radius.resize(surface.size());
    notes.wall.resize(surface.size());
    notes.colour.resize(surface.size());
    parallel_for(surface.size(), [&](std::size_t i) {
        notes.curvature[i] = shape.curvature(cloud.position[i], cloud.normal[i], notes.component[i], notes.wall[i]);
        notes.radius[i] = notes.melt[i] > 0 ? fitting_radius(notes.curvature[i], full_radius) : cloud.axis2[i].norm();
    });
    SurfaceReport report;
    const auto refill = [&] {
        const ResampleReport r = resample(surface, notes, shape, particles, params);
        report.inserted += r.inserted;
        report.deleted += r.deleted;
    };
    if (first) refill();  // one surfel a surface particle, then all between them
    const bool all_liquid = std::ranges::all_of(notes.melt, [](Real b) { return b == 1; });
    const SurfelCloud displaced = all_liquid ? SurfelCloud{} : cloud;
    const RelaxReport relaxed = relax({cloud.position, cloud.normal, notes.component, notes.radius, notes.curvature,
                                       notes.wall, notes.colour, notes.lists, notes.melt, notes.lost},
                                      shape, params, moulds);
    if (!all_liquid) blend_with_solid(displaced, cloud, notes);
    report.iterations = relaxed.iterations;
    report.largest_move = relaxed.largest_move;
    refill();

    fit_axes(cloud, notes, shape, Real(params.support) * full_radius);
    const bool calm = 100 * (report.inserted + report.deleted) < surface.size();
    hold_volume(surface, particles, notes, full_radius, spacing, calm);
    if (zombies) {
        project_zombies(surface, notes.component, notes.melt, Real(params.support) * full_radius, *zombies);
        take_rest_of_zombies(*zombies, notes.component, notes.melt, support, surface);
    }
    interpolate_attributes(surface, particles, notes.component, support);
    sort_by_cell_and_id(surface, Real(params.support) * full_radius);
    particles.surface_position = particles.position;
    return report;
}

}  // namespace thixo
