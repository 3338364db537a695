#include "sim/surface/surface.h"

#include <algorithm>

#include "pipeline/base/parallel.h"
#include "pipeline/base/timer.h"
#include "sim/surface/displace.h"
#include "sim/surface/fit_discs.h"
#include "sim/surface/interpolate.h"
#include "sim/surface/liquid_shape.h"
#include "sim/surface/potentials.h"
#include "sim/surface/resample.h"
#include "sim/surface/volume.h"
#include "sim/surface/zombies.h"

namespace thixo {
namespace {

/// Largest stretch of a solid's disc, in radii of a liquid's.
constexpr Real kLongestDisc = Real(1.5);

void sort_by_cell_and_id(SurfaceState& surface, Real support) {
    const auto order = PointGrid::sort_order(surface.surfels.position, surface.id, support);
    ReorderScratch scratch;
    reorder_table(surface, order, scratch);
}

/// b of every surfel: the normalised interpolation of the particles' (6.6.6).
std::vector<Real> melt_of(const SurfaceState& surface, const ParticleRows& particles,
                          const std::vector<std::int32_t>& component, Real support) {
    std::vector<Real> melt(surface.size(), 1);
    const Particles& p = particles.table();
    bool all_liquid = true;
    for (std::size_t k = 0; k < particles.size() && all_liquid; ++k) all_liquid = p.melt[particles.row(k)] == 1;
    if (all_liquid) return melt;
    interpolate(
        surface.surfels.position, particles, support,
        [&](std::size_t i, Index j) { return p.material[j] == component[i]; }, [&](Index j) { return p.melt[j]; },
        [&](std::size_t i, double b) { melt[i] = std::min(static_cast<Real>(b), Real(1)); });
    return melt;
}

/// Blends with the displaced solid surface, normals likewise (6.6.6):
///     s = (1 - b) s_displaced + b s_deformed
void blend_with_solid(const SurfelCloud& displaced, SurfelCloud& cloud, SurfelNotes& notes) {
    parallel_for(cloud.size(), [&](std::size_t i) {
        const Real b = notes.melt[i];
        if (!(b < 1)) return;
        if (notes.lost[i]) {
            // Solid matter keeps its surface, but for surfels that are buried as it melts. Where it has folded, or two
            // faces were pressed together, they are no longer visible, and would cut the coats of walls short.
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

SurfaceReport update_surface(SurfaceState& surface, Particles& particles, const SurfaceSetting& setting,
                             Zombies* zombies, const std::vector<Index>* members) {
    const ParticleRows matter(particles, members);
    const Walls& walls = setting.walls;
    const scene::Surface& params = setting.params;
    const Real spacing = setting.spacing, support = setting.support;
    const Real full_radius = Real(params.radius) * spacing;
    const bool first = surface.size() == 0;
    SurfaceReport report;
    double lap = wall_seconds();
    const auto book = [&lap](double& seconds) {
        const double now = wall_seconds();
        seconds += now - lap;
        lap = now;
    };
    SurfelNotes notes;
    notes.component = components(surface, matter);
    notes.lost.assign(surface.size(), 0);
    displace(surface, matter, notes.component, support, kLongestDisc * full_radius);
    notes.melt = melt_of(surface, matter, notes.component, support);
    if (zombies) displace_zombies(matter, support, *zombies);
    book(report.seconds.displacing);

    LiquidPoints points = gather_liquid(matter, walls, support);
    set_colours(points, support, spacing);
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
    book(report.seconds.field);
    const auto refill = [&] {
        const ResampleReport r = resample(surface, notes, shape, matter, params);
        report.inserted += r.inserted;
        report.deleted += r.deleted;
        book(report.seconds.resampling);
    };
    if (first) refill();  // the first pass makes one surfel for each surface particle, the second all between them
    const bool all_liquid = std::ranges::all_of(notes.melt, [](Real b) { return b == 1; });
    const SurfelCloud displaced = all_liquid ? SurfelCloud{} : cloud;
    const RelaxReport relaxed = relax({cloud.position, cloud.normal, notes.component, notes.radius, notes.curvature,
                                       notes.wall, notes.colour, notes.lists, notes.melt, notes.lost},
                                      shape, params, setting.moulds);
    if (!all_liquid) blend_with_solid(displaced, cloud, notes);
    book(report.seconds.relaxing);
    report.iterations = relaxed.iterations;
    report.largest_move = relaxed.largest_move;
    retreat_from_creases(cloud, notes, shape, Real(params.support) * full_radius);
    book(report.seconds.fitting);
    refill();

    fit_axes(cloud, notes, shape, Real(params.support) * full_radius);
    book(report.seconds.fitting);
    const bool steady = 100 * (report.inserted + report.deleted) < surface.size();
    report.volume_error = hold_volume(surface, matter, notes, full_radius, spacing, steady);
    book(report.seconds.volume);
    if (zombies) {
        project_zombies(surface, notes.component, notes.melt, Real(params.support) * full_radius, *zombies);
        take_rest_of_zombies(*zombies, notes.component, notes.melt, support, surface);
    }
    interpolate_attributes(surface, matter, notes.component, support);
    sort_by_cell_and_id(surface, Real(params.support) * full_radius);
    particles.surface_position = particles.position;
    book(report.seconds.texture);
    return report;
}

}  // namespace thixo
