// Sources: openings, discs or of any form, that release hexagonally packed layers. Dissertation 4.2.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "pipeline/contract/scene.h"
#include "pipeline/geometry/keyframes.h"
#include "pipeline/geometry/shape.h"
#include "sim/space/periodic.h"
#include "sim/space/smoothing.h"
#include "sim/space/walls.h"
#include "sim/state/materials.h"
#include "sim/state/particles.h"

namespace thixo {

/// The room that a new particle needs to the next one, of which two sites of the packing have 1.12, and to a wall.
inline constexpr Real kRoomToParticle = Real(0.7), kRoomToWall = Real(0.3);  // spacings

/// What an emitter's matter leaves through, where it stands before the motion.
struct Opening {
    std::optional<Shape> shape{};  // it is cut by the plane through the emitter's position; none: a disc
    double radius = 0;             // about the position, all of the opening lies within [m]
    double area = 0;               // [m^2]
};

/// Throws InputError where the shape does not meet the plane, or has no bounds. The area of a shape's cut is summed over
/// cells of an eighth of a spacing, or of 1/512 of its width where that is more. That of a surface is all of it, and a
/// volume has none.
Opening opening_of(const scene::Scene& scene, const scene::Emitter& emitter);

/// Speed of what leaves an opening [m/s]: the emitter's, or rate/area. What fills a volume may have none.
inline double flow_speed(const scene::Emitter& emitter, double area) {
    const bool given = emitter.speed > 0 || emitter.source == scene::SourceForm::volume;
    return given ? emitter.speed : emitter.rate / area;
}
/// Volume that flows out [m^3/s].
inline double flow_rate(const scene::Emitter& emitter, double area) {
    return emitter.source == scene::SourceForm::volume ? emitter.rate : area * flow_speed(emitter, area);
}

/// The instant that follows `from` by `interval` of flowing time [s]; emitter.stop where switches leave too little.
double flow_time_after(const scene::Emitter& emitter, double from, double interval);
/// Seconds of flowing time from the start to `end` [s].
double flow_seconds(const scene::Emitter& emitter, double end);

/// Where a particle of a spread source begins, in the scene before the motion.
struct SpreadSite {
    Vec3 at, along;  // [m]; unit, the direction of flow
};

/// What an emitter releases, worked out once: the sites of two alternating layers of the packing that lie in the
/// opening.
/// They stand in the emitter's own frame: z is the direction of flow, the origin the centre.
struct EmitterLayout {
    std::vector<Vec3> layers[2];     // [m], z = 0
    std::vector<SpreadSite> spread;  // of a surface or a volume, in place of layers
    Mat3d turn = Mat3d::Identity();  // own frame -> scene, before the motion
    Vec3d centre{0, 0, 0};           // [m]
    RigidMotion motion;
    Opening opening;
    double speed = 0;  // of the flow [m/s]
    double mass = 0;   // of a particle [kg]
    double flow = 0;   // rho0 area speed [kg/s]
    int body = 0, material = 0;
};

/// Where it stands; part of a checkpoint.
struct EmitterState {
    std::int64_t layer = 0;    // number of the next layer
    double next = 0;           // when it is due [s]
    std::int64_t due = 0;      // sites of all layers so far
    std::int64_t blocked = 0;  // particles of these not made because their place was taken
    bool pushing = false;      // a layer has met fluid once: from then on the fluid at the opening is driven on
};

/// All emitters of a scene, and what they release into.
struct Sources {
    const std::vector<scene::Emitter>& emitters;
    const std::vector<EmitterLayout>& layouts;  // one an emitter
    const Smoothing& smoothing;
    const Walls& walls;
    Vec3 gravity;  // [m/s^2]
    const Periodic& periodic;
    std::uint64_t seed;  // of jitter
};

/// Sites of a layer in the mean: area of the opening over the area of a site.
double sites_of_opening(double area, double spacing);

/// Lays out an emitter's layers. The packing is shifted over the opening until its two layers hold closest to the mean
/// number of sites, area / (area of a site). Time balances the remainder: layer n follows the one before after
///     n_particles m / (rho0 area speed)      [s]
/// So the mass rate is exact. A spread source releases single particles in the same way (spread.h).
EmitterLayout lay_out_emitter(const scene::Scene& scene, const scene::Emitter& emitter,
                              const ResolvedMaterial& material, Real spacing);

/// Releases every layer that is due by `time` [s]. A particle that left the disc at t_k starts where free flight has
/// brought it by now. Nothing overlaps what is there, across periodic faces too:
/// - A layer stands back from walls by 0.3 spacings. One flush with a wall starts up to a spacing farther on. Where that
///   does not help (a pipe about it), sites on the free side of the wall are taken. Sites within walls are left out.
/// - A layer whose sites come within 0.7 spacings of other particles has flown less far, or waits. It is given up when
///   four more are due. Once a layer has waited, the emitter pushes (drive_openings).
/// Ids count up from next_id in order of emitter, layer and site. `last_dt` is the step that led to `time`: velocities
/// are stored half of it back.
void emit_particles(const Sources& sources, double time, double last_dt, std::vector<EmitterState>& states,
                    Particles& particles, std::int64_t& next_id);

/// Sites of an emitter's two layers, and those of them that walls leave no room for at a time [s].
struct OpeningRoom {
    std::int64_t sites = 0, blocked = 0;
};
OpeningRoom room_at_opening(const Sources& sources, std::size_t emitter, double time);

/// Drives the liquid before emitters that push. Up to two spacings ahead of the disc it gets the velocity of the flow.
/// None passes the disc from behind. Returns the particles ahead: other forces may not change their velocities in this
/// step. Of those behind the acceleration is cleared, and pressure may still move them.
std::vector<Index> drive_openings(const Sources& sources, double time, const std::vector<EmitterState>& states,
                                  Particles& particles);

}  // namespace thixo
