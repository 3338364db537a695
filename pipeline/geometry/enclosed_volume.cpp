#include "pipeline/geometry/enclosed_volume.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"
#include "pipeline/geometry/implicit_surface.h"
#include "pipeline/geometry/near_runs.h"

namespace thixo {
namespace {

constexpr float kUnknown = -1;
// Cells whose centre is this near to a surfel are tested, in cell edges. Where discs overlap, these cells hold all that
// the surface cuts. No path from face to face of other cells then crosses the surface.
constexpr Real kBand = Real(1.3);
constexpr int kBits = 21;  // of a cell's coordinate in its key
constexpr double kMostCellsAcross = (1 << kBits) - 1;
constexpr std::uint64_t kRowMask = (std::uint64_t(1) << kBits) - 1;

/// Cells of half a support along the axes, from below the cloud on.
struct Lattice {
    Vec3 origin{0, 0, 0};
    Real edge = 0;
    Vec3 centre(std::uint64_t key) const {
        const auto part = [&](int n) { return static_cast<Real>(key >> (n * kBits) & kRowMask) + Real(0.5); };
        return origin + edge * Vec3(part(0), part(1), part(2));
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
    if (!(double(extent.maxCoeff()) < kMostCellsAcross))
        throw ResourceError(
            "the enclosed volume of {} surfels spread over {} x {} x {} cells is too large to compute; does matter fly "
            "away? Keep it in with boundaries",
            positions.size(), extent.x(), extent.y(), extent.z());
    return lattice;
}

/// A set of keys in an open-addressed table.
class KeySet {
  public:
    explicit KeySet(std::size_t expected) : slot_(64, kNoKey) { grow(2 * expected); }
    void add(std::uint64_t key) {
        if (2 * keys_.size() >= slot_.size()) grow(2 * slot_.size());
        std::uint64_t& slot = find(key);
        if (slot == key) return;
        slot = key;
        keys_.push_back(key);
    }
    std::vector<std::uint64_t> sorted() && {
        std::sort(keys_.begin(), keys_.end());
        return std::move(keys_);
    }

  private:
    static constexpr std::uint64_t kNoKey = ~std::uint64_t(0);
    std::uint64_t& find(std::uint64_t key) {
        std::size_t k = mix64(key) & (slot_.size() - 1);
        while (slot_[k] != kNoKey && slot_[k] != key) k = (k + 1) & (slot_.size() - 1);
        return slot_[k];
    }
    void grow(std::size_t least) {
        std::size_t size = slot_.size();
        while (size < least) size *= 2;
        slot_.assign(size, kNoKey);
        for (const std::uint64_t key : keys_) find(key) = key;
    }
    std::vector<std::uint64_t> slot_, keys_;
};

/// Keys of the cells beside the surface, ascending by (z, y, x).
std::vector<std::uint64_t> band_of(const Lattice& lattice, std::span<const Vec3> positions) {
    KeySet set(4 * positions.size());
    const auto first = [](Real from) { return static_cast<std::int64_t>(std::ceil(from - Real(0.5))); };
    const auto last = [](Real to) { return static_cast<std::int64_t>(std::floor(to - Real(0.5))); };
    for (const Vec3& p : positions) {
        const Vec3 at = (p - lattice.origin) / lattice.edge;
        for (std::int64_t z = first(at.z() - kBand); z <= last(at.z() + kBand); ++z) {
            const Real plane2 = square(kBand) - square(static_cast<Real>(z) + Real(0.5) - at.z());
            const Real tall = std::sqrt(std::max(plane2, Real(0)));
            for (std::int64_t y = first(at.y() - tall); y <= last(at.y() + tall); ++y) {
                const Real row2 = plane2 - square(static_cast<Real>(y) + Real(0.5) - at.y());
                const Real wide = std::sqrt(std::max(row2, Real(0)));
                const auto row = (static_cast<std::uint64_t>(z) << kBits | static_cast<std::uint64_t>(y)) << kBits;
                for (std::int64_t x = first(at.x() - wide); x <= last(at.x() + wide); ++x)
                    set.add(row | static_cast<std::uint64_t>(x));
            }
        }
    }
    return std::move(set).sorted();
}

/// The part of a cell on the inner side of a plane. The plane lies `value` cell edges outside the cell's centre, and
/// the part falls linearly with it. An oblique cut has another profile. The error is odd in `value`, and so it cancels
/// over the cells of a surface.
float inner_part(Real value) { return static_cast<float>(clamp01(Real(0.5) - value)); }

/// F at a point and its terms, from the surfels of one side of the surface; see ImplicitSurface::Sample.
struct Side {
    bool defined = false;
    Real value = 0, planes = 0;  // [m]
    Vec3 average{0, 0, 0};       // a, relative to the point [m]
    Vec3 normal{0, 0, 0};        // unit
    Real slope = 0;              // |grad F|
    /// The part of a cell that lies inside the surface.
    float part(Real edge) const {
        // On a curved surface the average of the surfels lies on the hollow side. The average of their planes lies as
        // far on the other side. The mean of the two distances is free of this error of a per cent of a drop's volume.
        if (slope > Real(0.2)) return inner_part((value + planes) / ((slope + 1) * edge));
        return value < 0 ? 1.0f : 0.0f;  // on a ridge of F, at the largest distance from the surface
    }
    /// Whether all points within a cell edge are on one side.
    bool far(Real edge) const { return slope > Real(0.2) && std::abs(value + planes) > (slope + 1) * edge; }
};

/// The surfels around a cell, relative to its centre. Unused places are filled with surfels that are far away.
struct Near {
    std::vector<Real> x, y, z, nx, ny, nz;
    std::size_t count = 0;
    void clear() {
        for (auto* a : {&x, &y, &z, &nx, &ny, &nz}) a->clear();
        count = 0;
    }
    void close() {
        count = x.size();
        for (auto* a : {&x, &y, &z}) a->resize(count + kLanes, Real(1e15));
        for (auto* a : {&nx, &ny, &nz}) a->resize(count + kLanes, 0);
    }
};

constexpr Real kOneSide = Real(0.9);   // normals that agree by more than this belong to one side
constexpr Real kOpposite = Real(0.5);  // least cosine between a normal and a reversed normal of the other side

class CellParts {
  public:
    CellParts(std::span<const Vec3> positions, std::span<const Vec3> normals, Real support)
        : support_(support), edge_(support / 2), per_h2_(1 / square(support)) {
        // The parts of a refined cell are evaluated at their own centres.
        grid_.build(positions, support + Real(0.44) * edge_);
        for (auto* a : {&nx_, &ny_, &nz_}) a->resize(positions.size() + PointGrid::kPadding, 0);
        for (Index slot = 0; slot < positions.size(); ++slot) {
            const Vec3& n = normals[grid_.index(slot)];
            nx_[slot] = n.x();
            ny_[slot] = n.y();
            nz_[slot] = n.z();
        }
    }

    /// The part of a cell that lies inside. Cells that see two sides, or a small drop, are evaluated in eight parts.
    float part(const Vec3& centre, Near& near) const {
        SurfelSums sums;
        for_each_near_run(grid_, centre, support_, [&](Index slot, Lanes x, Lanes y, Lanes z, Lanes r2) {
            const Lanes q = positive(1 - r2 * per_h2_);
            sums.add(q * q * q, x, y, z, load_lanes(&nx_[slot]), load_lanes(&ny_[slot]), load_lanes(&nz_[slot]));
        });
        const SurfelAverage all = sums.average();
        if (!(all.weight > 0)) return kUnknown;
        // With one side there is no ridge: F has a slope of one.
        if (all.normal.norm() > kOneSide * all.weight)
            return inner_part((all.planes / all.weight + all.value()) / (2 * edge_));
        gather(centre, near);
        bool settled = false;
        const float whole = of_two_sides(near, Vec3(0, 0, 0), edge_, settled);
        if (whole == kUnknown || settled) return whole;
        float sum = 0;
        for (unsigned k = 0; k < 8; ++k) {
            const auto offset = [&](unsigned axis) { return k >> axis & 1 ? Real(0.25) : Real(-0.25); };
            const float part = of_two_sides(near, edge_ * Vec3(offset(0), offset(1), offset(2)), edge_ / 2, settled);
            sum += part == kUnknown ? std::round(whole) : part;
        }
        return sum / 8;
    }

  private:
    void gather(const Vec3& centre, Near& near) const {
        near.clear();
        for_each_in_box(grid_, centre, grid_.cell(), [&](Index slot, Real) {
            near.x.push_back(grid_.x()[slot] - centre.x());
            near.y.push_back(grid_.y()[slot] - centre.y());
            near.z.push_back(grid_.z()[slot] - centre.z());
            near.nx.push_back(nx_[slot]);
            near.ny.push_back(ny_[slot]);
            near.nz.push_back(nz_[slot]);
        });
        near.close();
    }
    template <class F>
    void for_each_of(const Near& near, const Vec3& at, F&& f) const {
        for (std::size_t k = 0; k < near.count; k += kLanes) {
            const Lanes x = load_lanes(&near.x[k]) - at.x(), y = load_lanes(&near.y[k]) - at.y(),
                        z = load_lanes(&near.z[k]) - at.z();
            f(k, x, y, z, positive(1 - (x * x + y * y + z * z) * per_h2_));
        }
    }
    /// Evaluates the nearest surfel. False where none is within the support.
    bool nearest_normal(const Near& near, const Vec3& at, Vec3& n) const {
        Lanes most{}, which{};
        Lanes number;
        for (std::size_t l = 0; l < kLanes; ++l) number[l] = static_cast<Real>(l);
        for_each_of(near, at, [&](std::size_t k, Lanes, Lanes, Lanes, Lanes q) {
            which = q > most ? number + static_cast<Real>(k) : which;
            most = q > most ? q : most;
        });
        std::size_t best = 0;
        for (std::size_t l = 1; l < kLanes; ++l)
            if (most[l] > most[best] || (most[l] == most[best] && which[l] < which[best])) best = l;
        if (!(most[best] > 0)) return false;
        const auto i = static_cast<std::size_t>(which[best]);
        n = {near.nx[i], near.ny[i], near.nz[i]};
        return true;
    }
    /// Evaluates the surfels with n.reference >= least, or, where `sign` is negative, with n.reference <= -least.
    Side side(const Near& near, const Vec3& at, const Vec3& reference, Real least) const {
        const auto agrees = [&](std::size_t k, Lanes a) {
            const Lanes along = reference.x() * load_lanes(&near.nx[k]) + reference.y() * load_lanes(&near.ny[k]) +
                                reference.z() * load_lanes(&near.nz[k]);
            return along >= least ? a : Lanes{};
        };
        SurfelSums sums;
        Lanes sx{}, sy{}, sz{};  // sum of grad w_i, over 6/h^2
        for_each_of(near, at, [&](std::size_t k, Lanes x, Lanes y, Lanes z, Lanes q) {
            const Lanes q2 = agrees(k, q * q);
            sums.add(q2 * q, x, y, z, load_lanes(&near.nx[k]), load_lanes(&near.ny[k]), load_lanes(&near.nz[k]));
            sx += q2 * x;
            sy += q2 * y;
            sz += q2 * z;
        });
        Side side;
        const SurfelAverage all = sums.average();
        if (!all.defined()) return side;
        const Real weight = all.weight, length = all.normal.norm();
        side.defined = true;
        side.normal = all.normal / length;
        side.average = all.position / weight;
        side.planes = all.planes / weight;
        side.value = -side.normal.dot(side.average);
        //     grad F = n - (grad a)^T n + (grad n)^T (x - a)
        //     grad a = sum (s_i - a) grad w_i^T / sum w_i
        //     grad n = (1 - n n^T) sum n_i grad w_i^T / |sum w_i n_i|
        const Vec3 tilt = (side.average + side.value * side.normal) / length;
        Lanes gx{}, gy{}, gz{};
        for_each_of(near, at, [&](std::size_t k, Lanes x, Lanes y, Lanes z, Lanes q) {
            const Lanes along = x * side.normal.x() + y * side.normal.y() + z * side.normal.z();
            const Lanes turned = load_lanes(&near.nx[k]) * tilt.x() + load_lanes(&near.ny[k]) * tilt.y() +
                                 load_lanes(&near.nz[k]) * tilt.z();
            const Lanes a = agrees(k, q * q) * (along / weight + turned);
            gx += a * x;
            gy += a * y;
            gz += a * z;
        });
        const Vec3 slope(sum_of(sx), sum_of(sy), sum_of(sz)), bend(sum_of(gx), sum_of(gy), sum_of(gz));
        side.slope = (side.normal - 6 * per_h2_ * (bend + side.value / weight * slope)).norm();
        return side;
    }
    /// The answer where a cell sees two sides, of a sheet or across a gap. The two are not averaged. The side of the
    /// nearest surfel comes first. Where the other side lies behind it, inside means inside of both. Where the other
    /// side lies before it, inside means inside of either. `settled`: no part of the cell has another answer.
    float of_two_sides(const Near& near, const Vec3& at, Real edge, bool& settled) const {
        Vec3 n;
        settled = false;
        if (!nearest_normal(near, at, n)) return kUnknown;
        const Side front = side(near, at, n, -kOpposite);
        if (!front.defined) return kUnknown;
        const Side back = side(near, at, -n, kOpposite);
        settled = front.far(edge) && (!back.defined || back.far(edge));
        const float a = front.part(edge);
        if (!back.defined) return a;
        const float b = back.part(edge);
        const bool behind = (back.average - front.average).dot(front.normal) < 0;
        return behind ? std::max(0.0f, a + b - 1) : std::min(1.0f, a + b);
    }

    Real support_, edge_, per_h2_;
    PointGrid grid_;
    std::vector<Real> nx_, ny_, nz_;  // by slot
};

/// A run of undecided cells along x, between two decided cells.
struct Gap {
    std::uint64_t first, last;  // x
    Index parent;
    std::int64_t votes = 0;  // > 0: the rim is inside
    bool border = false;     // the region is joined to the border
};

/// Decides the cells that are not beside the surface and returns how many are inside. Regions that are joined to the
/// border are outside. A closed region takes the side of the larger part of its rim.
class Gaps {
  public:
    Gaps(const std::vector<std::uint64_t>& keys, const std::vector<float>& part) : keys_(keys), part_(part) {
        for (std::size_t k = 0; k < keys.size(); ++k) {
            if (k == 0 || keys[k] >> kBits != keys[k - 1] >> kBits)
                rows_.push_back({keys[k] >> kBits, k, gaps_.size()});
            else if (keys[k] > keys[k - 1] + 1)
                gaps_.push_back({(keys[k - 1] & kRowMask) + 1, (keys[k] & kRowMask) - 1, Index(gaps_.size()),
                                 vote(k - 1) + vote(k)});
        }
        rows_.push_back({~std::uint64_t(0), keys.size(), gaps_.size()});
        for (std::size_t r = 0; r + 1 < rows_.size(); ++r) {
            if (rows_[r].gap == rows_[r + 1].gap) continue;
            for (const std::int64_t beside : {-1, 1, -(1 << kBits), 1 << kBits})
                join(r, static_cast<std::uint64_t>(static_cast<std::int64_t>(rows_[r].key) + beside));
        }
    }
    double cells_inside() {
        for (std::size_t g = 0; g < gaps_.size(); ++g) {
            Gap& top = gaps_[root(static_cast<Index>(g))];
            if (&top == &gaps_[g]) continue;
            top.votes += gaps_[g].votes;
            top.border |= gaps_[g].border;
        }
        double inside = 0;
        for (std::size_t g = 0; g < gaps_.size(); ++g) {
            const Gap& top = gaps_[root(static_cast<Index>(g))];
            if (!top.border && top.votes > 0) inside += static_cast<double>(gaps_[g].last - gaps_[g].first + 1);
        }
        return inside;
    }

  private:
    struct Row {
        std::uint64_t key;      // (z, y)
        std::size_t cell, gap;  // the first of it
    };
    std::int64_t vote(std::size_t k) const { return part_[k] > 0.5f ? 1 : -1; }
    Index root(Index g) {
        while (gaps_[g].parent != g) g = gaps_[g].parent = gaps_[gaps_[g].parent].parent;
        return g;
    }
    /// Joins the gaps of row r with the cells beside them in the row of a key.
    void join(std::size_t r, std::uint64_t beside) {
        const auto other = std::lower_bound(rows_.begin(), rows_.end() - 1, beside,
                                            [](const Row& row, std::uint64_t key) { return row.key < key; });
        const bool none = other->key != beside;
        const std::size_t begin = other->cell, end = none ? begin : (other + 1)->cell;
        for (std::size_t g = rows_[r].gap; g < rows_[r + 1].gap; ++g) {
            Gap& gap = gaps_[g];
            if (none || gap.first < (keys_[begin] & kRowMask) || gap.last > (keys_[end - 1] & kRowMask))
                gap.border = true;
            if (none) continue;
            const std::uint64_t row = beside << kBits;
            const auto at = std::lower_bound(keys_.begin() + static_cast<std::ptrdiff_t>(begin),
                                             keys_.begin() + static_cast<std::ptrdiff_t>(end), row | gap.first);
            for (auto k = static_cast<std::size_t>(at - keys_.begin()); k < end && (keys_[k] & kRowMask) <= gap.last;
                 ++k)
                gap.votes += vote(k);
            for (std::size_t b = other->gap; b < (other + 1)->gap; ++b)
                if (gaps_[b].first <= gap.last && gaps_[b].last >= gap.first)
                    gaps_[root(static_cast<Index>(g))].parent = root(static_cast<Index>(b));
        }
    }
    const std::vector<std::uint64_t>& keys_;
    const std::vector<float>& part_;
    std::vector<Row> rows_;
    std::vector<Gap> gaps_;
};

using Room = std::function<Real(const Vec3&)>;

double volume_of_one(std::span<const Vec3> positions, std::span<const Vec3> normals, Real support, const Room& room) {
    if (positions.empty()) return 0;
    const Lattice lattice = lattice_around(positions, support);
    const CellParts cells(positions, normals, support);
    std::vector<std::uint64_t> keys = band_of(lattice, positions);
    std::vector<float> part(keys.size());
    parallel_chunks(
        keys.size(),
        [&](std::size_t begin, std::size_t end, std::size_t) {
            Near near;
            for (std::size_t k = begin; k < end; ++k) {
                const Vec3 centre = lattice.centre(keys[k]);
                part[k] = cells.part(centre, near);
                if (room && part[k] > 0) part[k] = std::min(part[k], inner_part(-room(centre) / lattice.edge));
            }
        },
        256);
    std::size_t known = 0;
    for (std::size_t k = 0; k < keys.size(); ++k) {
        if (part[k] == kUnknown) continue;
        keys[known] = keys[k];
        part[known++] = part[k];
    }
    keys.resize(known);
    part.resize(known);
    if (known == 0) return 0;
    const double beside = parallel_sum(known, [&](std::size_t k) { return static_cast<double>(part[k]); });
    return (beside + Gaps(keys, part).cells_inside()) * cube(static_cast<double>(lattice.edge));
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
    std::vector<Vec3> own_positions, own_normals;
    for (const std::int32_t group : distinct) {
        own_positions.clear();
        own_normals.clear();
        for (std::size_t i = 0; i < groups.size(); ++i)
            if (groups[i] == group) {
                own_positions.push_back(positions[i]);
                own_normals.push_back(normals[i]);
            }
        sum += volume_of_one(own_positions, own_normals, support, room);
    }
    return sum;
}

}  // namespace thixo
