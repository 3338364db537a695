// A point set with normals as a shape.
#include <algorithm>
#include <cmath>

#include "pipeline/geometry/bounds.h"
#include "pipeline/geometry/mesh_query.h"
#include "pipeline/geometry/point_grid.h"
#include "pipeline/geometry/point_surfels.h"
#include "pipeline/geometry/shapes.h"

namespace thixo {
namespace {

/// An equilateral triangle for every surfel, with the area that its point represents. Together they have about the
/// winding number and the distance of the surface.
TriangleMesh triangle_soup(const PointSurfels& points) {
    TriangleMesh soup;
    const SurfelCloud& cloud = points.surfels;
    double discs = 0;
    for (const Vec3& t : cloud.axis1) discs += static_cast<double>(t.squaredNorm());
    // The distance of a corner from the centre follows from
    //     area = 3 sqrt(3)/4 corner^2
    const Real corner = static_cast<Real>(std::sqrt(points.area / discs / (0.75 * std::sqrt(3.0))));
    for (std::size_t i = 0; i < cloud.size(); ++i) {
        const auto first = static_cast<Index>(soup.vertices.size());
        for (int k = 0; k < 3; ++k) {
            const Real angle = static_cast<Real>(2 * kPi * k / 3);
            soup.vertices.push_back(
                (cloud.position[i] + corner * (std::cos(angle) * cloud.axis1[i] + std::sin(angle) * cloud.axis2[i]))
                    .cast<float>());
        }
        soup.triangles.push_back({first, first + 1, first + 2});
    }
    return soup;
}

std::shared_ptr<const PointSurfels> outward_surfels(const TriangleMesh& given) {
    auto points = std::make_shared<PointSurfels>(surfels_of_points(given));
    orient_outward(*points);
    return points;
}

struct Points final : Shape::Node {
    explicit Points(const TriangleMesh& given) : points(outward_surfels(given)), query(triangle_soup(*points)) {
        const SurfelCloud& cloud = points->surfels;
        for (const Vec3& t : cloud.axis1) widest = std::max(widest, t.norm());
        grid.build(cloud.position, 2 * widest);
        box = grown(query.bounds(), widest);
    }

    /// Near the surface this is the mean distance from the planes of the points around, with the weights
    ///     (1 - r^2/(2 radius)^2)^3
    Real distance(const Vec3& x) const override {
        const auto closest = query.closest(x);
        const SurfelCloud& cloud = points->surfels;
        const Real radius = cloud.axis1[closest.triangle].norm();
        if (closest.distance < radius) {
            const Vec3& facing = cloud.normal[closest.triangle];
            Real sum = 0, weight = 0;
            grid.for_each_neighbour(x, 2 * radius, [&](Index i, Real r2) {
                if (cloud.normal[i].dot(facing) <= 0) return;
                const Real w = cube(1 - r2 / square(2 * radius));
                sum += w * cloud.normal[i].dot(x - cloud.position[i]);
                weight += w;
            });
            if (weight > 0) return sum / weight;
        }
        const bool inside = distance_to(box, x) == 0 && query.inside(x);
        return inside ? -closest.distance : closest.distance;
    }
    std::optional<Box3> bounds() const override { return box; }
    std::optional<Vec3f> colour(const Vec3& x) const override {
        if (points->colour.empty()) return std::nullopt;
        return points->colour[query.closest(x).triangle];
    }
    std::shared_ptr<const PointSurfels> own_surfels() const override { return points; }

    std::shared_ptr<const PointSurfels> points;
    MeshQuery query;
    PointGrid grid;
    Real widest = 0;
    Box3 box;
};

}  // namespace

Shape point_shape(TriangleMesh points) { return Shape(std::make_shared<Points>(points)); }

}  // namespace thixo
