#include "tests/sim/surface/liquid_fixture.h"

#include "pipeline/base/random.h"

namespace thixo {
namespace {
std::function<double(const Vec3d&)> wall_function;
}

// The surface's only view of walls; the simulation has its own, from shapes.
Real wall_distance(const Walls&, const Vec3& x) {
    return wall_function ? static_cast<Real>(wall_function(x.cast<double>())) : std::numeric_limits<Real>::max();
}
WallContact wall_contact(const Walls& walls, const Vec3& x) {
    WallContact contact{wall_distance(walls, x), Vec3(0, 0, 1), Vec3(0, 0, 0)};
    if (!wall_function) return contact;
    Vec3d slope;
    for (int axis = 0; axis < 3; ++axis) {
        const Vec3d e = 1e-6 * Vec3d::Unit(axis);
        slope[axis] = wall_function(x.cast<double>() + e) - wall_function(x.cast<double>() - e);
    }
    contact.normal = slope.normalized().cast<Real>();
    return contact;
}

namespace fixture {

void set_walls(std::function<double(const Vec3d&)> distance) { wall_function = std::move(distance); }

Particles liquid(const std::vector<Vec3>& places) {
    Particles p;
    const std::size_t n = places.size();
    for (std::size_t i = 0; i < n; ++i) p.id.push_back(static_cast<std::int64_t>(i));
    p.position = p.surface_position = places;
    p.velocity.assign(n, Vec3(0, 0, 0));
    p.acceleration.assign(n, Vec3(0, 0, 0));
    p.rest_volume.assign(n, Real(kSpacing * kSpacing * kSpacing));
    p.melt.assign(n, 1);
    p.mass.assign(n, Real(1000 * kSpacing * kSpacing * kSpacing));
    p.density.assign(n, 1000);
    p.pressure.assign(n, 0);
    p.temperature.assign(n, 20);
    p.material.assign(n, 0);
    p.body.assign(n, 0);
    p.phase.assign(n, Phase::liquid);
    return p;
}

std::vector<Vec3> packed(const Vec3d& lower, const Vec3d& upper, double shake,
                         const std::function<bool(const Vec3d&)>& inside) {
    const double a = kSpacing * std::pow(2.0, 1.0 / 6), row = a * std::sqrt(3.0) / 2, layer = a * std::sqrt(2.0 / 3);
    std::vector<Vec3> places;
    std::uint64_t site = 0;
    for (int k = 0; lower.z() + (k + 0.5) * layer < upper.z(); ++k)
        for (int j = 0; lower.y() + (j + 0.25 + k % 2 * 2 / 3.0) * row < upper.y(); ++j)
            for (int i = 0; lower.x() + (i + 0.25 + (j + k) % 2 / 2.0) * a < upper.x(); ++i) {
                const Vec3d p = lower + Vec3d((i + 0.25 + (j + k) % 2 / 2.0) * a, (j + 0.25 + k % 2 * 2 / 3.0) * row,
                                              (k + 0.5) * layer);
                ++site;
                if (!inside(p)) continue;
                const auto shift = [&](int use) { return (2 * random_unit(1, site, 0, use) - 1) * shake * kSpacing; };
                places.push_back((p + Vec3d(shift(0), shift(1), shift(2))).cast<Real>());
            }
    return places;
}

std::vector<Vec3> packed_ball(double radius, double shake) {
    return packed(Vec3d::Constant(-radius), Vec3d::Constant(radius), shake,
                  [&](const Vec3d& p) { return p.norm() < radius; });
}

std::vector<Vec3> stacked(int nx, int ny, int nz, double shake, const std::function<bool(const Vec3d&)>& inside) {
    std::vector<Vec3> places;
    std::uint64_t site = 0;
    for (int k = 0; k < nz; ++k)
        for (int j = 0; j < ny; ++j)
            for (int i = 0; i < nx; ++i) {
                const Vec3d p = kSpacing * Vec3d(i + 0.5, j + 0.5, k + 0.5);
                ++site;
                if (!inside(p)) continue;
                const auto shift = [&](int use) { return (2 * random_unit(1, site, 0, use) - 1) * shake * kSpacing; };
                places.push_back((p + Vec3d(shift(0), shift(1), shift(2))).cast<Real>());
            }
    return places;
}

SurfaceReport update(SurfaceState& surface, Particles& particles, const scene::Surface& params) {
    return update_surface(surface, particles, {Walls{}, params, Real(kSpacing), Real(kSupport), {}});
}

}  // namespace fixture
}  // namespace thixo
