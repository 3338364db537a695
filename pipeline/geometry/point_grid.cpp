#include "pipeline/geometry/point_grid.h"

#include <oneapi/tbb/parallel_sort.h>

#include <functional>
#include <numeric>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"

namespace thixo {
namespace {

// A table of cells is used up to this many cells per point, which is 32 bytes per point. Beyond, only occupied cells
// are stored.
constexpr double kCellsPerPoint = 8;
constexpr double kCellsAlways = 65536;

/// Divides the indices 0..n - 1 into many with ascending keys and few strays (after Emil Ernerfeldt's drop-merge sort).
/// Gives up where more than a quarter are strays.
template <class Before>
bool part_strays(std::size_t n, Before&& before, std::vector<Index>& kept, std::vector<Index>& strays) {
    constexpr std::size_t kRow = 8;  // after so many strays in a row the index kept before them is the stray
    kept.reserve(n);
    std::size_t row = 0;
    for (std::size_t i = 0; i < n;) {
        const auto a = static_cast<Index>(i);
        if (kept.empty() || !before(a, kept.back())) {
            kept.push_back(a);
            row = 0;
            ++i;
        } else if (row == 0 && (kept.size() < 2 || !before(a, kept[kept.size() - 2]))) {
            strays.push_back(kept.back());
            kept.back() = a;
            ++i;
        } else if (row < kRow) {
            strays.push_back(a);
            ++row;
            ++i;
        } else {
            strays.resize(strays.size() - row);
            i -= row;
            row = 0;
            do {
                strays.push_back(kept.back());
                kept.pop_back();
            } while (!kept.empty() && before(static_cast<Index>(i), kept.back()));
        }
        if (strays.size() > n / 4) return false;
    }
    return true;
}

bool finite(const Vec3& p) { return std::isfinite(p.x()) && std::isfinite(p.y()) && std::isfinite(p.z()); }

}  // namespace

double PointGrid::edge_inverse(Real cell) {
    THIXO_ASSERT(cell > 0 && std::isfinite(cell), "cell edge {} of a point grid", cell);
    return 1.0 / (static_cast<double>(cell) * (1.0 + 1e-5));
}

std::vector<Index> PointGrid::order_by(std::span<const std::uint64_t> keys, std::span<const std::int64_t> ids) {
    const auto before = [&](Index a, Index b) {
        if (keys[a] != keys[b]) return keys[a] < keys[b];
        if (!ids.empty() && ids[a] != ids[b]) return ids[a] < ids[b];
        return a < b;
    };
    // From step to step few particles change their cell. Only these are sorted, and merged with the others.
    std::vector<Index> kept, strays;
    if (part_strays(keys.size(), before, kept, strays)) {
        if (strays.empty()) return kept;
        oneapi::tbb::parallel_sort(strays.begin(), strays.end(), before);
        std::vector<Index> sorted(keys.size());
        std::merge(kept.begin(), kept.end(), strays.begin(), strays.end(), sorted.begin(), before);
        return sorted;
    }
    kept.resize(keys.size());
    std::iota(kept.begin(), kept.end(), Index(0));
    oneapi::tbb::parallel_sort(kept.begin(), kept.end(), before);
    return kept;
}

std::vector<Index> PointGrid::sort_order(std::span<const Vec3> points, std::span<const std::int64_t> ids, Real cell) {
    THIXO_ASSERT(ids.size() == points.size(), "{} ids for {} points", ids.size(), points.size());
    const double inverse = edge_inverse(cell);
    std::vector<std::uint64_t> keys(points.size());
    parallel_for(points.size(), [&](std::size_t i) {
        const Vec3& p = points[i];
        keys[i] = key({coordinate(p.x(), inverse), coordinate(p.y(), inverse), coordinate(p.z(), inverse)});
    });
    return order_by(keys, ids);
}

void PointGrid::build(std::span<const Vec3> points, Real cell) {
    cell_ = cell;
    edge_inv_ = edge_inverse(cell);
    count_ = points.size();
    THIXO_ASSERT(count_ < kNone, "{} points are more than an index can count", count_);
    // Keys are stored only where they are used: for sorting, and for finding cells without a table.
    keys_.clear();
    order_.clear();
    const std::size_t descents = parallel_reduce(
        count_, std::size_t(0),
        [&](std::size_t i) { return i > 0 && key(cell_of(points[i])) < key(cell_of(points[i - 1])) ? 1u : 0u; },
        std::plus<std::size_t>());
    if (descents > 0) {
        store_keys(points);
        order_ = order_by(keys_, {});
        std::vector<std::uint64_t> sorted(count_);
        parallel_for(count_, [&](std::size_t slot) { sorted[slot] = keys_[order_[slot]]; });
        keys_.swap(sorted);
    }
    // Padding and points that are not finite get infinite coordinates, so that they fail every distance test.
    const Real nowhere = std::numeric_limits<Real>::infinity();
    for (auto* array : {&x_, &y_, &z_}) array->resize(count_ + kPadding);
    for (std::size_t slot = count_; slot < count_ + kPadding; ++slot) x_[slot] = y_[slot] = z_[slot] = nowhere;
    parallel_for(count_, [&](std::size_t slot) {
        const Vec3& p = points[index(static_cast<Index>(slot))];
        const bool good = finite(p);
        x_[slot] = good ? p.x() : nowhere;
        y_[slot] = good ? p.y() : nowhere;
        z_[slot] = good ? p.z() : nowhere;
    });
    index_cells(points);
}

void PointGrid::store_keys(std::span<const Vec3> points) {
    keys_.resize(count_);
    parallel_for(count_, [&](std::size_t i) { keys_[i] = key(cell_of(points[i])); });
}

void PointGrid::index_cells(std::span<const Vec3> points) {
    const auto cell_at = [&](std::size_t slot) { return cell_of(points[index(static_cast<Index>(slot))]); };
    start_.clear();
    lower_ = {0, 0, 0};
    upper_ = {-1, -1, -1};
    if (count_ == 0) return;
    struct Box {
        Cell lower, upper;
    };
    const auto join = [](const Box& a, const Box& b) {
        return Box{{std::min(a.lower.x, b.lower.x), std::min(a.lower.y, b.lower.y), std::min(a.lower.z, b.lower.z)},
                   {std::max(a.upper.x, b.upper.x), std::max(a.upper.y, b.upper.y), std::max(a.upper.z, b.upper.z)}};
    };
    const Cell first = cell_at(0);
    const Box box = parallel_reduce(
        count_, Box{first, first},
        [&](std::size_t slot) {
            const Cell c = cell_at(slot);
            return Box{c, c};
        },
        join);
    lower_ = box.lower;
    upper_ = box.upper;
    columns_ = static_cast<std::size_t>(upper_.x - lower_.x) + 1;
    rows_ = static_cast<std::size_t>(upper_.y - lower_.y) + 1;
    const std::size_t layers = static_cast<std::size_t>(upper_.z - lower_.z) + 1;
    const double cells = static_cast<double>(columns_) * static_cast<double>(rows_) * static_cast<double>(layers);
    if (cells > std::max(kCellsAlways, kCellsPerPoint * static_cast<double>(count_))) {
        if (keys_.empty()) store_keys(points);
        return index_rows(layers);
    }
    // start_[c] is the first slot whose cell is c or later. A slot fills the entries after its predecessor's cell, up to
    // its own.
    start_.resize(static_cast<std::size_t>(cells) + 1);
    const auto dense = [&](std::size_t slot) {
        const Cell c = cell_at(slot);
        return dense_key(c.x, c.y, c.z);
    };
    parallel_for(count_ + 1, [&](std::size_t slot) {
        const std::size_t begin = slot == 0 ? 0 : dense(slot - 1) + 1;
        const std::size_t end = slot == count_ ? start_.size() : dense(slot) + 1;
        for (std::size_t c = begin; c < end; ++c) start_[c] = static_cast<Index>(slot);
    });
}

/// A splash with a few distant drops has a large box, but its table of rows is small.
void PointGrid::index_rows(std::size_t layers) {
    row_start_.clear();
    const double rows = static_cast<double>(rows_) * static_cast<double>(layers);
    if (rows > std::max(kCellsAlways, kCellsPerPoint * static_cast<double>(count_))) return;
    row_start_.resize(static_cast<std::size_t>(rows) + 1);
    parallel_for(row_start_.size(), [&](std::size_t r) {
        const Cell first{lower_.x, lower_.y + static_cast<std::int32_t>(r % rows_),
                         lower_.z + static_cast<std::int32_t>(r / rows_)};
        row_start_[r] = static_cast<Index>(std::ranges::lower_bound(keys_, key(first)) - keys_.begin());
    });
}

PointGrid::Range PointGrid::sparse_row(std::int32_t x0, std::int32_t x1, std::int32_t y, std::int32_t z) const {
    auto from = keys_.begin(), to = keys_.end();
    if (!row_start_.empty()) {
        const std::size_t r = static_cast<std::size_t>(z - lower_.z) * rows_ + static_cast<std::size_t>(y - lower_.y);
        to = from + row_start_[r + 1];
        from += row_start_[r];
    }
    const auto begin = std::lower_bound(from, to, key({x0, y, z}));
    const auto end = std::upper_bound(begin, to, key({x1, y, z}));
    return {static_cast<Index>(begin - keys_.begin()), static_cast<Index>(end - keys_.begin())};
}

void PointGrid::nearest(const Vec3& x, int k, Real max_radius, std::vector<std::pair<Real, Index>>& found) const {
    found.clear();
    if (k <= 0 || count_ == 0 || !finite(x)) return;
    const Real limit = max_radius * max_radius;
    const Cell c = cell_of(x);
    const auto visit = [&](const Range& range) {
        for (Index slot = range.begin; slot < range.end; ++slot) {
            const Real r2 = square(x_[slot] - x.x()) + square(y_[slot] - x.y()) + square(z_[slot] - x.z());
            const std::pair<Real, Index> entry(r2, index(slot));
            if (!(r2 < limit) || (found.size() == static_cast<std::size_t>(k) && !(entry < found.back()))) continue;
            if (found.size() == static_cast<std::size_t>(k)) found.pop_back();
            found.insert(std::upper_bound(found.begin(), found.end(), entry), entry);
        }
    };
    // Rings that do not touch the occupied box are skipped on both sides.
    const auto outside = [](std::int32_t v, std::int32_t a, std::int32_t b) { return std::max({a - v, v - b, 0}); };
    const auto reach = [](std::int32_t v, std::int32_t a, std::int32_t b) { return std::max(v - a, b - v); };
    const std::int32_t first = std::max(
        {outside(c.x, lower_.x, upper_.x), outside(c.y, lower_.y, upper_.y), outside(c.z, lower_.z, upper_.z)});
    const std::int32_t last =
        std::max({reach(c.x, lower_.x, upper_.x), reach(c.y, lower_.y, upper_.y), reach(c.z, lower_.z, upper_.z)});
    for (std::int32_t ring = first; ring <= last; ++ring) {
        // Points of this ring and later are at least (ring - 1) cells away.
        const Real safe = static_cast<Real>(std::max(ring - 1, 0)) * cell_;
        if (safe >= max_radius) break;
        if (found.size() == static_cast<std::size_t>(k) && found.back().first < safe * safe) break;
        const std::int32_t z0 = std::max(c.z - ring, lower_.z), z1 = std::min(c.z + ring, upper_.z);
        const std::int32_t y0 = std::max(c.y - ring, lower_.y), y1 = std::min(c.y + ring, upper_.y);
        if ((z1 - z0 + 1.0) * (y1 - y0 + 1.0) > static_cast<double>(count_)) {
            // Points are so sparse here that visiting all of them costs less than walking rings.
            found.clear();
            visit({0, static_cast<Index>(count_)});
            break;
        }
        for (std::int32_t z = z0; z <= z1; ++z)
            for (std::int32_t y = y0; y <= y1; ++y) {
                if (std::max(std::abs(z - c.z), std::abs(y - c.y)) == ring) {
                    visit(row(c.x - ring, c.x + ring, y, z));
                } else {
                    visit(row(c.x - ring, c.x - ring, y, z));
                    visit(row(c.x + ring, c.x + ring, y, z));
                }
            }
    }
}

}  // namespace thixo
