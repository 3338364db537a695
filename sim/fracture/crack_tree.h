// Sight through cracks: which triangles of sheets a segment crosses. A hierarchy of boxes.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "sim/state/cracks.h"

namespace thixo {

/// A part of the triangles of cracks. Immutable once built.
class CrackTree {
  public:
    CrackTree() = default;
    /// Over these triangles, by row.
    CrackTree(const Cracks& cracks, std::span<const Index> triangles);

    bool empty() const { return faces_.empty(); }
    /// Calls f(triangle, place) for every triangle that the segment from `a` to `b` crosses or touches. The place is on
    /// it [m].
    template <class F>
    void for_each_crossing(const Vec3& a, const Vec3& b, F&& f) const {
        (void)any_crossing(a, b, [&](Index row, const Vec3& place) {
            f(row, place);
            return false;
        });
    }
    /// Calls f likewise, until it returns true. Returns whether it did.
    template <class F>
    bool any_crossing(const Vec3& a, const Vec3& b, F&& f) const;
    /// The nearest triangle that `accepted(row)` takes, closer than `reach` [m].
    struct Near {
        Index triangle;
        Vec3 place;
        Real distance;
    };
    std::optional<Near> nearest(const Vec3& x, Real reach, const std::function<bool(Index)>& accepted) const;
    /// The triangles that may come closer to x than `reach` [m], for many short segments about one place. None where
    /// there are more than `most`: the whole hierarchy is faster then.
    std::optional<CrackTree> about(const Vec3& x, Real reach, std::size_t most) const;
    /// The box about all triangles [m].
    const Vec3& lower() const { return nodes_.front().lower; }
    const Vec3& upper() const { return nodes_.front().upper; }

  private:
    static constexpr std::size_t kLeaf = 4;  // triangles
    struct Face {
        Vec3 a, b, c;
        Vec3 normal;  // unit
        Real size;    // of its longer edge at a [m]
        Index row;
    };
    struct Node {
        Vec3 lower, upper;
        Index begin, end;  // faces
        Index right = 0;   // the left child follows its parent; 0: a leaf
    };
    void split(Index begin, Index end);
    static std::optional<Vec3> crossing(const Face& face, const Vec3& a, const Vec3& b);
    struct Segment {
        Vec3 from, way, inverse;  // of the way's components; any number where one is 0
    };
    static bool meets(const Node& node, const Segment& segment);

    std::vector<Face> faces_;
    std::vector<Node> nodes_;
};

template <class F>
bool CrackTree::any_crossing(const Vec3& a, const Vec3& b, F&& f) const {
    if (nodes_.empty()) return false;
    const Vec3 way = b - a;
    const Segment segment{a, way, way.cwiseInverse()};
    std::array<Index, 64> stack;  // a median tree of 2^32 faces is no deeper
    std::size_t depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
        const Index at = stack[--depth];
        const Node& node = nodes_[at];
        if (!meets(node, segment)) continue;
        if (node.right != 0) {
            stack[depth++] = node.right;
            stack[depth++] = at + 1;
            continue;
        }
        for (Index k = node.begin; k < node.end; ++k)
            if (const auto place = crossing(faces_[k], a, b); place && f(faces_[k].row, *place)) return true;
    }
    return false;
}

}  // namespace thixo
