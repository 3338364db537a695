#include "sim/surface/displace.h"

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/near_runs.h"

namespace thixo {
namespace {

constexpr Real kLevel = Real(0.005);  // eps of surfels, in h^2

/// The particles about a place, packed for sums in the order of a grid of them. `places` is an array of their table.
struct Carriers {
    PointGrid grid;
    std::vector<Real> weight, x, y, z, extra, component;  // by slot, padded for lanes

    template <class F>
    Carriers(const std::vector<Vec3>& places, Real support, const ParticleRows& particles, F&& vector_of) {
        std::vector<Vec3> scratch;
        grid.build(particles.values(places, scratch), support);
        const std::size_t n = particles.size();
        const Particles& p = particles.table();
        for (auto* a : {&weight, &x, &y, &z, &extra, &component}) a->resize(n + PointGrid::kPadding, 0);
        parallel_for(n, [&](std::size_t slot) {
            const Index j = particles.row(grid.index(static_cast<Index>(slot)));
            const Vec3 v = vector_of(j);
            weight[slot] = p.rest_volume[j];
            x[slot] = v.x();
            y[slot] = v.y();
            z[slot] = v.z();
            extra[slot] = static_cast<Real>(p.temperature[j]);
            component[slot] = static_cast<Real>(p.material[j]);
        });
    }
    /// Calls f(slot, a, dx, dy, dz) for runs of the particles about a place. The weight a is V0 (1 - r^2/h^2)^3 for
    /// those of the component, 0 for others.
    template <class F>
    void for_each_run(const Vec3& at, std::int32_t of, F&& f) const {
        const Real h = grid.cell(), per_h2 = 1 / square(h);
        const Lanes same = all_lanes(static_cast<Real>(of));
        for_each_near_run(grid, at, h, [&](Index slot, Lanes dx, Lanes dy, Lanes dz, Lanes r2) {
            const Lanes q = positive(1 - r2 * per_h2);
            const Lanes a = load_lanes(&weight[slot]) * q * q * q;
            f(slot, load_lanes(&component[slot]) == same ? a : Lanes{}, dx, dy, dz);
        });
    }
};

LocalMotion motion_at(const Vec3& place, std::int32_t component, const Carriers& particles, Real level) {
    Lanes w{}, mx{}, my{}, mz{}, ux{}, uy{}, uz{};
    Lanes xx{}, xy{}, xz{}, yy{}, yz{}, zz{}, c[3][3]{};
    particles.for_each_run(place, component, [&](Index slot, Lanes a, Lanes x, Lanes y, Lanes z) {
        const Lanes ax = a * x, ay = a * y, az = a * z;
        w += a;
        mx += ax;
        my += ay;
        mz += az;
        xx += ax * x;
        xy += ax * y;
        xz += ax * z;
        yy += ay * y;
        yz += ay * z;
        zz += az * z;
        const Lanes u[3] = {load_lanes(&particles.x[slot]), load_lanes(&particles.y[slot]),
                            load_lanes(&particles.z[slot])};
        ux += a * u[0];
        uy += a * u[1];
        uz += a * u[2];
        for (int k = 0; k < 3; ++k) {
            c[k][0] += ax * u[k];
            c[k][1] += ay * u[k];
            c[k][2] += az * u[k];
        }
    });
    LocalMotion motion;
    const Real weight = sum_of(w), support = particles.grid.cell();
    if (!(weight > 0)) return motion;
    const Vec3 mean = Vec3(sum_of(mx), sum_of(my), sum_of(mz)) / weight;
    const Vec3 mean_shift = Vec3(sum_of(ux), sum_of(uy), sum_of(uz)) / weight;
    Mat3 covariance, spread;
    for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l) covariance(k, l) = sum_of(c[k][l]);
    const Real sxy = sum_of(xy), sxz = sum_of(xz), syz = sum_of(yz);
    spread << sum_of(xx), sxy, sxz, sxy, sum_of(yy), syz, sxz, syz, sum_of(zz);
    // Per unit of weight and of h^2: otherwise the determinant of a stencil with points near the rim alone underflows.
    const Real scale = 1 / square(support);
    covariance = scale * (covariance / weight - mean_shift * mean.transpose());
    spread = scale * (spread / weight - mean * mean.transpose());
    // A full neighbourhood spreads by 0.09 h^2 each way.
    spread += level * Mat3::Identity();
    motion.gradient = covariance * spread.inverse();
    motion.shift = mean_shift - motion.gradient * mean;
    return motion;
}

}  // namespace

Vec3 LocalMotion::turned(const Vec3& normal) const {
    const Mat3 stretch = Mat3::Identity() + gradient;
    if (std::abs(stretch.determinant()) < Real(0.05)) return normal;  // torn, not deformed: the old normal is better
    const Vec3 n = (stretch.inverse().transpose() * normal).normalized();
    return n.allFinite() ? n : normal;
}

void for_each_motion(const std::vector<Vec3>& places, const ParticleRows& particles,
                     const std::vector<std::int32_t>& component, Real support, Real level,
                     const std::function<void(std::size_t, const LocalMotion&)>& act) {
    const Particles& p = particles.table();
    const Carriers carriers(p.surface_position, support, particles,
                            [&](Index j) -> Vec3 { return p.position[j] - p.surface_position[j]; });
    parallel_for(places.size(), [&](std::size_t i) { act(i, motion_at(places[i], component[i], carriers, level)); });
}

void displace(SurfaceState& surface, const ParticleRows& particles, const std::vector<std::int32_t>& component,
              Real support, Real longest) {
    SurfelCloud& cloud = surface.surfels;
    // Discs stretch with their matter: otherwise a stretched or squashed solid would show gaps between them.
    const auto carried = [&](const Vec3& axis, const Mat3& stretch, const Vec3& n) -> Vec3 {
        Vec3 t = stretch * axis;
        t -= n * n.dot(t);
        const Real most = std::max(longest, axis.norm()), length = t.norm();
        return length > most ? Vec3(t * (most / length)) : t;
    };
    for_each_motion(cloud.position, particles, component, support, kLevel,
                    [&](std::size_t i, const LocalMotion& motion) {
                        cloud.position[i] += motion.shift;
                        const Mat3 stretch = Mat3::Identity() + motion.gradient;
                        if (std::abs(stretch.determinant()) < Real(0.05)) return;
                        const Vec3 n = motion.turned(cloud.normal[i]);
                        const Vec3 a = carried(cloud.axis1[i], stretch, n), b = carried(cloud.axis2[i], stretch, n);
                        // A disc squashed to a line keeps its axes: they are fitted anew where it melts.
                        if (!n.allFinite() || !(a.cross(b).norm() > Real(1e-3) * a.norm() * b.norm())) return;
                        cloud.normal[i] = n;
                        cloud.axis1[i] = a;
                        cloud.axis2[i] = b;
                    });
}

void interpolate_attributes(SurfaceState& surface, const ParticleRows& particles,
                            const std::vector<std::int32_t>& component, Real support) {
    const Particles& p = particles.table();
    const Carriers carriers(p.position, support, particles, [&](Index j) { return p.velocity[j]; });
    parallel_for(surface.size(), [&](std::size_t i) {
        Lanes w{}, heat{}, vx{}, vy{}, vz{};
        Real most = 0;
        Index nearest = kNone;
        carriers.for_each_run(surface.surfels.position[i], component[i],
                              [&](Index slot, Lanes a, Lanes dx, Lanes dy, Lanes dz) {
                                  w += a;
                                  heat += a * load_lanes(&carriers.extra[slot]);
                                  vx += a * load_lanes(&carriers.x[slot]);
                                  vy += a * load_lanes(&carriers.y[slot]);
                                  vz += a * load_lanes(&carriers.z[slot]);
                                  const Lanes near = a > 0 ? 1 / (dx * dx + dy * dy + dz * dz + Real(1e-30)) : Lanes{};
                                  for_each_set_lane(near > most, [&](Index l) {
                                      if (!(near[l] > most)) return;
                                      most = near[l];
                                      nearest = slot + l;
                                  });
                              });
        const Real weight = sum_of(w);
        if (nearest == kNone || !(weight > 0)) return;
        surface.velocity[i] = Vec3(sum_of(vx), sum_of(vy), sum_of(vz)) / weight;
        surface.temperature[i] = sum_of(heat) / weight;
        surface.body[i] = p.body[particles.row(carriers.grid.index(nearest))];
    });
}

}  // namespace thixo
