#include "pipeline/geometry/enclosed_volume.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/geometry/implicit_surface.h"

namespace thixo {
namespace {

constexpr float kUnknown = -1;
constexpr std::size_t kMostCells = std::size_t(1) << 30;

/// Cells of the box of a cloud, with a free rim of one support around it.
struct Lattice {
    Vec3 origin{0, 0, 0};
    Real edge = 0;
    std::size_t nx = 0, ny = 0, nz = 0;
    std::size_t size() const { return nx * ny * nz; }
    Vec3 centre(std::size_t c) const {
        return origin +
               edge * Vec3(Real(c % nx) + Real(0.5), Real(c / nx % ny) + Real(0.5), Real(c / (nx * ny)) + Real(0.5));
    }
    template <class F>
    void for_each_face_neighbour(std::size_t c, F&& f) const {
        const std::size_t x = c % nx, y = c / nx % ny, z = c / (nx * ny);
        if (x > 0) f(c - 1);
        if (x + 1 < nx) f(c + 1);
        if (y > 0) f(c - nx);
        if (y + 1 < ny) f(c + nx);
        if (z > 0) f(c - nx * ny);
        if (z + 1 < nz) f(c + nx * ny);
    }
};

Lattice lattice_around(std::span<const Vec3> positions, Real support) {
    Vec3 lower = positions[0], upper = positions[0];
    for (const Vec3& p : positions) {
        lower = lower.cwiseMin(p);
        upper = upper.cwiseMax(p);
    }
    Lattice lattice;
    lattice.edge = support / 2;
    lattice.origin = lower - Vec3::Constant(Real(1.5) * support);
    const Vec3 extent = (upper - lower + Vec3::Constant(3 * support)) / lattice.edge;
    if (!(double(extent.x()) * double(extent.y()) * double(extent.z()) < double(kMostCells)))
        throw ResourceError("the enclosed volume of {} surfels spread over {} x {} x {} cells is too large to compute",
                            positions.size(), extent.x(), extent.y(), extent.z());
    lattice.nx = static_cast<std::size_t>(extent.x()) + 1;
    lattice.ny = static_cast<std::size_t>(extent.y()) + 1;
    lattice.nz = static_cast<std::size_t>(extent.z()) + 1;
    return lattice;
}

/// Part of a cell on the inner side of a plane `value` cell edges outside its centre, as a ramp. A cut oblique to the
/// axes has another profile, but the ramp's error is odd in `value` and cancels over the cells of a surface.
float inner_part(Real value) { return static_cast<float>(clamp01(Real(0.5) - value)); }

/// Part of a cell inside one side of the surface.
float inner_part(const ImplicitSurface::Sample& s, Real edge) {
    const Real slope = s.gradient.norm();
    // On a bent surface the average of the surfels lies on its hollow side, the average of their planes as far on
    // the other: the mean of the two distances is free of that error, which would be a per cent of a drop's volume.
    if (slope > Real(0.2)) return inner_part((s.value + s.planes) / ((slope + 1) * edge));
    return s.value < 0 ? 1.0f : 0.0f;  // on a ridge of F, as far from the surface as it goes
}

constexpr Real kOneSide = Real(0.9);   // agreement of normals from which on a cell sees one side alone
constexpr Real kOpposite = Real(0.5);  // cosine between the normals of two sides, at least, reversed

struct CellPart {
    float part = kUnknown;
    bool one_side = true;
};

/// Where a cell sees two sides, of a sheet or across a gap, they are not averaged. The side of the nearest surfel
/// leads; where the other lies behind it, inside is what is inside of both, where it lies before it, what is inside of
/// either.
CellPart part_of_cell(const ImplicitSurface& surface, const Vec3& centre, Real edge) {
    const auto all = surface.evaluate(centre);
    // One side is no ridge: F has a slope of one.
    if (all && all->agreement > kOneSide) return {inner_part((all->value + all->planes) / (2 * edge)), true};
    const auto n = surface.nearest_normal(centre);
    if (!n) return {kUnknown, true};
    const auto near = surface.evaluate_gradient(centre, {.reference = *n, .least_cosine = -kOpposite});
    const auto far = surface.evaluate_gradient(centre, {.reference = -*n, .least_cosine = kOpposite});
    if (!near) return {kUnknown, false};
    if (!far) return {inner_part(*near, edge), false};
    const float a = inner_part(*near, edge), b = inner_part(*far, edge);
    const bool behind = (far->average - near->average).dot(near->normal) < 0;
    return {behind ? std::max(0.0f, a + b - 1) : std::min(1.0f, a + b), false};
}

using Room = std::function<Real(const Vec3&)>;

/// The same in eight parts where the cell sees more than one side, or a small drop.
float part_of_refined_cell(const ImplicitSurface& surface, const Vec3& centre, Real edge) {
    const CellPart whole = part_of_cell(surface, centre, edge);
    if (whole.part == kUnknown || whole.one_side) return whole.part;
    float sum = 0;
    for (unsigned k = 0; k < 8; ++k) {
        const auto way = [&](unsigned axis) { return k >> axis & 1 ? Real(0.25) : Real(-0.25); };
        const float part = part_of_cell(surface, centre + edge * Vec3(way(0), way(1), way(2)), edge / 2).part;
        sum += part == kUnknown ? std::round(whole.part) : part;
    }
    return sum / 8;
}

float part_in_room(const ImplicitSurface& surface, const Room& room, const Vec3& centre, Real edge) {
    const float part = part_of_refined_cell(surface, centre, edge);
    return room && part > 0 ? std::min(part, inner_part(-room(centre) / edge)) : part;
}

/// The cells that a surfel's support may reach, ascending.
std::vector<std::size_t> cells_near(const Lattice& lattice, std::span<const Vec3> positions, Real support) {
    std::vector<char> near(lattice.size(), 0);
    std::vector<std::size_t> cells;
    const auto along = [&](Real x, std::size_t n) {
        return std::min(n - 1, static_cast<std::size_t>(std::max(Real(0), x / lattice.edge)));
    };
    for (const Vec3& p : positions) {
        const Vec3 lower = p - lattice.origin - Vec3::Constant(support), upper = lower + Vec3::Constant(2 * support);
        for (std::size_t z = along(lower.z(), lattice.nz); z <= along(upper.z(), lattice.nz); ++z)
            for (std::size_t y = along(lower.y(), lattice.ny); y <= along(upper.y(), lattice.ny); ++y)
                for (std::size_t x = along(lower.x(), lattice.nx); x <= along(upper.x(), lattice.nx); ++x) {
                    const std::size_t c = (z * lattice.ny + y) * lattice.nx + x;
                    if (!near[c]) cells.push_back(c);
                    near[c] = 1;
                }
    }
    std::sort(cells.begin(), cells.end());
    return cells;
}

/// Settles the region of cells of unknown part about one: outside where it meets the border, otherwise as the majority
/// of its rim.
void settle_region(const Lattice& lattice, std::size_t start, std::vector<float>& part, std::vector<char>& seen) {
    std::vector<std::size_t> region, stack(1, start);
    seen[start] = 1;
    bool border = false;
    std::int64_t votes = 0;  // > 0: the rim is inside
    while (!stack.empty()) {
        const std::size_t c = stack.back();
        stack.pop_back();
        region.push_back(c);
        int faces = 0;
        lattice.for_each_face_neighbour(c, [&](std::size_t other) {
            ++faces;
            if (part[other] != kUnknown) {
                votes += part[other] > 0.5f ? 1 : -1;
            } else if (!seen[other]) {
                seen[other] = 1;
                stack.push_back(other);
            }
        });
        border = border || faces < 6;
    }
    if (border || votes <= 0) return;  // unknown counts as outside
    for (const std::size_t c : region) part[c] = 1;
}

/// Only regions beside a cell that is inside can be inside.
void flood_unknown(const Lattice& lattice, const std::vector<std::size_t>& cells, std::vector<float>& part) {
    std::vector<char> seen(part.size(), 0);
    for (const std::size_t c : cells) {
        if (!(part[c] > 0.5f)) continue;
        lattice.for_each_face_neighbour(c, [&](std::size_t other) {
            if (part[other] == kUnknown && !seen[other]) settle_region(lattice, other, part, seen);
        });
    }
}

double volume_of_one(std::span<const Vec3> positions, std::span<const Vec3> normals, Real support, const Room& room) {
    if (positions.empty()) return 0;
    const Lattice lattice = lattice_around(positions, support);
    ImplicitSurface surface;
    surface.build(positions, normals, support);
    const std::vector<std::size_t> cells = cells_near(lattice, positions, support);
    std::vector<float> part(lattice.size(), kUnknown);
    parallel_for(
        cells.size(),
        [&](std::size_t k) { part[cells[k]] = part_in_room(surface, room, lattice.centre(cells[k]), lattice.edge); },
        256);
    flood_unknown(lattice, cells, part);
    return parallel_sum(part.size(), [&](std::size_t c) { return std::max(0.0, static_cast<double>(part[c])); }) *
           cube(static_cast<double>(lattice.edge));
}

}  // namespace

double enclosed_volume(std::span<const Vec3> positions, std::span<const Vec3> normals, Real support,
                       std::span<const std::int32_t> groups, const Room& room) {
    THIXO_ASSERT(positions.size() == normals.size() && (groups.empty() || groups.size() == positions.size()),
                 "{} positions, {} normals, {} groups", positions.size(), normals.size(), groups.size());
    if (groups.empty()) return volume_of_one(positions, normals, support, room);
    std::vector<std::int32_t> distinct(groups.begin(), groups.end());
    std::sort(distinct.begin(), distinct.end());
    distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
    double sum = 0;
    std::vector<Vec3> s, n;
    for (const std::int32_t group : distinct) {
        s.clear();
        n.clear();
        for (std::size_t i = 0; i < groups.size(); ++i)
            if (groups[i] == group) {
                s.push_back(positions[i]);
                n.push_back(normals[i]);
            }
        sum += volume_of_one(s, n, support, room);
    }
    return sum;
}

}  // namespace thixo
