#include "sim/surface/volume.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/geometry/enclosed_volume.h"
#include "pipeline/geometry/point_grid.h"

namespace thixo {
namespace {

/// Surfels lie a little closer than their radius. In the middle each covers this part of the radius squared alone.
constexpr Real kOwnArea = Real(0.75);

/// Updates without a measurement after a very small change: a measurement costs an eighth of an update.
constexpr std::int32_t kSkippedMeasurements = 3;

/// Relative error of a volume from which on the surface cannot be closed.
constexpr double kOpen = 0.15;

/// The surface with its coats on the walls that they line.
struct UpToWalls {
    std::vector<Vec3> position;
    std::vector<double> area;       // each surfel's own, in the room; 0 where it is in a wall [m^2]
    std::vector<Vec3> lined, into;  // places on walls, and the normal into the wall there
};

/// Moves the coats to the walls. `wall_of` gives the wall beside a surfel.
template <class F>
UpToWalls up_to_the_walls(const SurfelCloud& cloud, F&& wall_of) {
    UpToWalls moved{cloud.position, std::vector<double>(cloud.size(), 0), {}, {}};
    std::vector<char> lines(cloud.size(), 0);
    parallel_for(
        cloud.size(),
        [&](std::size_t i) {
            const WallPlane wall = wall_of(i);
            const Real distance = wall.distance(moved.position[i]);
            lines[i] = distance < 0 && wall.normal.dot(cloud.normal[i]) < -Real(0.7);
            if (lines[i])
                moved.position[i] -= distance * wall.normal;
            else if (distance >= 0)
                moved.area[i] = static_cast<double>(kOwnArea * cloud.axis1[i].norm() * cloud.axis2[i].norm());
        },
        64);
    for (std::size_t i = 0; i < cloud.size(); ++i)
        if (lines[i]) {
            moved.lined.push_back(moved.position[i]);
            moved.into.push_back(cloud.normal[i]);
        }
    return moved;
}

/// Distance from the walls that the surface lines, as planes: to evaluate the walls themselves would cost more than all
/// other work.
class LinedWalls {
  public:
    LinedWalls(const UpToWalls& surface, Real reach) : s_(surface) {
        if (!surface.lined.empty()) grid_.build(surface.lined, reach);
    }
    Real distance(const Vec3& x) const {
        Real nearest = std::numeric_limits<Real>::max(), distance = nearest;
        if (s_.lined.empty()) return distance;
        grid_.for_each_neighbour(x, grid_.cell(), [&](Index j, Real r2) {
            if (r2 >= nearest) return;
            nearest = r2;
            distance = s_.into[j].dot(s_.lined[j] - x);
        });
        return distance;
    }

  private:
    const UpToWalls& s_;
    PointGrid grid_;
};

std::vector<double> volume_by_component(const UpToWalls& surface, const SurfelCloud& cloud,
                                        const std::vector<std::int32_t>& component, Real radius) {
    const LinedWalls lined(surface, 2 * radius);
    const auto room = [&](const Vec3& x) { return lined.distance(x); };
    std::int32_t last = -1;
    for (const std::int32_t c : component) last = std::max(last, c);
    std::vector<double> volume(static_cast<std::size_t>(last + 1), 0);
    std::vector<Vec3> own_positions, own_normals;
    for (std::int32_t c = 0; c <= last; ++c) {
        own_positions.clear();
        own_normals.clear();
        for (std::size_t i = 0; i < component.size(); ++i)
            if (component[i] == c) {
                own_positions.push_back(surface.position[i]);
                own_normals.push_back(cloud.normal[i]);
            }
        // No wider than discs overlap: otherwise thin sheets, threads and drops blend with their other sides.
        volume[static_cast<std::size_t>(c)] = enclosed_volume(own_positions, own_normals, 2 * radius, {}, room);
    }
    return volume;
}

}  // namespace

std::vector<std::int32_t> components(const SurfaceState& surface, const ParticleRows& particles) {
    std::vector<std::pair<std::int32_t, std::int32_t>> material_of;
    const Particles& p = particles.table();
    for (std::size_t k = 0; k < particles.size(); ++k)
        if (const Index j = particles.row(k); k == 0 || p.body[j] != p.body[particles.row(k - 1)])
            material_of.emplace_back(p.body[j], p.material[j]);
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
    const std::vector<Vec3>& x = surface.surfels.position;
    const auto wall_of = [&](std::size_t i) {
        const WallContact contact = wall_contact(walls, x[i]);
        return WallPlane{contact.normal, contact.normal.dot(x[i]) - contact.distance};
    };
    return volume_by_component(up_to_the_walls(surface.surfels, wall_of), surface.surfels, component, radius);
}

double surface_volume(const SurfaceState& surface, const ParticleRows& particles, const Walls& walls, Real radius) {
    const auto volume = volume_by_component(surface, components(surface, particles), walls, radius);
    return std::accumulate(volume.begin(), volume.end(), 0.0);
}

double matter_volume(const Particles& p, std::size_t j) {
    const double unstrained = static_cast<double>(p.rest_volume[j]), b = static_cast<double>(p.melt[j]);
    if (!(b < 1) || !(p.density[j] > 0)) return unstrained;
    const double now = static_cast<double>(p.mass[j]) / static_cast<double>(p.density[j]);
    return b * unstrained + (1 - b) * std::clamp(now, 0.5 * unstrained, unstrained);
}

double hold_volume(SurfaceState& surface, const ParticleRows& particles, const SurfelNotes& notes, Real radius,
                   Real spacing, bool steady) {
    if (steady && surface.unmeasured > 0) {
        --surface.unmeasured;
        return 0;
    }
    const Real lowest = Real(-0.6) * spacing, highest = Real(0.3) * spacing, step = Real(0.08) * spacing;
    const std::vector<std::int32_t>& component = notes.component;
    // The walls are those of the last look-up near the surfel.
    const UpToWalls moved = up_to_the_walls(surface.surfels, [&](std::size_t i) {
        const WallNote& note = notes.wall[i];
        const bool near = (surface.surfels.position[i] - note.asked).squaredNorm() < square(Real(0.5) * spacing);
        return near ? note.walls.first : WallPlane{};
    });
    const std::vector<double> volume = volume_by_component(moved, surface.surfels, component, radius);
    surface.lift.resize(std::max(surface.lift.size(), volume.size()), 0);
    const std::vector<Real> ones(component.size(), 1);
    Real largest = 0;
    double wrong = 0, all = 0;
    for (std::size_t c = 0; c < volume.size(); ++c) {
        const auto in_c = static_cast<std::int32_t>(c);
        const double matter = parallel_sum(particles.size(), [&](std::size_t k) {
            const Index j = particles.row(k);
            return particles.table().material[j] == in_c ? matter_volume(particles.table(), j) : 0.0;
        });
        const auto area_of = [&](const std::vector<Real>& part) {
            return parallel_sum(component.size(), [&](std::size_t i) {
                return component[i] == in_c && moved.area[i] > 0
                           ? static_cast<double>(part[i] * notes.lift_share[i] * kOwnArea * square(notes.radius[i]))
                           : 0.0;
            });
        };
        const double area = area_of(ones), melted = area_of(notes.melt);
        if (!(area > 0) || !(matter > 0)) continue;
        // The small molten part of a body must not make up for all its missing volume.
        const Real share = clamp01(static_cast<Real>(3 * melted / area));
        // An open surface, as where a floor is just wetted, has no meaningful volume. Its lift fades: one that stayed
        // could keep the volume as wrong as that for ever.
        const bool open = std::abs(volume[c] - matter) > kOpen * matter;
        const Real missing = open ? -surface.lift[c] : static_cast<Real>(0.7 * (matter - volume[c]) / area);
        if (!open) {
            wrong += std::abs(volume[c] - matter);
            all += matter;
        }
        const Real lift =
            std::clamp(surface.lift[c] + std::clamp(missing, -step, step), share * lowest, share * highest);
        largest = std::max(largest, std::abs(lift - surface.lift[c]));
        surface.lift[c] = lift;
    }
    surface.unmeasured = largest < step / 20 ? kSkippedMeasurements : 0;
    return all > 0 ? wrong / all : 0;
}

}  // namespace thixo
