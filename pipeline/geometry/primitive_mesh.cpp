#include "pipeline/geometry/primitive_mesh.h"

#include <algorithm>
#include <cmath>

namespace thixo {
namespace {

/// Points of an arc about (r, z) from angle a to angle b, with both ends and `segments` to a full turn. Angles count
/// counter-clockwise from +r. Points within rounding of the axis are put on it.
void add_arc(std::vector<Vec2d>& profile, double r, double z, double radius, double a, double b, int segments) {
    const int steps = std::max(1, static_cast<int>(std::ceil((b - a) / (2 * kPi) * segments - 1e-9)));
    for (int i = 0; i <= steps; ++i) {
        const double angle = a + (b - a) * i / steps;
        Vec2d p(r + radius * std::cos(angle), z + radius * std::sin(angle));
        if (p.x() < 1e-12 * (r + radius)) p.x() = 0;
        if (profile.empty() || (p - profile.back()).norm() > 1e-9 * (r + radius)) profile.push_back(p);
    }
}

}  // namespace

TriangleMesh sphere_mesh(double radius, int segments) {
    std::vector<Vec2d> profile;
    add_arc(profile, 0, 0, radius, -kPi / 2, kPi / 2, segments);
    return lathe_mesh(profile, segments);
}

TriangleMesh cylinder_mesh(double radius, double half_height, double rounding, int segments) {
    const double r = radius - rounding, z = half_height - rounding;
    std::vector<Vec2d> profile{{0, -half_height}};
    if (rounding > 0) {
        add_arc(profile, r, -z, rounding, -kPi / 2, 0, segments);
        add_arc(profile, r, z, rounding, 0, kPi / 2, segments);
    } else {
        profile.insert(profile.end(), {{r, -z}, {r, z}});
    }
    if ((profile.back() - Vec2d(0, half_height)).norm() > 1e-9 * radius) profile.emplace_back(0, half_height);
    return lathe_mesh(profile, segments);
}

TriangleMesh rounded_cone_mesh(double radius1, double radius2, double height, int segments) {
    const double sine = (radius1 - radius2) / height;
    std::vector<Vec2d> profile;
    if (std::abs(sine) >= 1) {  // one sphere contains the other
        add_arc(profile, 0, sine > 0 ? 0 : height, std::max(radius1, radius2), -kPi / 2, kPi / 2, segments);
    } else {
        add_arc(profile, 0, 0, radius1, -kPi / 2, std::asin(sine), segments);
        add_arc(profile, 0, height, radius2, std::asin(sine), kPi / 2, segments);
    }
    return lathe_mesh(profile, segments);
}

TriangleMesh torus_mesh(double radius, double tube, int segments) {
    std::vector<Vec2d> profile;
    add_arc(profile, radius, 0, tube, -kPi, kPi, segments);
    profile.pop_back();
    return lathe_mesh(profile, segments);
}

namespace {

TriangleMesh sharp_box(const Vec3& half) {
    TriangleMesh mesh;
    for (int axis = 0; axis < 3; ++axis)
        for (const float side : {-1.f, 1.f}) {
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            const Index first = static_cast<Index>(mesh.vertices.size());
            for (int corner = 0; corner < 4; ++corner) {
                Vec3f p;
                p[axis] = side * float(half[axis]);
                p[u] = (corner & 1 ? 1.f : -1.f) * float(half[u]);
                p[v] = (corner & 2 ? 1.f : -1.f) * float(half[v]);
                mesh.vertices.push_back(p);
                mesh.normals.push_back(side * Vec3f::Unit(axis));
            }
            if (side > 0)
                mesh.triangles.insert(mesh.triangles.end(),
                                      {{first, first + 1, first + 3}, {first, first + 3, first + 2}});
            else
                mesh.triangles.insert(mesh.triangles.end(),
                                      {{first, first + 3, first + 1}, {first, first + 2, first + 3}});
        }
    return mesh;
}

void add_triangle(TriangleMesh& mesh, Index a, Index b, Index c) {
    const auto& v = mesh.vertices;
    if (v[a] != v[b] && v[b] != v[c] && v[c] != v[a]) mesh.triangles.push_back({a, b, c});
}

}  // namespace

// A sphere of latitudes and longitudes is cut into octants, which are moved to the corners of the core. The bands that
// join the octants become the flat faces and the rounded edges.
TriangleMesh box_mesh(const Vec3& core, double rounding, int segments) {
    if (rounding <= 0) return sharp_box(core);
    const int m = std::max(2, segments / 4), columns = 4 * (m + 1), rows = 2 * (m + 1);
    TriangleMesh mesh;
    for (int row = 0; row < rows; ++row) {
        const double latitude =
            kPi / 2 * (row <= m ? double(row - m) : double(row - m - 1)) / m;  // from the south pole up
        const double up = row <= m ? -1 : 1;
        for (int column = 0; column < columns; ++column) {
            const int quadrant = column / (m + 1);
            const double longitude = kPi / 2 * double(column - quadrant) / m;
            const bool pole = row == 0 || row == rows - 1;
            const Vec3d n = pole ? Vec3d(0, 0, up)
                                 : Vec3d(std::cos(latitude) * std::cos(longitude),
                                         std::cos(latitude) * std::sin(longitude), std::sin(latitude));
            const Vec3d side(quadrant == 0 || quadrant == 3 ? 1 : -1, quadrant < 2 ? 1 : -1, up);
            mesh.vertices.push_back((side.cwiseProduct(core.cast<double>()) + rounding * n).cast<float>());
            mesh.normals.push_back(n.cast<float>());
        }
    }
    for (int row = 0; row + 1 < rows; ++row)
        for (int column = 0; column < columns; ++column) {
            const Index a = row * columns + column, b = row * columns + (column + 1) % columns;
            add_triangle(mesh, a, b, b + columns);
            add_triangle(mesh, a, b + columns, a + columns);
        }
    const Index top = (rows - 1) * columns, step = m + 1;
    add_triangle(mesh, 0, step * 2, step);
    add_triangle(mesh, 0, step * 3, step * 2);
    add_triangle(mesh, top, top + step, top + step * 2);
    add_triangle(mesh, top, top + step * 2, top + step * 3);
    return mesh;
}

}  // namespace thixo
