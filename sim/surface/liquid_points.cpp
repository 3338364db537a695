#include "sim/surface/liquid_points.h"

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/kernels.h"

namespace thixo {
namespace {

// The fill s of the outermost layer of particles under a flat surface is 0.66 to 0.72, depending on the packing. Within
// that range this value gives a lone particle a sphere of its own volume, at a support of two spacings:
//     phi_j = 0.68/0.196,   phi = 1/2 at 0.625 spacings
constexpr Real kFlatFill = Real(0.68);

/// Up to three walls within a support of a particle, nearest first.
struct NearWalls {
    std::array<WallPlane, 3> plane;
    int count = 0;
};

WallPlane plane_at(const WallContact& contact, const Vec3& x) {
    return {contact.normal, contact.normal.dot(x) - contact.distance};
}

/// The nearest wall, and others that are nearest a little way along it.
NearWalls walls_near(const Walls& walls, const Vec3& x, Real support) {
    NearWalls near;
    const WallContact nearest = wall_contact(walls, x);
    // A particle inside the wall would have its image in the room: it has no image.
    if (!(nearest.distance < support) || nearest.distance <= 0) return near;
    near.plane[near.count++] = plane_at(nearest, x);
    Vec3 a, b;
    orthonormal_basis(nearest.normal, a, b);
    // A little off the wall: close to it a look-up evaluates the shape itself, at many times the cost.
    const Vec3 from = x + std::max(Real(0), Real(0.3) * support - nearest.distance) * nearest.normal;
    for (const Real reach : {Real(0.375), Real(0.75)})
        for (const Vec3& direction : {a, Vec3(-a), b, Vec3(-b)}) {
            const Vec3 probe = from + reach * support * direction;
            const WallPlane plane = plane_at(wall_contact(walls, probe), probe);
            bool found = plane.distance(x) > 0 && plane.distance(x) < support && near.count < 3;
            for (int k = 0; k < near.count; ++k) found = found && plane.normal.dot(near.plane[k].normal) < Real(0.7);
            // The plane of a wall that ends in an edge continues through the room: the wall must exist at the foot of
            // x.
            const Vec3 foot = x - plane.distance(x) * plane.normal;
            found = found && std::abs(wall_distance(walls, foot)) < Real(0.15) * support;
            if (found) near.plane[near.count++] = plane;
        }
    return near;
}

struct Image {
    Vec3 position;
    Index particle;  // the member of ParticleRows
    std::array<Index, 3> mirrors;
};

/// Appends the images of a particle in every subset of its walls for which the image is behind all walls of the subset.
void mirror(std::vector<Image>& images, std::vector<WallPlane>& planes, const NearWalls& near, const Vec3& x,
            Index particle, Real support) {
    const auto first = static_cast<Index>(planes.size());
    for (int k = 0; k < near.count; ++k) planes.push_back(near.plane[static_cast<std::size_t>(k)]);
    for (unsigned subset = 1; subset < (1u << near.count); ++subset) {
        Image image{x, particle, {kNone, kNone, kNone}};
        std::size_t used = 0;
        for (unsigned k = 0; k < static_cast<unsigned>(near.count); ++k) {
            if (!(subset & (1u << k))) continue;
            image.position -= 2 * near.plane[k].distance(image.position) * near.plane[k].normal;
            image.mirrors[used++] = first + k;
        }
        // In a corner that is not square a second reflection may leave the wall again, or the reach of the room.
        bool behind = (image.position - x).norm() < Real(3) * support;
        for (std::size_t k = 0; k < used; ++k) behind = behind && planes[image.mirrors[k]].distance(image.position) < 0;
        if (behind) images.push_back(image);
    }
}

/// Copies the chosen images in cell order.
FieldPoints in_cell_order(const std::vector<Image>& images, const ParticleRows& particles, Real support,
                          std::vector<std::array<Index, 3>>* mirrors) {
    const std::size_t n = images.size();
    std::vector<Vec3> position(n);
    std::vector<std::int64_t> rank(n);
    for (std::size_t k = 0; k < n; ++k) {
        position[k] = images[k].position;
        rank[k] = static_cast<std::int64_t>(k);
    }
    const std::vector<Index> order = PointGrid::sort_order(position, rank, support);
    FieldPoints points;
    points.position.resize(n);
    points.particle.resize(n);
    points.weight.assign(n + PointGrid::kPadding, 0);
    points.dispersion.assign(n + PointGrid::kPadding, 0);
    if (mirrors) mirrors->resize(n);
    for (std::size_t k = 0; k < n; ++k) {
        const Image& from = images[order[k]];
        points.position[k] = from.position;
        points.particle[k] = from.particle;
        points.weight[k] = particles.table().rest_volume[particles.row(from.particle)];
        if (!mirrors) continue;
        points.weight[k] *= particles.table().melt[particles.row(from.particle)];
        (*mirrors)[k] = from.mirrors;
    }
    points.grid.build(points.position, support);
    return points;
}

}  // namespace

LiquidPoints gather_liquid(const ParticleRows& particles, const Walls& walls, Real support) {
    const std::size_t n = particles.size();
    const Particles& p = particles.table();
    std::vector<NearWalls> near(n);
    parallel_for(
        n, [&](std::size_t i) { near[i] = walls_near(walls, p.position[particles.row(i)], support); }, 32);
    LiquidPoints points;
    points.particle_wall.resize(n);
    std::int32_t last = -1;
    for (Index i = 0; i < n; ++i) {
        points.particle_wall[i] = near[i].plane[0];
        last = std::max(last, p.material[particles.row(i)]);
    }
    points.part.resize(static_cast<std::size_t>(last + 1));
    std::vector<Image> own, images;
    for (std::int32_t component = 0; component <= last; ++component) {
        own.clear();
        images.clear();
        for (Index i = 0; i < n; ++i) {
            if (p.material[particles.row(i)] != component) continue;
            const Vec3& x = p.position[particles.row(i)];
            own.push_back({x, i, {kNone, kNone, kNone}});
            if (near[i].count > 0) mirror(images, points.planes, near[i], x, i, support);
        }
        LiquidPart& part = points.part[static_cast<std::size_t>(component)];
        part.own = in_cell_order(own, particles, support, nullptr);
        part.images = in_cell_order(images, particles, support, &part.mirrors);
    }
    return points;
}

void set_colours(LiquidPoints& points, Real support, Real spacing) {
    const Poly6 w(support);
    const Real depth = depth_of_images(spacing);
    points.particle_fill.assign(points.particle_wall.size(), 0);
    points.particle_slope.assign(points.particle_wall.size(), Vec3(0, 0, 0));
    for (LiquidPart& part : points.part) {
        parallel_for(
            part.own.size(),
            [&](std::size_t k) {
                Real fill = 0;
                Vec3 slope(0, 0, 0);
                const Vec3& x = part.own.position[k];
                const auto add = [&](const FieldPoints& from, Index j, Real r2) {
                    fill += from.weight[j] * w.value(r2);
                    slope += from.weight[j] * w.gradient_factor(r2) * (x - from.position[j]);
                };
                part.own.grid.for_each_neighbour(x, support, [&](Index j, Real r2) { add(part.own, j, r2); });
                part.images.grid.for_each_neighbour(x, support, [&](Index j, Real r2) {
                    if (points.counts_at(part.mirrors[j], x, depth)) add(part.images, j, r2);
                });
                points.particle_fill[part.own.particle[k]] = fill;  // each particle is one point
                points.particle_slope[part.own.particle[k]] = slope;
            },
            64);
        for (FieldPoints* of : {&part.own, &part.images})
            for (std::size_t k = 0; k < of->size(); ++k) {
                const Real fill = points.particle_fill[of->particle[k]];
                const Real extended = fill + Real(0.34) * support * points.particle_slope[of->particle[k]].norm();
                of->dispersion[k] = clamp01(4 * (1 - extended)) * clamp01(5 * (fill - Real(0.3)));
                if (fill > 0) of->weight[k] *= std::max(Real(1), kFlatFill / fill);
            }
    }
}

}  // namespace thixo
