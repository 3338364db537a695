#include "pipeline/geometry/point_surfels.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/geometry/point_grid.h"

namespace thixo {
namespace {

constexpr int kAround = 12;           // neighbours that give the density of the points
constexpr Real kOverlap = Real(1.1);  // radius over the distance of points
constexpr float kFarthest = 1e9f;     // m, as of meshes

void check_points(const TriangleMesh& points) {
    if (points.vertices.size() < kAround + 4)
        throw InputError("a point set has {} points; a surface needs at least {}", points.vertices.size(), kAround + 4);
    if (points.normals.size() != points.vertices.size())
        throw InputError("a point set without normals is no surface; give its vertices nx, ny, nz");
    for (std::size_t i = 0; i < points.vertices.size(); ++i) {
        const float far = points.vertices[i].cwiseAbs().maxCoeff(), length = points.normals[i].norm();
        if (!points.vertices[i].allFinite() || !std::isfinite(length) || !(length > 0))
            throw InputError("point {} of a point set has no finite place or no normal", i + 1);
        if (!(far < kFarthest))
            throw InputError("point {} of a point set is {} m away; coordinates must be below {} m", i + 1, far,
                             kFarthest);
    }
}

/// Cell edge of a grid that has about ten points per cell where they are evenly spread over their box's surface.
Real grid_cell(const std::vector<Vec3>& points) {
    Vec3 lower = points[0], upper = points[0];
    for (const Vec3& p : points) {
        lower = lower.cwiseMin(p);
        upper = upper.cwiseMax(p);
    }
    const Vec3 size = upper - lower;
    const Real area = 2 * (size.x() * size.y() + size.y() * size.z() + size.z() * size.x());
    if (!(area > 0)) throw InputError("the points of a point set lie on a line; they are no surface");
    return std::sqrt(10 * area / static_cast<Real>(points.size()));
}

}  // namespace

PointSurfels surfels_of_points(const TriangleMesh& points) {
    check_points(points);
    PointSurfels result;
    SurfelCloud& cloud = result.surfels;
    const std::size_t n = points.vertices.size();
    for (const Vec3f& v : points.vertices) cloud.position.push_back(v.cast<Real>());
    cloud.axis1.resize(n);
    cloud.axis2.resize(n);
    cloud.normal.resize(n);
    result.colour = points.colours;
    PointGrid grid;
    grid.build(cloud.position, grid_cell(cloud.position));
    std::vector<double> area(n);
    std::vector<char> heaped(n);
    parallel_chunks(n, [&](std::size_t begin, std::size_t end, std::size_t) {
        std::vector<std::pair<Real, Index>> around;
        for (std::size_t i = begin; i < end; ++i) {
            grid.nearest(cloud.position[i], kAround + 1, std::numeric_limits<Real>::max(), around);
            // A disc of that radius holds the point and its neighbours. The last neighbour counts half.
            area[i] = kPi * static_cast<double>(around.back().first) / (kAround + 0.5);
            heaped[i] = !(area[i] > 0);
            const Real radius = kOverlap * static_cast<Real>(std::sqrt(area[i]));
            const Vec3 normal = points.normals[i].cast<Real>().normalized();
            Vec3 a, b;
            orthonormal_basis(normal, a, b);
            cloud.normal[i] = normal;
            cloud.axis1[i] = radius * a;
            cloud.axis2[i] = radius * b;
        }
    });
    if (const auto bad = std::find(heaped.begin(), heaped.end(), 1); bad != heaped.end())
        throw InputError("point {} of a point set has {} others in the same place; remove doubled points",
                         bad - heaped.begin() + 1, kAround);
    for (const double a : area) result.area += a;
    return result;
}

bool orient_outward(PointSurfels& points) {
    constexpr double kWidestOpening = 0.25;  // of the area; a closed surface has the vector area 0
    SurfelCloud& cloud = points.surfels;
    Vec3d middle(0, 0, 0);
    for (const Vec3& x : cloud.position) middle += x.cast<double>() / static_cast<double>(cloud.size());
    double volume = 0, area = 0;
    Vec3d vector_area(0, 0, 0);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
        const double share = static_cast<double>(cloud.axis1[i].squaredNorm());
        const Vec3d n = share * cloud.normal[i].cast<double>();
        volume += n.dot(cloud.position[i].cast<double>() - middle) / 3;
        vector_area += n;
        area += share;
    }
    if (volume >= 0 || vector_area.norm() > kWidestOpening * area) return false;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
        cloud.normal[i] = -cloud.normal[i];
        std::swap(cloud.axis1[i], cloud.axis2[i]);
    }
    return true;
}

PointSurfels moved(const PointSurfels& points, double factor, const Quatd& rotation, const Vec3d& translation) {
    PointSurfels result = points;
    SurfelCloud& cloud = result.surfels;
    const Mat3 turn = rotation.toRotationMatrix().cast<Real>();
    const Real scale = static_cast<Real>(factor);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
        cloud.position[i] = (rotation * (factor * cloud.position[i].cast<double>()) + translation).cast<Real>();
        cloud.axis1[i] = scale * (turn * cloud.axis1[i]);
        cloud.axis2[i] = scale * (turn * cloud.axis2[i]);
        cloud.normal[i] = turn * cloud.normal[i];
    }
    result.area *= factor * factor;
    return result;
}

}  // namespace thixo
