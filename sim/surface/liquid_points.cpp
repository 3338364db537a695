#include "sim/surface/liquid_points.h"

#include <numeric>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/kernels.h"

namespace thixo {
namespace {

// s of the outermost layer of particles under a flat surface (0.66 to 0.72, as they are packed), within that range the value that gives a lone
// particle at a support of two spacings a sphere of its own volume: phi_j = 0.68/0.196, phi = 1/2 at 0.625 spacings.
constexpr Real kFlatFill = Real(0.68);

}  // namespace

LiquidPoints gather_liquid(const Particles& particles, const Walls& walls, Real support) {
    const std::size_t n = particles.size();
    std::vector<WallContact> contact(n);
    parallel_for(n, [&](std::size_t i) { contact[i] = wall_contact(walls, particles.position[i]); });
    std::vector<Vec3> position(particles.position);
    std::vector<Index> source(n);
    std::iota(source.begin(), source.end(), Index(0));
    LiquidPoints points;
    points.particle_wall.resize(n);
    for (Index i = 0; i < n; ++i) {
        const WallContact& c = contact[i];
        points.particle_wall[i] = c.distance;
        // A particle inside the wall has its image in the room: it stands for itself alone.
        if (!(c.distance < support) || c.distance <= 0) continue;
        position.push_back(particles.position[i] - 2 * c.distance * c.normal);
        source.push_back(i);
    }
    std::vector<std::int64_t> order_id(position.size());
    std::iota(order_id.begin(), order_id.end(), 0);
    const std::vector<Index> order = PointGrid::sort_order(position, order_id, support);
    const std::size_t total = order.size();
    points.position.resize(total);
    points.volume.resize(total);
    points.colour.assign(total, 1);
    points.component.resize(total);
    points.wall_normal.assign(total, Vec3(0, 0, 0));
    points.wall_offset.assign(total, 0);
    points.particle.resize(total);
    parallel_for(total, [&](std::size_t k) {
        const Index from = order[k], i = source[from];
        points.position[k] = position[from];
        points.volume[k] = particles.rest_volume[i];
        points.component[k] = particles.material[i];
        points.particle[k] = i;
        if (from >= n) {
            const WallContact& c = contact[i];
            points.wall_normal[k] = c.normal;
            points.wall_offset[k] = c.normal.dot(particles.position[i]) - c.distance;
        }
    });
    points.grid.build(points.position, support);
    return points;
}

void set_colours(LiquidPoints& points, Real support) {
    const Poly6 w(support);
    points.particle_fill.assign(points.particle_wall.size(), 0);
    points.particle_slope.assign(points.particle_wall.size(), Vec3(0, 0, 0));
    parallel_for(points.size(), [&](std::size_t k) {
        const auto i = static_cast<Index>(k);
        if (points.is_image(i)) return;
        Real fill = 0;
        Vec3 slope(0, 0, 0);
        points.grid.for_each_neighbour(points.position[i], support, [&](Index j, Real r2) {
            if (points.component[j] != points.component[i]) return;
            fill += points.volume[j] * w.value(r2);
            slope += points.volume[j] * w.gradient_factor(r2) * (points.position[i] - points.position[j]);
        });
        points.particle_fill[points.particle[i]] = fill;  // each particle is one point that is no image
        points.particle_slope[points.particle[i]] = slope;
    });
    parallel_for(points.size(), [&](std::size_t i) {
        const Real fill = points.particle_fill[points.particle[i]];
        points.colour[i] = fill > 0 ? std::max(Real(1), kFlatFill / fill) : Real(1);
    });
}

}  // namespace thixo
