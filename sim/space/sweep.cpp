#include "sim/space/sweep.h"

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"

namespace thixo {

void pack_motion(const Particles& particles, double last_dt, bool impulses, Sweep& sweep) {
    const std::size_t n = particles.size();
    const Real half = static_cast<Real>(0.5 * last_dt);
    THIXO_ASSERT(sweep.ghosts.particles == n, "ghosts of {} particles for {}", sweep.ghosts.particles, n);
    resize_packed(sweep.ghosts, sweep.place, {Real(1e9), Real(1e9), Real(1e9), 0});
    resize_packed(sweep.ghosts, sweep.motion, {0, 0, 0, 0});
    parallel_for(
        n,
        [&](std::size_t i) {
            const Vec3& x = particles.position[i];
            const Real ahead = impulses && particles.pressure[i] > 0 ? Real(0) : half;
            const Vec3 v = particles.velocity[i] + ahead * particles.acceleration[i];
            sweep.place[i] = {x.x(), x.y(), x.z(), particles.rest_volume[i]};
            sweep.motion[i] = {v.x(), v.y(), v.z(), 0};
        },
        2048);
    refresh_places(sweep.ghosts, sweep.place);
    refresh_ghosts(sweep.ghosts, sweep.motion);
}

}  // namespace thixo
