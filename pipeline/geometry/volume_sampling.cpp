#include "pipeline/geometry/volume_sampling.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/geometry/packing.h"
#include "pipeline/geometry/point_grid.h"
#include "pipeline/geometry/shape_checks.h"
#include "pipeline/geometry/shapes.h"

namespace thixo {
namespace {

constexpr double kMostCells = double(1u << 27);
constexpr int kParts = 4;  // parts of a cell's edge, to find the part of the cell that is inside

/// A cell of a level as one number that orders by (z, y, x). Its coordinates count its own edges from the grid's
/// corner.
using Key = std::uint64_t;
constexpr Key kField = (1u << 21) - 1;
Key key_of(std::int64_t x, std::int64_t y, std::int64_t z) {
    return static_cast<Key>(z) << 42 | static_cast<Key>(y) << 21 | static_cast<Key>(x);
}
Eigen::Array3i cell_of(Key k) {
    return {static_cast<int>(k & kField), static_cast<int>(k >> 21 & kField), static_cast<int>(k >> 42)};
}
void sort_unique(std::vector<Key>& keys) {
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
}
bool contains(const std::vector<Key>& sorted, Key k) { return std::binary_search(sorted.begin(), sorted.end(), k); }

/// The grid of the widest cells. The rows of the finest cells are centred in the shape's box.
struct Grid {
    Grid(const Box3& box, double spacing, int levels_) : edge0(spacing), levels(levels_) {
        const double widest = std::ldexp(1, levels);
        Eigen::Array3d number;
        for (int a = 0; a < 3; ++a) {
            const double low = static_cast<double>(box.lower[a]), high = static_cast<double>(box.upper[a]);
            const double rows = std::max(1.0, std::round((high - low) / spacing));
            number[a] = std::ceil((rows + 2) / widest);
            corner[a] = 0.5 * (low + high) - spacing * (0.5 * rows + std::floor((number[a] * widest - rows) / 2));
        }
        if (!(number.prod() * 8 < kMostCells) || !(number.maxCoeff() * widest < double(kField)))
            throw InputError("a body of {} x {} x {} cells of {} m is too finely sampled; raise solver.spacing",
                             number.x() * widest, number.y() * widest, number.z() * widest, spacing);
        count = number.cast<int>();
    }
    double edge(int level) const { return std::ldexp(edge0, level); }
    Vec3 centre(Key k, int level) const {
        return (corner + edge(level) * (cell_of(k).cast<double>() + 0.5).matrix()).cast<Real>();
    }
    double edge0;
    int levels;
    Vec3d corner;
    Eigen::Array3i count;
};

/// Whether a cell is too near the surface to be this wide. Its box then reaches the tangent plane of the nearest
/// surface, or is nearer to it than one cell of every finer level.
bool to_be_split(const Shape& shape, const Grid& grid, Key k, int level) {
    const Real edge = static_cast<Real>(grid.edge(level));
    const Vec3 x = grid.centre(k, level);
    const Real d = std::abs(shape.distance(x)) - static_cast<Real>(grid.edge(level) - grid.edge0);
    if (d > Real(0.8661) * edge) return false;
    const Vec3 n = shape.gradient(x, Real(0.05) * edge);
    const Real across = n.cwiseAbs().sum();
    return d <= Real(0.55) * edge * (across > 0 ? across : Real(1.74));
}

std::vector<Key> children(const std::vector<Key>& cells) {
    std::vector<Key> parts;
    parts.reserve(8 * cells.size());
    for (const Key k : cells) {
        const Eigen::Array3i c = 2 * cell_of(k);
        for (int i = 0; i < 8; ++i) parts.push_back(key_of(c.x() + (i & 1), c.y() + (i >> 1 & 1), c.z() + (i >> 2)));
    }
    return parts;
}

template <class Keep>
std::vector<Key> chosen(const std::vector<Key>& cells, Keep&& keep) {
    std::vector<char> is(cells.size());
    parallel_for(cells.size(), [&](std::size_t i) { is[i] = keep(cells[i]); });
    std::vector<Key> result;
    for (std::size_t i = 0; i < cells.size(); ++i)
        if (is[i]) result.push_back(cells[i]);
    return result;
}

/// The cells one level up that must be split, so that the neighbours of these cells are not wider than they are.
void add_parents_of_neighbours(const std::vector<Key>& cells, const Eigen::Array3i& count, std::vector<Key>& parents) {
    for (const Key k : cells) {
        const Eigen::Array3i c = cell_of(k);
        for (int i = 0; i < 27; ++i) {
            const Eigen::Array3i n = c + Eigen::Array3i(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
            if ((n >= 0).all() && (n < count).all()) parents.push_back(key_of(n.x() / 2, n.y() / 2, n.z() / 2));
        }
    }
    sort_unique(parents);
}

struct Leaf {
    Key key;
    int level;
};

/// The leaves of the balanced octree that may have a part inside.
std::vector<Leaf> octree_leaves(const Shape& shape, const Grid& grid) {
    std::vector<Key> top;
    for (int z = 0; z < grid.count.z(); ++z)
        for (int y = 0; y < grid.count.y(); ++y)
            for (int x = 0; x < grid.count.x(); ++x) top.push_back(key_of(x, y, z));
    std::vector<std::vector<Key>> split(static_cast<std::size_t>(grid.levels) + 1);  // by level; none of level 0
    for (int level = grid.levels; level > 0; --level) {
        const auto at = static_cast<std::size_t>(level);
        split[at] = chosen(level == grid.levels ? top : children(split[at + 1]),
                           [&](Key k) { return to_be_split(shape, grid, k, level); });
    }
    for (int level = 2; level <= grid.levels; ++level) {
        const auto at = static_cast<std::size_t>(level);
        add_parents_of_neighbours(split[at - 1], grid.count * (1 << (grid.levels - level + 1)), split[at]);
    }
    for (auto& cells : split) sort_unique(cells);
    std::vector<Leaf> leaves;
    for (int level = grid.levels; level >= 0; --level) {
        const auto at = static_cast<std::size_t>(level);
        const double half = 0.8661 * grid.edge(level);
        const std::vector<Key> cells = chosen(level == grid.levels ? top : children(split[at + 1]), [&](Key k) {
            return !(level > 0 && contains(split[at], k)) &&
                   static_cast<double>(shape.distance(grid.centre(k, level))) < half;
        });
        for (const Key k : cells) leaves.push_back({k, level});
    }
    const auto place = [&](const Leaf& leaf) {
        const Eigen::Array3i c = cell_of(leaf.key) * (1 << leaf.level);
        return key_of(c.x(), c.y(), c.z());
    };
    std::sort(leaves.begin(), leaves.end(), [&](const Leaf& a, const Leaf& b) { return place(a) < place(b); });
    return leaves;
}

/// Adds the volume in cells without a particle to the nearest particle.
void share_out(const std::vector<Vec3>& places, const std::vector<double>& volumes, Real spacing, SampledVolume& result,
               std::vector<double>& volume) {
    PointGrid grid;
    grid.build(result.position, 2 * spacing);
    std::vector<std::pair<Real, Index>> found;
    for (std::size_t i = 0; i < places.size(); ++i) {
        if (volumes[i] <= 0) continue;
        grid.nearest(places[i], 1, std::numeric_limits<Real>::max(), found);
        volume[found[0].second] += volumes[i];
    }
}

SampledVolume sample_octree(const Shape& shape, const Box3& box, double spacing, int levels) {
    const Grid grid(box, spacing, levels);
    const std::vector<Leaf> leaves = octree_leaves(shape, grid);
    std::vector<double> inside(leaves.size());
    std::vector<char> particle(leaves.size());
    parallel_for(leaves.size(), [&](std::size_t i) {
        const Vec3 centre = grid.centre(leaves[i].key, leaves[i].level);
        inside[i] = volume_inside(shape, centre, Vec3d::Constant(grid.edge(leaves[i].level)));
        particle[i] = shape.distance(centre) < 0;
    });
    SampledVolume result;
    std::vector<double> volume, left_volume;
    std::vector<Vec3> left;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        const Vec3 centre = grid.centre(leaves[i].key, leaves[i].level);
        (particle[i] ? result.position : left).push_back(centre);
        (particle[i] ? volume : left_volume).push_back(inside[i]);
        if (particle[i]) result.spacing.push_back(static_cast<Real>(grid.edge(leaves[i].level)));
    }
    if (result.position.empty()) return result;
    share_out(left, left_volume, static_cast<Real>(spacing), result, volume);
    result.total = std::accumulate(volume.begin(), volume.end(), 0.0);
    for (const double v : volume) result.volume.push_back(static_cast<Real>(v));
    return result;
}

SampledVolume sample_packing(const Shape& shape, const Box3& box, double spacing) {
    SampledVolume result;
    const Vec3d steps = packing_steps(static_cast<Real>(spacing));
    Eigen::Array3d rows, first;
    for (int a = 0; a < 3; ++a) {
        const double low = static_cast<double>(box.lower[a]), high = static_cast<double>(box.upper[a]);
        rows[a] = std::max(1.0, std::round((high - low) / steps[a]));
        first[a] = 0.5 * (low + high) - 0.5 * (rows[a] - 1) * steps[a];
    }
    if (!(rows.prod() < kMostCells))
        throw InputError("a body of {} x {} x {} particles is too finely sampled; raise solver.spacing", rows.x(),
                         rows.y(), rows.z());
    // Odd rows are shifted by half a site along x, odd layers by a third of a row along y.
    const Vec3 origin = (first - Eigen::Array3d(0.25, 1.0 / 6, 0) * steps.array()).matrix().cast<Real>();
    const Eigen::Array3i count = rows.cast<int>();
    std::vector<std::vector<std::pair<Vec3, double>>> layers(static_cast<std::size_t>(count.z()));
    parallel_for(
        layers.size(),
        [&](std::size_t k) {
            for (int j = -1; j <= count.y(); ++j)
                for (int i = -1; i <= count.x(); ++i) {
                    const Vec3 site = origin + packing_site(i, j, static_cast<int>(k), static_cast<Real>(spacing));
                    if (shape.distance(site) < 0)
                        layers[k].emplace_back(site, volume_inside(shape, site, Vec3d::Constant(spacing)));
                }
        },
        1);
    double sum = 0;
    for (const auto& layer : layers)
        for (const auto& [site, volume] : layer) sum += volume;
    result.total = volume(shape, spacing / 3);
    for (const auto& layer : layers)
        for (const auto& [site, part] : layer) {
            result.position.push_back(site);
            result.volume.push_back(static_cast<Real>(part * result.total / sum));
            result.spacing.push_back(static_cast<Real>(spacing));
        }
    return result;
}

SampledVolume sample_spaced(const Shape& shape, const Box3& box, const VolumeSampling& sampling, double spacing) {
    if (sampling.lattice == Lattice::hexagonal) return sample_packing(shape, box, spacing);
    return sample_octree(shape, box, spacing, sampling.lattice == Lattice::octree ? sampling.levels : 0);
}

/// The spacing whose sampling comes nearest to the count. The number of particles varies as a power of the spacing,
/// between its inverse square and its inverse cube.
SampledVolume sample_counted(const Shape& shape, const Box3& box, const VolumeSampling& sampling) {
    const double wanted = static_cast<double>(sampling.count);
    const Vec3d size = (box.upper - box.lower).cast<double>();
    double spacing = std::cbrt(size.prod() / wanted);
    SampledVolume best;
    const auto off = [&](const SampledVolume& v) {
        return v.position.empty() ? 1e9 : std::abs(std::log(static_cast<double>(v.position.size()) / wanted));
    };
    for (int i = 0; i < 12 && off(best) > 0.02; ++i) {
        SampledVolume v = sample_spaced(shape, box, sampling, spacing);
        spacing *= v.position.empty() ? 0.5 : std::pow(static_cast<double>(v.position.size()) / wanted, 0.4);
        if (off(v) < off(best)) best = std::move(v);
    }
    return best;
}

}  // namespace

double volume_inside(const Shape& shape, const Vec3& centre, const Vec3d& edges) {
    const double d = static_cast<double>(shape.distance(centre)), reach = 0.50001 * edges.norm();
    if (d < -reach) return edges.prod();
    if (d > reach) return 0;
    const Vec3d part = edges / kParts;
    const double width = std::cbrt(part.prod());
    double sum = 0;
    for (int i = 0; i < cube(kParts); ++i) {
        const Vec3d at(i % kParts, i / kParts % kParts, i / kParts / kParts);
        const Vec3d x = centre.cast<double>() + part.cwiseProduct(at + Vec3d::Constant(0.5 - 0.5 * kParts));
        sum += clamp01(0.5 - static_cast<double>(shape.distance(x.cast<Real>())) / width);
    }
    return sum * part.prod();
}

SampledVolume sample_volume(const Shape& shape, const VolumeSampling& sampling) {
    size_not_negative(sampling.spacing, "particle spacing");
    if ((sampling.count > 0) == (sampling.spacing > 0))
        throw InputError("a body is sampled by a count of particles or by their spacing; give one of the two");
    if (sampling.levels < 0 || sampling.levels > 10)
        throw InputError("sampling levels are {}; use 0 to 10", sampling.levels);
    const auto box = shape.bounds();
    if (!box) throw InputError("a body's shape has no bounds; intersect it with a box");
    SampledVolume result = sampling.count > 0 ? sample_counted(shape, *box, sampling)
                                              : sample_spaced(shape, *box, sampling, sampling.spacing);
    if (result.position.empty())
        throw InputError("no particle lies inside a body of the size {} x {} x {} m; use a smaller spacing",
                         box->upper.x() - box->lower.x(), box->upper.y() - box->lower.y(),
                         box->upper.z() - box->lower.z());
    return result;
}

}  // namespace thixo
