#include "sim/loop/surface_updates.h"

#include <cmath>

#include "pipeline/base/parallel.h"
#include "pipeline/base/timer.h"
#include "sim/fracture/frozen.h"
#include "sim/fracture/sheets.h"
#include "sim/surface/contact_surface.h"

namespace thixo {
namespace {

constexpr double kDue = 0.05;                 // share of stirred particles at which an update is due
constexpr double kFar = 0.002;                // share at which one update is not enough
constexpr double kHeld = 0.01, kGain = 0.95;  // error of the volume that is good enough; what a further update must do
constexpr int kMostAgain = 6;

double surfel_support(const Simulation& sim) {
    const scene::Surface& params = sim.problem.scene.surface;
    return params.support * params.radius * static_cast<double>(sim.problem.smoothing.spacing);
}

/// Share of the particles that are stirred. Since the last update they have moved against the mean of their neighbours
/// by more than a quarter of the surfel support (dissertation 6.6). Surfels are carried by the displacement of the
/// particles about them. That is exact where it is affine: a jet in free flight, a drop by itself and a body that turns
/// stir nothing. No scene with periodic axes has a surface, so lists name no ghosts.
double stirred_share(const Simulation& sim) {
    const auto& x = sim.particles.position;
    const auto& x0 = sim.particles.surface_position;
    const std::size_t n = sim.neighbours.size();
    if (n == 0) return 0;
    const Real limit2 = square(static_cast<Real>(surfel_support(sim) / 4));
    const double stirred = parallel_sum(n, [&](std::size_t i) {
        const auto near = sim.neighbours[i];
        if (near.empty()) return 0.0;
        Vec3 sum(0, 0, 0);
        for (const Index j : near) sum += x[j] - x0[j];
        const Real against = (x[i] - x0[i] - sum / static_cast<Real>(near.size())).squaredNorm();
        return against > limit2 ? 1.0 : 0.0;
    });
    return stirred / static_cast<double>(n);
}

bool asked_between_frames(const Simulation& sim) { return !sim.solids.empty() || !sim.problem.moulds.empty(); }

/// Whether a particle has moved so far that looking closer pays.
bool anything_moved(const Simulation& sim) {
    const auto& x = sim.particles.position;
    const auto& x0 = sim.particles.surface_position;
    const double moved2 = parallel_reduce(
        x.size(), 0.0, [&](std::size_t i) { return static_cast<double>((x[i] - x0[i]).squaredNorm()); },
        [](double a, double b) { return std::max(a, b); });
    return std::sqrt(moved2) > surfel_support(sim) / 4;
}

}  // namespace

void refresh_surface(Simulation& sim) {
    if (!sim.problem.scene.surface.enabled) return;
    ScopedTimer timer(sim.stats.surface_seconds);
    const Smoothing& smoothing = sim.problem.smoothing;
    const scene::Surface& params = sim.problem.scene.surface;
    const SurfaceSetting setting{sim.walls, params, smoothing.spacing, smoothing.support, sim.problem.moulds};
    if (sim.solids.softening.any && !sim.solids.breaking.empty()) {
        follow_returned(sim.solids, sim.mixed_surface);
        if (embed_frozen(matter_of(sim), sim.mixed_surface)) sim.crack_scratch.matter.clear();
    }
    if (sim.solids.cracks.any()) refresh_sheets(CrackSight(sim.solids), matter_of(sim));
    const SurfaceReport report = sim.solids.empty()
                                     ? update_surface(sim.surface, sim.particles, setting)
                                     : update_mixed_surface(sim.embedded, sim.solids, sim.particles, setting,
                                                            sim.mixed_surface, sim.surface, sim.embedded_source);
    if (!sim.solids.empty() && !sim.solids.softening.any)
        draw_contacts(sim.embedded, sim.embedded_source, sim.walls, sim.solids, sim.surface);
    SurfaceReport& sum = sim.stats.surface;
    const SurfaceReport before = sum;
    sum = report;
    sum.inserted += before.inserted;
    sum.deleted += before.deleted;
    add(before.seconds, sum.seconds);
    ++sim.stats.surface_updates;
}

void update_surface_when_due(const Plan& plan, Simulation& sim) {
    if (!sim.problem.scene.surface.enabled || !plan.liquid || !asked_between_frames(sim)) return;
    // A single particle is not enough: in a splash some drop always moves that far.
    if (anything_moved(sim) && stirred_share(sim) > kDue) refresh_surface(sim);
}

void make_frame_surface(Simulation& sim) {
    const bool may_need_more = sim.problem.scene.surface.enabled && !asked_between_frames(sim) && anything_moved(sim);
    const bool far = may_need_more && stirred_share(sim) > kFar;
    refresh_surface(sim);
    double error = far ? 1 : 0;
    for (int again = 0; again < kMostAgain && error > kHeld; ++again) {
        refresh_surface(sim);
        const double now = sim.stats.surface.volume_error;
        if (now > kGain * error) return;
        error = now;
    }
}

}  // namespace thixo
