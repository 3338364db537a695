#include "pipeline/geometry/revolve_faces.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/base/error.h"

namespace thixo {
namespace {

double cross(const Vec2d& a, const Vec2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// The region to the left of a chain of edges in the half plane (r, z), rotated about z. The first and the last edge
/// are extended without end, unless they end on the axis.
struct ChainFace final : Shape::Node {
    ChainFace(const std::vector<Vec2d>& corners, Real by_) : by(by_) {
        for (std::size_t k = 0; k + 1 < corners.size(); ++k) {
            const Vec2d along = corners[k + 1] - corners[k];
            const bool first = k == 0 && corners.front().x() > 0,
                       last = k + 2 == corners.size() && corners.back().x() > 0;
            const Real endless = std::numeric_limits<Real>::max();
            edges.push_back({corners[k].cast<Real>(), along.normalized().cast<Real>(), first ? -endless : Real(0),
                             last ? endless : Real(along.norm())});
        }
    }
    Real distance(const Vec3& x) const override {
        const Vec2 p(std::sqrt(x.x() * x.x() + x.y() * x.y()), x.z());
        Real nearest2 = std::numeric_limits<Real>::max(), side = 0;
        for (const Edge& e : edges) {
            const Vec2 q = p - e.from, normal(e.along.y(), -e.along.x());
            const Vec2 away = q - std::clamp(q.dot(e.along), e.begin, e.end) * e.along;
            const Real d2 = away.squaredNorm();
            // At a corner both edges are equally near. The sum of their normals gives the side.
            if (d2 <= nearest2 * Real(1.00001) && d2 >= nearest2 * Real(0.99999))
                side += normal.dot(away);
            else if (d2 < nearest2)
                side = normal.dot(away);
            nearest2 = std::min(nearest2, d2);
        }
        return (side < 0 ? -std::sqrt(nearest2) : std::sqrt(nearest2)) - by;
    }
    std::optional<Box3> bounds() const override { return std::nullopt; }

    struct Edge {
        Vec2 from, along;  // unit
        Real begin, end;   // along the edge
    };
    std::vector<Edge> edges;
    Real by;
};

class Decomposition {
  public:
    Decomposition(const std::vector<Vec2d>& profile, Real by) : corners_(profile), by_(by) {}

    std::shared_ptr<const FaceTree> tree() const {
        const int n = size();
        std::vector<int> cuts, hull;  // of the closed polygon
        for (int k = 0; k < n; ++k) {
            if (!on_hull(k, k + n, k)) continue;
            hull.push_back(k);
            if (sharp(k)) cuts.push_back(k);
        }
        if (!has_cut(-1, n)) return nullptr;
        for (const int k : {hull.front(), hull[hull.size() / 2]})
            if (cuts.size() < 2 && std::find(cuts.begin(), cuts.end(), k) == cuts.end()) cuts.push_back(k);
        std::sort(cuts.begin(), cuts.end());
        const int a = cuts[0], b = cuts[cuts.size() / 2];
        std::vector<FaceTree> parts;
        for (auto& part : {chain(a, b), chain(b, a + n)})
            if (part) parts.push_back(*part);
        FaceTree result = FaceTree::of(FaceTree::Op::all, std::move(parts));
        return result.op == FaceTree::Op::face ? nullptr : std::make_shared<FaceTree>(std::move(result));
    }

  private:
    int size() const { return static_cast<int>(corners_.size()); }
    const Vec2d& corner(int k) const { return corners_[static_cast<std::size_t>((k + size()) % size())]; }
    bool on_axis(int edge) const { return corner(edge).x() == 0 && corner(edge + 1).x() == 0; }
    /// The turn of the outline at a corner; > 0 where it is convex.
    double turn(int k) const {
        const Vec2d a = corner(k) - corner(k - 1), b = corner(k + 1) - corner(k);
        return std::atan2(cross(a, b), a.dot(b));
    }
    bool sharp(int k) const {
        if (on_axis(k) || on_axis(k - 1)) return true;
        const double t = turn(k);
        return std::abs(t) > kSharpTurn * kPi / 180 && !(t > 0 && by_ > 0) && !(t < 0 && by_ < 0);
    }
    bool has_cut(int a, int b) const {
        for (int k = a + 1; k < b; ++k)
            if (sharp(k)) return true;
        return false;
    }
    /// Whether corner k, a < k < b, belongs to the convex hull of the chain of corners a to b. The first and last edge
    /// of the chain are extended without end; b = a + size means the whole polygon. At such a corner the chain lies in
    /// one half plane through k.
    bool on_hull(int a, int b, int k) const {
        std::vector<double> angles;
        const auto see = [&](const Vec2d& d) {
            if (d.norm() > 0) angles.push_back(std::atan2(d.y(), d.x()));
        };
        const bool closed = b == a + size();
        for (int i = closed ? a : a + 1; i < b; ++i)
            if ((i - k) % size() != 0) see(corner(i) - corner(k));
        if (!closed) {
            see(corner(a) - corner(a + 1));
            see(corner(b) - corner(b - 1));
        }
        std::sort(angles.begin(), angles.end());
        double gap = angles.front() + 2 * kPi - angles.back();
        for (std::size_t i = 1; i < angles.size(); ++i) gap = std::max(gap, angles[i] - angles[i - 1]);
        return gap > kPi * (1 - 1e-9);
    }
    /// The region to the left of the chain from corner a to corner b; empty: everything (an edge on the axis).
    std::optional<FaceTree> chain(int a, int b) const {
        if (b == a + 1 && on_axis(a)) return std::nullopt;
        if (!has_cut(a, b)) {
            std::vector<Vec2d> points;
            for (int k = a; k <= b; ++k) points.push_back(corner(k));
            return FaceTree::leaf(Shape(std::make_shared<ChainFace>(points, by_)));
        }
        int at = -1;
        for (int k = a + 1; k < b; ++k)
            if (on_hull(a, b, k) && (at < 0 || (sharp(k) && !sharp(at)))) at = k;
        if (at < 0) throw InputError("revolve profile cannot be cut into faces at its corners; remove doubled edges");
        const auto first = chain(a, at), second = chain(at, b);
        const bool convex = turn(at) > 0;
        if (!first || !second) {
            if (convex) return first ? first : second;
            return std::nullopt;  // the union of everything and a part is everything
        }
        return FaceTree::of(convex ? FaceTree::Op::all : FaceTree::Op::any, {*first, *second});
    }

    std::vector<Vec2d> corners_;
    Real by_;
};

}  // namespace

std::shared_ptr<const FaceTree> revolve_faces(const std::vector<Vec2d>& profile, Real by) {
    return Decomposition(profile, by).tree();
}

}  // namespace thixo
