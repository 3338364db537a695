// Sources that are no opening: matter begins all over a surface, or throughout a volume.
#pragma once

#include "sim/sources/emitter.h"

namespace thixo {

/// Sites half a spacing off a surface, one to each square of a spacing, or those of the packing in a volume. Throws
/// InputError where there is none.
std::vector<SpreadSite> spread_sites(const scene::Emitter& emitter, const Shape& shape, Real spacing);

struct EmissionTime {
    double now, last_dt;  // [s]
};

/// Releases every particle that is due, at intervals of m/(rho0 rate) [s]. The sites take turns. A site is passed over
/// where a wall is nearer than 0.3 spacings or another particle nearer than 0.7. Where no site is free the particle
/// waits, and is given up when four more are due.
void emit_spread(const Sources& sources, std::size_t emitter, const EmissionTime& time, EmitterState& state,
                 Particles& particles, std::int64_t& next_id);

OpeningRoom room_of_spread(const Sources& sources, std::size_t emitter, double time);

/// A particle of an emitter at a place [m] with a velocity [m/s].
void add_emitted(const Sources& sources, std::size_t emitter, const Vec3& place, const Vec3d& velocity, std::int64_t id,
                 Particles& particles);

}  // namespace thixo
