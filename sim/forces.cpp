#include "sim/forces.h"

#include <cmath>

#include "pipeline/base/parallel.h"

namespace thixo {
namespace {

Vec3 xyz(const Quad& q) { return {q.x, q.y, q.z}; }

}  // namespace

void compute_accelerations(Particles& particles, const NeighbourLists& neighbours, const Smoothing& smoothing, const ForceParams& params,
                           const Sweep& sweep) {
    const Spiky spiky = smoothing.pressure;
    const ViscosityKernel viscous = smoothing.viscosity;
    const Real s = smoothing.support / 2;
    const Real softening = Real(0.01) * square(s);
    const Real artificial = params.artificial_viscosity * s;
    parallel_for(particles.size(), [&](std::size_t i) {
        const Quad x = sweep.place[i], v = sweep.motion[i], m = sweep.matter[i];
        Vec3 f(0, 0, 0);  // force per volume V_i [N/m^3]
        for (const Index j : neighbours[i]) {
            const Quad xj = sweep.place[j], vj = sweep.motion[j], mj = sweep.matter[j];
            const Vec3 r = xyz(x) - xyz(xj);
            const Vec3 u = xyz(v) - xyz(vj);
            const Real r2 = r.squaredNorm();
            const Real length = std::sqrt(r2);
            const Real approach = std::min(u.dot(r), Real(0));
            const Real stress = Real(0.5) * artificial * (m.z + mj.z) * approach / (r2 + softening) - (m.x + mj.x);
            // Two particles in the same place have no direction to part along; viscosity alone acts.
            const Real along = length > 0 ? stress * spiky.derivative(length) / length : Real(0);
            const Real drag = Real(0.5) * (m.y + mj.y) * viscous.laplacian(length);
            f += vj.w * (along * r - drag * u);
        }
        const WallEffect& w = sweep.walls[i];
        f -= std::max(m.x, Real(0)) * w.gradient;
        f += 2 * m.y * (w.drag_velocity - w.drag * xyz(v));
        particles.acceleration[i] = params.gravity + v.w / particles.mass[i] * f;
    });
}

}  // namespace thixo
