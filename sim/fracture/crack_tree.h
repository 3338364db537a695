// Sight through cracks: which triangles of sheets a segment crosses. A hierarchy of boxes.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "sim/fracture/way_fan.h"
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
    /// Calls f(way, triangle) for every way of the fan that crosses a triangle. A way goes to `to(way)`; those that are
    /// not `open(way)` are left out. Returns whether any does.
    template <class To, class Open, class F>
    bool for_each_crossing(const WayFan& fan, To&& to, Open&& open, F&& f) const;
    /// The box about all triangles [m].
    const Vec3& lower() const { return nodes_.front().lower; }
    const Vec3& upper() const { return nodes_.front().upper; }

  private:
    static constexpr std::size_t kLeaf = 4;  // triangles
    struct Face : WayTriangle {
        Vec3 b, c;
        Index row;
    };
    struct Node {
        Vec3 lower, upper;
        Index begin, end;  // faces
        Index right = 0;   // the left child follows its parent; 0: a leaf
    };
    void split(Index begin, Index end);
    /// Calls f(face) for all faces that may come closer to x than `reach` [m], and for some beside them.
    template <class F>
    void for_each_near(const Vec3& x, Real reach, F&& f) const;
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

template <class F>
void CrackTree::for_each_near(const Vec3& x, Real reach, F&& f) const {
    if (nodes_.empty()) return;
    const auto far = [&](const Vec3& lower, const Vec3& upper) {
        return ((lower - x).cwiseMax(x - upper).array() >= reach).any();
    };
    std::array<Index, 64> stack;
    std::size_t depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
        const Index at = stack[--depth];
        const Node& node = nodes_[at];
        if (far(node.lower, node.upper)) continue;
        if (node.right != 0) {
            stack[depth++] = node.right;
            stack[depth++] = at + 1;
            continue;
        }
        for (Index k = node.begin; k < node.end; ++k) f(faces_[k]);
    }
}

template <class To, class Open, class F>
bool CrackTree::for_each_crossing(const WayFan& fan, To&& to, Open&& open, F&& f) const {
    constexpr Real kRounding = Real(1e-4);
    bool any = false;
    for_each_near(fan.from(), (1 + kRounding) * fan.longest(), [&](const Face& face) {
        fan.for_each_near_crossing(face, [&](std::size_t k) {
            if (!open(k) || !crossing(face, fan.from(), to(k))) return;
            any = true;
            f(k, face.row);
        });
    });
    return any;
}

}  // namespace thixo
