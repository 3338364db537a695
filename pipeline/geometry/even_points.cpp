#include "pipeline/geometry/even_points.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/neighbour_lists.h"
#include "pipeline/geometry/point_grid.h"

namespace thixo {
namespace {

float crowding(Real r2, Real reach) {
    const float a = 1 - static_cast<float>(std::sqrt(r2) / reach), a2 = a * a, a4 = a2 * a2;
    return a > 0 ? a4 * a4 : 0;
}

/// A queue of points by weight: one stack for each thousandth of the greatest weight. Weights only fall. A point whose
/// turn comes is therefore tested again and moved to the stack that it belongs to by then.
class Crowded {
  public:
    explicit Crowded(const std::vector<float>& weight) : next_(weight.size(), kNone), first_(kLevels, kNone) {
        const float most = weight.empty() ? 0 : *std::ranges::max_element(weight);
        levels_a_weight_ = most > 0 ? float(kLevels) / most : 0;
        for (std::size_t i = weight.size(); i-- > 0;) put(static_cast<Index>(i), level(weight[i]));
        top_ = kLevels - 1;
    }
    Index take(const std::vector<float>& weight) {
        for (;;) {
            while (first_[top_] == kNone) --top_;
            const Index i = first_[top_];
            first_[top_] = next_[i];
            const std::size_t now = level(weight[i]);
            if (now >= top_) return i;
            put(i, now);
        }
    }

  private:
    static constexpr std::size_t kLevels = 1024;
    std::size_t level(float weight) const {
        return std::min(static_cast<std::size_t>(std::max(weight * levels_a_weight_, 0.0f)), kLevels - 1);
    }
    void put(Index i, std::size_t level) {
        next_[i] = first_[level];
        first_[level] = i;
    }
    std::vector<Index> next_;   // of the same level
    std::vector<Index> first_;  // of a level
    float levels_a_weight_ = 0;
    std::size_t top_ = 0;
};

}  // namespace

std::vector<Index> even_subset(std::span<const Vec3> positions, std::span<const Vec3> normals, std::size_t count,
                               Real spacing) {
    const std::size_t n = positions.size();
    std::vector<Index> kept;
    if (count >= n) {
        for (Index i = 0; i < n; ++i) kept.push_back(i);
        return kept;
    }
    const Real reach = 2 * spacing / std::sqrt(2 * std::sqrt(Real(3)));
    PointGrid grid;
    grid.build(positions, reach);
    NeighbourLists near;
    near.build(grid, reach);
    const auto for_each_near = [&](std::size_t i, auto&& f) {
        for (const Index j : near[i])
            if (normals[i].dot(normals[j]) > 0) f(j, crowding((positions[i] - positions[j]).squaredNorm(), reach));
    };
    std::vector<float> weight(n, 0);
    parallel_for(n, [&](std::size_t i) { for_each_near(i, [&](Index, float w) { weight[i] += w; }); });
    std::vector<char> alive(n, 1);
    Crowded crowded(weight);
    for (std::size_t left = n; left > count; --left) {
        const Index i = crowded.take(weight);
        alive[i] = 0;
        for_each_near(i, [&](Index j, float part) { weight[j] -= part; });
    }
    for (Index i = 0; i < n; ++i)
        if (alive[i]) kept.push_back(i);
    return kept;
}

void relax(const Face& face, std::vector<Vec3>& positions, std::vector<Vec3>& normals, const std::vector<char>& fixed,
           Real spacing, int sweeps) {
    constexpr int kExact = 2;  // last sweeps, which bring points onto the face and not only near it
    const Real reach = Real(1.8) * spacing;
    const auto settle = [&](bool exactly, const Vec3& normal, Vec3& x, Vec3& n) {
        return (exactly ? project_onto(face, spacing, x, n) : bring_near(face, spacing, spacing / 2, x, n)) &&
               n.dot(normal) >= Real(0.5);
    };
    PointGrid grid;
    // The points may lie near the face, not on it.
    parallel_for(positions.size(), [&](std::size_t i) {
        if (fixed[i] || sweeps == 0) project_onto(face, spacing, positions[i], normals[i]);
    });
    std::vector<Vec3> moved(positions.size()), turned(positions.size());
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        grid.build(positions, reach);
        parallel_for(positions.size(), [&](std::size_t i) {
            moved[i] = positions[i];
            turned[i] = normals[i];
            if (fixed[i]) return;
            Vec3 push = Vec3::Zero();
            grid.for_each_neighbour(positions[i], reach, [&](Index j, Real r2) {
                if (j == i || normals[i].dot(normals[j]) <= 0 || !(r2 > 0)) return;
                const Real r = std::sqrt(r2);
                push += square(1 - r / reach) / r * (positions[i] - positions[j]);
            });
            push -= push.dot(normals[i]) * normals[i];
            push *= Real(0.35) * spacing;
            const Real length = push.norm(), most = Real(0.25) * spacing;
            Vec3 x = positions[i] + (length > most ? most / length : Real(1)) * push, n;
            const bool exactly = sweep >= sweeps - kExact;
            if (!settle(exactly, normals[i], x, n)) {
                x = positions[i];  // the old place, but on the face
                if (!exactly || !settle(true, normals[i], x, n)) return;
            }
            moved[i] = x;
            turned[i] = n;
        });
        positions.swap(moved);
        normals.swap(turned);
    }
    if (face.surface)
        parallel_for(positions.size(), [&](std::size_t i) { turn_outwards(face, spacing, positions[i], normals[i]); });
}

}  // namespace thixo
