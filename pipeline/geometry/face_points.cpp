#include "pipeline/geometry/face_points.h"

#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"
#include "pipeline/geometry/bounds.h"
#include "pipeline/geometry/local_shape.h"
#include "pipeline/geometry/point_grid.h"
#include "pipeline/geometry/surface_sampling.h"

namespace thixo {
namespace {

constexpr int kPerCell = 3;           // random points in a cell
constexpr double kLayer = 0.25;       // half thickness of the layer, in cells
constexpr Real kStep = Real(0.05);    // for differences, in spacings
constexpr Real kBeside = Real(0.05);  // how far beside a point its side is evaluated, in spacings
constexpr Real kSteeper = 2;          // factor by which the slope of a distance may vary within a cell
constexpr Real kRounded = Real(1.001);
constexpr double kMostCellsOfFace = 1e8;
constexpr double kPerBlock = 8;  // spacings an edge of a block that leaves parts of a shape out

struct Cell {
    std::int32_t x, y, z;
};

InputError too_many(double spacing) {
    return InputError("a surface at spacing {} m needs too many surfels; ask for fewer or a larger spacing", spacing);
}

/// The cubes of the final edge that the layer around the face may cross, near the solid's surface.
class CellSearch {
  public:
    CellSearch(const FacedSolid& solid, const Face& face, double spacing, double reach)
        : solid_(solid), face_(face), reach_(reach), edge_(spacing / 2) {
        const Box3 box = grown(solid.bounds, static_cast<Real>(reach + spacing));
        origin_ = box.lower.cast<double>();
        const Vec3d extent = (box.upper - box.lower).cast<double>();
        int level = 0;
        while (edge_ * std::ldexp(1, level) < extent.maxCoeff() / 4) ++level;
        size_ = std::ldexp(edge_, level);
        const Eigen::Array3i count = (extent.array() / size_).ceil().max(1).cast<int>();
        for (int z = 0; z < count.z(); ++z)
            for (int y = 0; y < count.y(); ++y)
                for (int x = 0; x < count.x(); ++x) cells_.push_back({x, y, z});
        keep_near();
        for (; level > 0; --level) {
            split();
            keep_near();
        }
    }
    const std::vector<Cell>& cells() const { return cells_; }
    Vec3 centre(const Cell& c) const { return (lower(c) + Vec3d::Constant(size_ / 2)).cast<Real>(); }
    /// Distance of the centre of cell i from the face.
    Real distance(std::size_t i) const { return distance_[i]; }
    double edge() const { return edge_; }
    Vec3d lower(const Cell& c) const { return origin_ + size_ * Vec3d(c.x, c.y, c.z); }

  private:
    void keep_near() {
        std::vector<char> near(cells_.size());
        distance_.resize(cells_.size());
        const double half = 0.8661 * size_;
        parallel_for(cells_.size(), [&](std::size_t i) {
            const Vec3 at = centre(cells_[i]);
            distance_[i] = face_.distance(at);
            near[i] =
                std::abs(static_cast<double>(distance_[i])) <= half + kLayer * edge_ &&
                (solid_.single() || std::abs(static_cast<double>(solid_.shape.distance(at))) <= half + reach_ + edge_);
        });
        std::size_t kept = 0;
        for (std::size_t i = 0; i < cells_.size(); ++i)
            if (near[i]) {
                distance_[kept] = distance_[i];
                cells_[kept++] = cells_[i];
            }
        cells_.resize(kept);
        distance_.resize(kept);
    }
    void split() {
        if (8.0 * static_cast<double>(cells_.size()) > kMostCellsOfFace) throw too_many(2 * edge_);
        std::vector<Cell> parts;
        parts.reserve(8 * cells_.size());
        for (const Cell& c : cells_)
            for (int k = 0; k < 8; ++k)
                parts.push_back({2 * c.x + (k & 1), 2 * c.y + (k >> 1 & 1), 2 * c.z + (k >> 2)});
        cells_ = std::move(parts);
        size_ /= 2;
    }

    const FacedSolid& solid_;
    const Face& face_;
    double reach_, edge_, size_ = 0;
    Vec3d origin_;
    std::vector<Cell> cells_;
    std::vector<Real> distance_;  // of their centres from the face
};

/// Point j of a cell in its unit cube: a low-discrepancy sequence from a random start.
Vec3d point_in_cell(std::uint64_t seed, std::uint64_t face, const Cell& c, int j) {
    const std::uint64_t id =
        static_cast<std::uint64_t>(c.x) << 42 ^ static_cast<std::uint64_t>(c.y) << 21 ^ static_cast<std::uint64_t>(c.z);
    const Vec3d step(0.8191725133961645, 0.6710436067037893, 0.5497004779019703);
    Vec3d u;
    for (int k = 0; k < 3; ++k) {
        u[k] = random_unit(seed, id, face, static_cast<std::uint64_t>(k)) + j * step[k];
        u[k] -= std::floor(u[k]);
    }
    return u;
}

struct Candidate {
    Vec3 position, normal;
    OnSurface on_surface;
};

using Found = std::vector<std::vector<Candidate>>;  // by chunk

/// The area that a point stands for. The points of a cell share its volume. The volume of the layer is the area times
///     2 kLayer edge
double area_of_point(double spacing) { return square(spacing / 2) / (kPerCell * 2 * kLayer); }

Found points_in_layer(const FacedSolid& solid, int k, double spacing, double reach, std::uint64_t seed) {
    const Face& face = solid.faces[static_cast<std::size_t>(k)];
    const CellSearch search(solid, face, spacing, reach);
    const std::vector<Cell>& cells = search.cells();
    const Real layer = static_cast<Real>(kLayer * search.edge()), size = static_cast<Real>(spacing);
    Found found((cells.size() + kChunk - 1) / kChunk);
    parallel_chunks(cells.size(), [&](std::size_t begin, std::size_t end, std::size_t chunk) {
        for (std::size_t i = begin; i < end; ++i) {
            Real slope = Real(1) / kSteeper;  // assumed for distances in the cell
            const Real away = std::abs(search.distance(i));
            const Vec3 centre = search.centre(cells[i]);
            for (int j = 0; j < kPerCell; ++j) {
                const Vec3d u = point_in_cell(seed, static_cast<std::uint64_t>(k), cells[i], j);
                Candidate c;
                c.position = (search.lower(cells[i]) + search.edge() * u).cast<Real>();
                // A distance changes by no more than the way that a point moves.
                if (square(away - layer) > (c.position - centre).squaredNorm() * kRounded && away > layer) continue;
                const Real d = face.distance(c.position);
                if (!(std::abs(d) < layer * std::min(kSteeper * slope, Real(1)))) continue;
                // Only for a point on a face it is known whether the face bounds the solid there.
                if (!bring_near(face, size, layer, c.position, c.normal, &slope) ||
                    (!solid.single() && !project_onto(face, size, c.position, c.normal)))
                    continue;
                c.on_surface = solid.on_surface(c.position, c.normal, k, size);
                found[chunk].push_back(c);
            }
        }
    });
    return found;
}

Found points_of_surface(const FacedSolid& solid, int k, double spacing, std::uint64_t seed) {
    const DirectSurface& surface = *solid.faces[static_cast<std::size_t>(k)].surface;
    const double wanted = surface.area() / area_of_point(spacing);
    if (!(wanted < kMostCellsOfFace)) throw too_many(spacing);
    const auto count = static_cast<std::size_t>(std::ceil(wanted));
    Found found((count + kChunk - 1) / kChunk);
    parallel_chunks(count, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
        for (std::size_t i = begin; i < end; ++i) {
            const auto random = [&](std::uint64_t use) {
                return random_unit(seed, i, static_cast<std::uint64_t>(k), use);
            };
            Candidate c;
            surface.point((static_cast<double>(i) + random(3)) / static_cast<double>(count), random(4), random(5),
                          c.position, c.normal);
            turn_outwards(solid.faces[static_cast<std::size_t>(k)], static_cast<Real>(spacing), c.position, c.normal);
            c.on_surface = solid.on_surface(c.position, c.normal, k, static_cast<Real>(spacing));
            found[chunk].push_back(c);
        }
    });
    return found;
}

FacePoints face_points(const FacedSolid& solid, int k, double spacing, double reach, std::uint64_t seed) {
    const Found found = solid.faces[static_cast<std::size_t>(k)].surface
                            ? points_of_surface(solid, k, spacing, seed)
                            : points_in_layer(solid, k, spacing, reach, seed);
    FacePoints points;
    std::vector<Vec3> seen;  // on the surface
    for (const auto& chunk : found)
        for (const Candidate& c : chunk)
            if (c.on_surface == OnSurface::yes)
                seen.push_back(c.position);
            else if (c.on_surface == OnSurface::thin)
                ++points.thin;
    PointGrid grid;
    grid.build(seen, static_cast<Real>(reach));
    std::vector<Candidate> all;
    for (const auto& chunk : found) all.insert(all.end(), chunk.begin(), chunk.end());
    std::vector<Real> beyond(all.size());
    parallel_for(all.size(), [&](std::size_t i) {
        Real nearest2 = static_cast<Real>(reach * reach);
        if (all[i].on_surface == OnSurface::yes)
            nearest2 = 0;
        else
            grid.for_each_neighbour(all[i].position, static_cast<Real>(reach),
                                    [&](Index, Real r2) { nearest2 = std::min(nearest2, r2); });
        beyond[i] = std::sqrt(nearest2);
    });
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (!(beyond[i] < static_cast<Real>(reach))) continue;
        points.position.push_back(all[i].position);
        points.normal.push_back(all[i].normal);
        points.beyond.push_back(beyond[i]);
    }
    return points;
}

}  // namespace

FacedSolid::FacedSolid(const Shape& solid, const Box3& box, double spacing)
    : shape(solid), bounds(box), tree(without_differences(faces_of(solid))) {
    for (const Shape& face : number_faces(tree)) {
        const auto surface = face.node().direct_surface();
        faces.push_back({surface ? face : by_blocks(face, kPerBlock * spacing), surface});
    }
    if (!single()) shape = by_blocks(shape, kPerBlock * spacing);
}

OnSurface FacedSolid::on_surface(const Vec3& x, const Vec3& normal, int k, Real spacing) const {
    if (single()) return OnSurface::yes;
    if (!(std::abs(shape.distance(x)) <= Real(0.5) * spacing)) return OnSurface::no;
    const Real rounding = Real(4e-6) * std::max(bounds.lower.cwiseAbs().maxCoeff(), bounds.upper.cwiseAbs().maxCoeff());
    if (!bounds_solid(tree, k, std::max(Real(1e-3) * spacing, rounding),
                      [&](int f) { return faces[static_cast<std::size_t>(f)].distance(x); }))
        return OnSurface::no;
    // Where a face of the other side coincides with this one, this one does not bound the solid.
    const Real step = std::max(static_cast<Real>(kThinnest) * spacing, 4 * rounding);
    if (!(shape.distance(x + step * normal) > 0)) return OnSurface::no;
    if (shape.distance(x - step * normal) < 0) return OnSurface::yes;
    for (Real less = step / 2; less > rounding; less /= 2)
        if (shape.distance(x - less * normal) < 0) return OnSurface::thin;
    return OnSurface::no;
}

SolidPoints points_on_faces(const FacedSolid& solid, double spacing, double reach, std::uint64_t seed) {
    SolidPoints points;
    for (std::size_t k = 0; k < solid.faces.size(); ++k)
        points.faces.push_back(face_points(solid, static_cast<int>(k), spacing, reach, seed));
    points.area = area_of_point(spacing);
    return points;
}

void turn_outwards(const Face& face, Real spacing, const Vec3& x, Vec3& normal) {
    const Real beside = kBeside * spacing;
    if (!(face.distance(x + beside * normal) < 0)) return;
    const Vec3 out = face.gradient(x, beside);
    if (!out.isZero()) normal = out;
}

bool bring_near(const Face& face, Real spacing, Real most, Vec3& x, Vec3& normal, Real* slope_there) {
    if (face.surface) {
        face.surface->project(x, normal);
        return true;
    }
    Vec3 g;
    const Real d = face.shape.sloped(x, kStep * spacing, g), slope2 = g.squaredNorm(), slope = std::sqrt(slope2);
    if (slope_there) *slope_there = slope;
    if (!(slope2 > Real(1e-4)) || !(std::abs(d) < most * slope)) return false;
    x -= d / slope2 * g;
    normal = g / slope;
    return true;
}

bool project_onto(const Face& face, Real spacing, Vec3& x, Vec3& normal) {
    if (face.surface) {
        face.surface->project(x, normal);
        return true;
    }
    constexpr int kSteps = 12, kKept = 3;  // steps, and how many of them reuse a gradient by differences
    const bool known = face.shape.knows_slope();
    Vec3 y = x, g = Vec3::Zero();
    Real d = 0, slope = 0;
    const auto look = [&] {
        d = face.shape.sloped(y, kStep * spacing, g);
        slope = g.norm();
        return slope > Real(1e-2);
    };
    bool looked = false;  // whether the distance at y is known
    for (int i = 0; i < kSteps; ++i) {
        looked = known || i % kKept == 0;
        if (looked && !look()) return false;
        if (!known) d = face.distance(y);
        const Real step = d / slope;
        if (std::abs(step) < Real(1e-5) * spacing) break;
        y -= std::clamp(step, -spacing, spacing) / slope * g;
        looked = false;
    }
    if (!(std::abs(d) < Real(1e-2) * spacing)) return false;
    if (!looked && !look()) return false;
    normal = g / slope;
    x = y;
    return true;
}

}  // namespace thixo
