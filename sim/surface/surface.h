// The animated surface (spec: chapter 6.6 of the dissertation): surfels that follow the particles.
#pragma once

#include <concepts>
#include <cstdint>
#include <vector>

#include "pipeline/contract/scene.h"
#include "pipeline/geometry/surfel.h"
#include "sim/space/walls.h"
#include "sim/state/particles.h"
#include "sim/surface/mould.h"

namespace thixo {

/// The surface's whole state between updates. It is part of a checkpoint.
struct SurfaceState {
    SurfelCloud surfels;
    std::vector<std::int64_t> id;    // unique for ever
    std::vector<std::int32_t> body;  // of the particles it belongs to
    std::vector<Vec3> rest;          // m0: where the surfel was made [m]
    std::vector<Vec3> velocity;      // of the material at the surfel [m/s]
    std::vector<Real> temperature;   // degC
    std::int64_t next_id = 0;
    std::vector<Real> lift;       // by component (material): of the surface over dispersed matter's iso-surface [m]
    std::int32_t unmeasured = 0;  // number of updates before the volume is measured again

    std::size_t size() const { return id.size(); }
};

template <class S, class F>
void for_each_field(S& s, F&& f) requires std::same_as<std::remove_const_t<S>, SurfaceState> {
    f("position", Life::state, s.surfels.position);
    f("axis1", Life::state, s.surfels.axis1);
    f("axis2", Life::state, s.surfels.axis2);
    f("normal", Life::state, s.surfels.normal);
    f("id", Life::state, s.id);
    f("body", Life::state, s.body);
    f("rest", Life::state, s.rest);
    f("velocity", Life::state, s.velocity);
    f("temperature", Life::state, s.temperature);
}

/// Where the time of an update went [s].
struct SurfaceSeconds {
    double displacing = 0;  // surfels and zombies, with the melt about each
    double field = 0;       // particles and images that the colour field sums, curvature
    double relaxing = 0;    // the potentials' iterations
    double resampling = 0;
    double fitting = 0;  // axes and ends of discs
    double volume = 0;
    double texture = 0;  // zombies, attributes, order
};
inline void add(const SurfaceSeconds& a, SurfaceSeconds& sum) {
    sum.displacing += a.displacing;
    sum.field += a.field;
    sum.relaxing += a.relaxing;
    sum.resampling += a.resampling;
    sum.fitting += a.fitting;
    sum.volume += a.volume;
    sum.texture += a.texture;
}

/// What an update did, for stats.jsonl.
struct SurfaceReport {
    std::size_t inserted = 0, deleted = 0;
    int iterations = 0;
    Real largest_move = 0;    // [m] of the last iteration
    int unconverged = 0;      // projections that hit their cap on steps
    double volume_error = 0;  // relative, as hold_volume found it [1]
    SurfaceSeconds seconds;
};

struct Zombies;

/// The constant input of an update. `spacing` is the particle spacing [m], `support` the particle kernel support h [m].
/// The moulds are those of `params`.
struct SurfaceSetting {
    const Walls& walls;
    const scene::Surface& params;
    Real spacing, support;
    const std::vector<Mould>& moulds;
};

/// Brings the surface up to date with the particles: displace, deform by the potentials, constrain, resample. The first
/// call (no surfels yet) makes one surfel for each surface particle and refines. Sets particles.surface_position =
/// position. Where matter has melted, `zombies` move with the surface and give surfels their m0. With `members`, which
/// ascend, the surface is that of these particles alone.
SurfaceReport update_surface(SurfaceState& surface, Particles& particles, const SurfaceSetting& setting,
                             Zombies* zombies = nullptr, const std::vector<Index>* members = nullptr);

}  // namespace thixo
