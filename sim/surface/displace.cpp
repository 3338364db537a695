#include "sim/surface/displace.h"

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/kernels.h"
#include "pipeline/geometry/point_grid.h"

namespace thixo {
namespace {

struct LocalMotion {
    Vec3 shift{0, 0, 0};           // u(s) [m]
    Mat3 gradient = Mat3::Zero();  // G [1]
};

LocalMotion motion_at(const Vec3& s, std::int32_t component, const Particles& p, const PointGrid& old_grid,
                      Real support) {
    const Poly6 w(support);
    Real weight = 0;
    Vec3 mean(0, 0, 0), mean_shift(0, 0, 0);
    Mat3 spread = Mat3::Zero(), covariance = Mat3::Zero();
    old_grid.for_each_neighbour(s, support, [&](Index j, Real r2) {
        if (p.material[j] != component) return;
        const Real a = p.rest_volume[j] * w.value(r2);
        const Vec3 x = p.surface_position[j] - s, u = p.position[j] - p.surface_position[j];
        weight += a;
        mean += a * x;
        mean_shift += a * u;
        covariance += (a * u) * x.transpose();
        spread += (a * x) * x.transpose();
    });
    LocalMotion motion;
    if (!(weight > 0)) return motion;
    // Per unit of weight and of h^2, or the determinant of a stencil that has only points near the rim underflows.
    const Real scale = 1 / square(support);
    mean /= weight;
    mean_shift /= weight;
    covariance = scale * (covariance / weight - mean_shift * mean.transpose());
    spread = scale * (spread / weight - mean * mean.transpose());
    // A full neighbourhood spreads by 0.09 h^2 each way.
    spread += Real(0.005) * Mat3::Identity();
    motion.gradient = covariance * spread.inverse();
    motion.shift = mean_shift - motion.gradient * mean;
    return motion;
}

}  // namespace

void displace(SurfaceState& surface, const Particles& particles, const std::vector<std::int32_t>& component,
              Real support) {
    PointGrid old_grid;
    old_grid.build(particles.surface_position, support);
    SurfelCloud& cloud = surface.surfels;
    parallel_for(surface.size(), [&](std::size_t i) {
        const LocalMotion motion = motion_at(cloud.position[i], component[i], particles, old_grid, support);
        cloud.position[i] += motion.shift;
        const Mat3 stretch = Mat3::Identity() + motion.gradient;
        if (std::abs(stretch.determinant()) < Real(0.05)) return;  // torn, not deformed: the old normal says more
        const Vec3 n = (stretch.inverse().transpose() * cloud.normal[i]).normalized();
        // The first axis keeps its direction as far as the new plane allows, so that colour and texture do not spin.
        const Real r1 = cloud.axis1[i].norm(), r2 = cloud.axis2[i].norm();
        Vec3 t = stretch * cloud.axis1[i];
        t -= n * n.dot(t);
        if (!(t.squaredNorm() > 0) || !n.allFinite()) return;
        t.normalize();
        cloud.normal[i] = n;
        cloud.axis1[i] = r1 * t;
        cloud.axis2[i] = r2 * n.cross(t);
    });
}

void interpolate_attributes(SurfaceState& surface, const Particles& particles,
                            const std::vector<std::int32_t>& component, Real support) {
    PointGrid grid;
    grid.build(particles.position, support);
    const Poly6 w(support);
    parallel_for(surface.size(), [&](std::size_t i) {
        Real weight = 0, heat = 0, nearest = std::numeric_limits<Real>::max();
        Vec3 velocity(0, 0, 0);
        std::int32_t body = surface.body[i];
        grid.for_each_neighbour(surface.surfels.position[i], support, [&](Index j, Real r2) {
            if (particles.material[j] != component[i]) return;
            const Real a = particles.rest_volume[j] * w.value(r2);
            weight += a;
            velocity += a * particles.velocity[j];
            heat += a * particles.temperature[j];
            if (r2 < nearest) {
                nearest = r2;
                body = particles.body[j];
            }
        });
        if (!(weight > 0)) return;
        surface.velocity[i] = velocity / weight;
        surface.temperature[i] = heat / weight;
        surface.body[i] = body;
    });
}

}  // namespace thixo
