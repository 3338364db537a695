// The zero set of a distance as a closed mesh.
#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/bounds.h"
#include "pipeline/geometry/shape_checks.h"
#include "pipeline/geometry/sharp_edges.h"
#include "pipeline/geometry/tessellate.h"

namespace thixo {
namespace {

constexpr int kBlock = 8;

/// Signs of the distance at the nodes of a grid. Its border is outside, whatever the shape says of its bounds: so the
/// surface is closed, and no cell beyond the grid is asked for.
struct SignGrid {
    Vec3d origin;
    double cell;
    std::size_t n[3];  // nodes along each axis
    std::vector<char> inside;

    std::size_t node(std::size_t x, std::size_t y, std::size_t z) const { return x + n[0] * (y + n[1] * z); }
    bool on_border(std::size_t x, std::size_t y, std::size_t z) const {
        return x == 0 || y == 0 || z == 0 || x + 1 == n[0] || y + 1 == n[1] || z + 1 == n[2];
    }
    std::size_t stride(int axis) const { return axis == 0 ? 1 : axis == 1 ? n[0] : n[0] * n[1]; }
    Vec3d position(std::size_t k) const {
        return origin + cell * Vec3d(double(k % n[0]), double(k / n[0] % n[1]), double(k / n[0] / n[1]));
    }
};

SignGrid sample_signs(const Shape& shape, double cell) {
    const auto bounds = shape.bounds();
    if (!bounds) throw InputError("an unbounded shape has no closed surface; intersect it with a box");
    SignGrid grid;
    grid.cell = cell;
    // An odd fraction of a cell keeps nodes off the round numbers where faces of shapes often lie.
    grid.origin = bounds->lower.cast<double>() - cell * Vec3d(1.37, 1.41, 1.43);
    const Eigen::Array3d count = ((bounds->upper.cast<double>() - grid.origin).array() / cell).ceil() + 2;
    if (!(count.prod() < double(1u << 28)))
        throw InputError("tessellation cell {} m is too fine for this shape; use a larger one", cell);
    for (int k = 0; k < 3; ++k) grid.n[k] = std::size_t(count[k]);
    grid.inside.assign(grid.n[0] * grid.n[1] * grid.n[2], 0);

    std::size_t blocks[3];
    for (int k = 0; k < 3; ++k) blocks[k] = (grid.n[k] + kBlock - 1) / kBlock;
    const double reach = std::sqrt(3.0) / 2 * kBlock * cell;
    parallel_for(
        blocks[0] * blocks[1] * blocks[2],
        [&](std::size_t b) {
            const std::size_t low[3] = {b % blocks[0] * kBlock, b / blocks[0] % blocks[1] * kBlock,
                                        b / blocks[0] / blocks[1] * kBlock};
            const Vec3d centre =
                grid.position(grid.node(low[0], low[1], low[2])) + Vec3d::Constant((kBlock - 1) * cell / 2);
            const Real d = shape.distance(centre.cast<Real>());
            const bool uniform = std::abs(double(d)) > reach;
            for (std::size_t z = low[2]; z < std::min(low[2] + kBlock, grid.n[2]); ++z)
                for (std::size_t y = low[1]; y < std::min(low[1] + kBlock, grid.n[1]); ++y)
                    for (std::size_t x = low[0]; x < std::min(low[0] + kBlock, grid.n[0]); ++x) {
                        const std::size_t k = grid.node(x, y, z);
                        if (grid.on_border(x, y, z)) continue;
                        grid.inside[k] = (uniform ? d : shape.distance(grid.position(k).cast<Real>())) < 0;
                    }
        },
        1);
    return grid;
}

/// Grid edges with a change of sign, ascending. Edge number 3 node + axis runs from the node along the axis. Its rank
/// in this list is the number of its vertex.
std::vector<std::size_t> crossing_edges(const SignGrid& grid) {
    std::vector<std::size_t> edges;
    for (std::size_t k = 0; k < grid.inside.size(); ++k)
        for (int axis = 0; axis < 3; ++axis) {
            const std::size_t next = k + grid.stride(axis);
            const std::size_t place = axis == 0   ? k % grid.n[0]
                                      : axis == 1 ? k / grid.n[0] % grid.n[1]
                                                  : k / grid.n[0] / grid.n[1];
            if (place + 1 < grid.n[axis] && grid.inside[k] != grid.inside[next]) edges.push_back(3 * k + axis);
        }
    return edges;
}

/// The root on a crossing edge by the Illinois method (bisection with secant steps). It is kept off the edge's ends, so
/// that no two vertices coincide.
Vec3f root_on_edge(const Shape& shape, const SignGrid& grid, std::size_t edge) {
    const Vec3d p = grid.position(edge / 3), along = grid.cell * Vec3d::Unit(static_cast<int>(edge % 3));
    const auto f = [&](double t) { return double(shape.distance((p + t * along).cast<Real>())); };
    double a = 0, b = 1, fa = f(a), fb = f(b);
    for (int i = 0; i < 20 && b - a > 1e-4 && (fa < 0) != (fb < 0); ++i) {
        double t = a + (b - a) * std::clamp(fa / (fa - fb), 0.02, 0.98);
        if (i % 3 == 2) t = (a + b) / 2;
        const double ft = f(t);
        ((ft < 0) == (fa < 0)) ? (a = t, fa = ft) : (b = t, fb = ft);
    }
    const double t = (fa < 0) != (fb < 0) ? a + (b - a) * fa / (fa - fb) : (a + b) / 2;
    return (p + std::clamp(t, 1e-3, 1 - 1e-3) * along).cast<float>();
}

// Corners of a cell are numbered by their bits (x, y, z). Faces run counter-clockwise as seen from outside.
constexpr int kFaces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};

/// Number of the cell's edge between two neighbouring corners: 3 lower corner + axis.
int local_edge(int a, int b) {
    const int bit = a ^ b;
    return 3 * std::min(a, b) + (bit == 1 ? 0 : bit == 2 ? 1 : 2);
}

/// The loops in which the surface crosses a cell: next[e] is the crossing edge after e, -1 where e is no crossing. On
/// every face a segment cuts off each run of inside corners, from the edge where the run begins to the edge where it
/// ends. The cell across the face makes the same segments in the other direction. So the mesh is closed, and its
/// triangles turn counter-clockwise as seen from outside.
std::array<signed char, 24> cell_loops(const std::array<bool, 8>& inside) {
    std::array<signed char, 24> next;
    next.fill(-1);
    for (const auto& face : kFaces)
        for (int k = 0; k < 4; ++k) {
            if (inside[face[k]] || !inside[face[(k + 1) % 4]]) continue;
            int last = (k + 1) % 4;
            while (inside[face[(last + 1) % 4]]) last = (last + 1) % 4;
            next[local_edge(face[k], face[(k + 1) % 4])] =
                static_cast<signed char>(local_edge(face[last], face[(last + 1) % 4]));
        }
    return next;
}

/// Brings x towards the zero set by Newton steps along the gradient, by `reach` [m] at most.
Vec3f projected(const Shape& shape, const Vec3f& start, double cell, float reach) {
    Vec3 x = start.cast<Real>();
    for (int i = 0; i < 3; ++i) x -= shape.distance(x) * shape.gradient(x, Real(0.05 * cell));
    const Vec3f move = x.cast<float>() - start;
    return start + move * std::min(1.f, reach / std::max(move.norm(), 1e-30f));
}

/// A mesh under construction: vertices on grid edges, then the centres of fans.
struct Extraction {
    TriangleMesh mesh;
    std::vector<Fan> fans;
};

void add_loop(Extraction& out, const std::vector<Index>& loop) {
    TriangleMesh& mesh = out.mesh;
    if (loop.size() == 3 && !crosses_edge(mesh, loop)) {
        mesh.triangles.push_back({loop[0], loop[1], loop[2]});
        return;
    }
    Vec3f centre = Vec3f::Zero();
    for (const Index v : loop) centre += mesh.vertices[v] / float(loop.size());
    const Index middle = static_cast<Index>(mesh.vertices.size());
    mesh.vertices.push_back(centre);
    out.fans.push_back({middle, loop, false});
    for (std::size_t i = 0; i < loop.size(); ++i)
        mesh.triangles.push_back({middle, loop[i], loop[(i + 1) % loop.size()]});
}

/// A fan's centre comes to the edge or corner of the faces that meet there. Elsewhere it comes to the zero set, by half
/// the loop's radius at most: then its triangles do not fold.
void place_centre(const Shape& shape, const SmoothFaces& faces, double cell, TriangleMesh& mesh, Fan& fan) {
    Vec3f& centre = mesh.vertices[fan.centre];
    if (crosses_edge(mesh, fan.loop))
        if (const auto edge = point_on_edge(faces, mesh, fan, cell)) {
            centre = *edge;
            fan.on_edge = true;
            return;
        }
    float radius = 0;
    for (const Index v : fan.loop) radius = std::max(radius, (mesh.vertices[v] - centre).norm());
    centre = projected(shape, centre, cell, radius / 2);
}

void add_cell(Extraction& out, const SignGrid& grid, const std::vector<std::size_t>& edges, std::size_t node) {
    std::array<bool, 8> inside;
    std::array<std::size_t, 8> corner;
    for (int c = 0; c < 8; ++c) {
        corner[c] = node + (c & 1) + (c >> 1 & 1) * grid.stride(1) + (c >> 2) * grid.stride(2);
        inside[c] = grid.inside[corner[c]];
    }
    std::array<signed char, 24> next = cell_loops(inside);
    std::vector<Index> loop;
    for (int first = 0; first < 24; ++first) {
        loop.clear();
        for (int e = first; next[e] >= 0;) {
            const std::size_t edge = 3 * corner[e / 3] + e % 3;
            loop.push_back(static_cast<Index>(std::lower_bound(edges.begin(), edges.end(), edge) - edges.begin()));
            const int after = next[e];
            next[e] = -1;
            e = after;
        }
        if (!loop.empty()) add_loop(out, loop);
    }
}

/// The cells that a crossing edge touches: each once, ascending.
std::vector<std::size_t> crossed_cells(const SignGrid& grid, const std::vector<std::size_t>& edges) {
    std::vector<std::size_t> cells;
    for (const std::size_t edge : edges) {
        const std::size_t u = grid.stride((edge % 3 + 1) % 3), v = grid.stride((edge % 3 + 2) % 3), node = edge / 3;
        cells.insert(cells.end(), {node, node - u, node - v, node - u - v});
    }
    std::sort(cells.begin(), cells.end());
    cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
    return cells;
}

/// Normals of vertices from their triangles, where the distance has no gradient.
void mend_normals(TriangleMesh& mesh) {
    for (const auto& t : mesh.triangles) {
        const Vec3f &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
        for (const Index v : t)
            if (mesh.normals[v].squaredNorm() < 0.5f) mesh.normals[v] = (b - a).cross(c - a).stableNormalized();
    }
}

}  // namespace

TriangleMesh extract_surface(const Shape& shape, double cell) {
    positive_size(cell, "tessellation cell");
    const SignGrid grid = sample_signs(shape, cell);
    const std::vector<std::size_t> edges = crossing_edges(grid);
    if (edges.empty())
        throw InputError("no surface found with a cell of {} m; the shape is empty or thinner than a cell", cell);
    const SmoothFaces faces(shape, cell);
    const auto normal_at = [&](const Vec3f& x) { return faces.normal(faces.nearest(x), x); };
    Extraction out;
    TriangleMesh& mesh = out.mesh;
    mesh.vertices.resize(edges.size());
    mesh.normals.resize(edges.size());
    parallel_for(edges.size(), [&](std::size_t k) {
        mesh.vertices[k] = root_on_edge(shape, grid, edges[k]);
        mesh.normals[k] = normal_at(mesh.vertices[k]);
    });
    for (const std::size_t node : crossed_cells(grid, edges)) add_cell(out, grid, edges, node);
    mesh.normals.resize(mesh.vertices.size());
    parallel_for(out.fans.size(), [&](std::size_t k) {
        Fan& fan = out.fans[k];
        place_centre(shape, faces, cell, mesh, fan);
        mesh.normals[fan.centre] = normal_at(mesh.vertices[fan.centre]);
    });
    mend_normals(mesh);
    keep_edges_sharp(mesh, out.fans);
    return std::move(mesh);
}

}  // namespace thixo
