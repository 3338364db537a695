#include "sim/surface/volume.h"

#include <algorithm>
#include <numeric>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/enclosed_volume.h"

namespace thixo {
namespace {

/// Surfels lie a little closer than their radius; in the middle each has this part of the square of it to itself.
constexpr Real kOwnArea = Real(0.75);

/// The surface with its coats on the walls that they line.
struct UpToWalls {
    std::vector<Vec3> position;
    std::vector<double> area;  // each surfel's own, in the room; 0 where it is in a wall [m^2]
};

UpToWalls up_to_the_walls(const SurfelCloud& cloud, const Walls& walls) {
    UpToWalls s{cloud.position, std::vector<double>(cloud.size(), 0)};
    parallel_for(
        cloud.size(),
        [&](std::size_t i) {
            const WallContact wall = wall_contact(walls, s.position[i]);
            if (wall.distance < 0 && wall.normal.dot(cloud.normal[i]) < -Real(0.7))
                s.position[i] -= wall.distance * wall.normal;
            else if (wall.distance >= 0)
                s.area[i] = static_cast<double>(kOwnArea * cloud.axis1[i].norm() * cloud.axis2[i].norm());
        },
        64);
    return s;
}

std::vector<double> volume_by_component(const std::vector<Vec3>& position, const SurfelCloud& cloud,
                                        const std::vector<std::int32_t>& component, const Walls& walls, Real radius) {
    const auto room = [&](const Vec3& x) { return wall_distance(walls, x); };
    std::int32_t last = -1;
    for (const std::int32_t c : component) last = std::max(last, c);
    std::vector<double> volume(static_cast<std::size_t>(last + 1), 0);
    std::vector<Vec3> s, n;
    for (std::int32_t c = 0; c <= last; ++c) {
        s.clear();
        n.clear();
        for (std::size_t i = 0; i < component.size(); ++i)
            if (component[i] == c) {
                s.push_back(position[i]);
                n.push_back(cloud.normal[i]);
            }
        // No wider than discs overlap, or thin sheets, threads and drops blend with their other sides.
        volume[static_cast<std::size_t>(c)] = enclosed_volume(s, n, 2 * radius, {}, room);
    }
    return volume;
}

}  // namespace

std::vector<std::int32_t> components(const SurfaceState& surface, const Particles& particles) {
    std::vector<std::pair<std::int32_t, std::int32_t>> material_of;
    for (std::size_t j = 0; j < particles.size(); ++j)
        if (j == 0 || particles.body[j] != particles.body[j - 1])
            material_of.emplace_back(particles.body[j], particles.material[j]);
    std::sort(material_of.begin(), material_of.end());
    std::vector<std::int32_t> component(surface.size());
    parallel_for(surface.size(), [&](std::size_t i) {
        const auto found =
            std::lower_bound(material_of.begin(), material_of.end(), std::pair(surface.body[i], std::int32_t(-1)));
        component[i] = found != material_of.end() && found->first == surface.body[i] ? found->second : -1;
    });
    return component;
}

std::vector<double> volume_by_component(const SurfaceState& surface, const std::vector<std::int32_t>& component,
                                        const Walls& walls, Real radius) {
    return volume_by_component(up_to_the_walls(surface.surfels, walls).position, surface.surfels, component, walls, radius);
}

double surface_volume(const SurfaceState& surface, const Particles& particles, const Walls& walls, Real radius) {
    const auto volume = volume_by_component(surface, components(surface, particles), walls, radius);
    return std::accumulate(volume.begin(), volume.end(), 0.0);
}

void hold_volume(SurfaceState& surface, const Particles& particles, const std::vector<std::int32_t>& component,
                 const std::vector<Real>& give, const Walls& walls, Real radius, Real spacing) {
    const Real lowest = Real(-0.35) * spacing, highest = Real(0.3) * spacing, step = Real(0.08) * spacing;
    const UpToWalls s = up_to_the_walls(surface.surfels, walls);
    const std::vector<double> volume = volume_by_component(s.position, surface.surfels, component, walls, radius);
    surface.lift.resize(std::max(surface.lift.size(), volume.size()), 0);
    for (std::size_t c = 0; c < volume.size(); ++c) {
        const auto in_c = static_cast<std::int32_t>(c);
        const double matter = parallel_sum(particles.size(), [&](std::size_t j) {
            return particles.material[j] == in_c ? static_cast<double>(particles.rest_volume[j]) : 0.0;
        });
        const double area = parallel_sum(component.size(), [&](std::size_t i) {
            return component[i] == in_c ? static_cast<double>(give[i]) * s.area[i] : 0.0;
        });
        if (!(area > 0) || !(matter > 0)) continue;
        const Real missing = static_cast<Real>(0.7 * (matter - volume[c]) / area);
        surface.lift[c] = std::clamp(surface.lift[c] + std::clamp(missing, -step, step), lowest, highest);
    }
}

}  // namespace thixo
