#include "sim/liquid/leapfrog.h"

#include "pipeline/base/parallel.h"

namespace thixo {

void leapfrog(Particles& particles, double last_dt, double dt) {
    const Real kick = static_cast<Real>(0.5 * (last_dt + dt));
    const Real drift = static_cast<Real>(dt);
    parallel_for(
        particles.size(),
        [&](std::size_t i) {
            if (is_elastic(particles.phase[i])) return;
            particles.velocity[i] += kick * particles.acceleration[i];
            particles.position[i] += drift * particles.velocity[i];
        },
        2048);
}

}  // namespace thixo
