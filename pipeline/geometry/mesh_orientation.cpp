#include "pipeline/geometry/mesh_orientation.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/base/math.h"
#include "pipeline/geometry/mesh_repair.h"
#include "pipeline/geometry/solid_angle.h"

namespace thixo {
namespace {

/// One side of a triangle, between two places.
struct Side {
    Index low, high, triangle;
    bool forward;  // from low to high
    bool operator<(const Side& other) const {
        return low != other.low ? low < other.low : high != other.high ? high < other.high : triangle < other.triangle;
    }
};

/// A triangle beyond a side that exactly two triangles share.
struct Neighbour {
    Index triangle = kNone;
    bool opposed = false;  // wound the other way round
};

struct Shell {
    Index first = 0, count = 0;  // its triangles, in Shells::order
    Vec3d lower{0, 0, 0}, upper{0, 0, 0};
    double volume = 0;  // [m^3], signed, about the mesh's middle
    bool closed = true;
    bool turned = false;
};

double signed_volume(const std::array<Vec3d, 3>& t) { return t[0].dot(t[1].cross(t[2])) / 6; }

class Shells {
  public:
    explicit Shells(const TriangleMesh& mesh) : mesh_(mesh), turned_(mesh.triangles.size(), 0) {
        middle_ = inspect_middle();
        connect();
        gather();
        for (Shell& shell : shells_) measure(shell);
        turn_closed();
        turn_open();
    }
    /// Of every triangle whether it has to be turned round.
    std::vector<char> turned() const {
        std::vector<char> all = turned_;
        for (const Shell& shell : shells_)
            for (Index k = shell.first; k < shell.first + shell.count; ++k) all[order_[k]] ^= shell.turned;
        return all;
    }

  private:
    Vec3d inspect_middle() const {
        Vec3f lower = mesh_.vertices[0], upper = lower;
        for (const Vec3f& v : mesh_.vertices) lower = lower.cwiseMin(v), upper = upper.cwiseMax(v);
        return (lower.cast<double>() + upper.cast<double>()) / 2;
    }
    std::array<Vec3d, 3> corners(Index k) const {
        const auto& t = mesh_.triangles[k];
        const auto at = [&](Index v) { return Vec3d(mesh_.vertices[v].cast<double>() - middle_); };
        if (turned_[k]) return {at(t[0]), at(t[2]), at(t[1])};
        return {at(t[0]), at(t[1]), at(t[2])};
    }

    void connect() {
        Index places;
        const std::vector<Index> number = position_numbers(mesh_.vertices, places);
        std::vector<Side> sides;
        sides.reserve(3 * mesh_.triangles.size());
        neighbours_.resize(mesh_.triangles.size());
        open_.assign(mesh_.triangles.size(), 0);
        for (Index k = 0; k < mesh_.triangles.size(); ++k) {
            const auto& t = mesh_.triangles[k];
            const std::array<Index, 3> v{number[t[0]], number[t[1]], number[t[2]]};
            if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) continue;
            for (std::size_t i = 0; i < 3; ++i) {
                const Index a = v[i], b = v[(i + 1) % 3];
                sides.push_back({std::min(a, b), std::max(a, b), k, a < b});
            }
        }
        std::sort(sides.begin(), sides.end());
        for (std::size_t begin = 0, end; begin < sides.size(); begin = end) {
            const auto same = [&](std::size_t i) {
                return sides[i].low == sides[begin].low && sides[i].high == sides[begin].high;
            };
            for (end = begin; end < sides.size() && same(end);) ++end;
            if (end - begin == 2) join(sides[begin], sides[begin + 1]);
            if ((end - begin) % 2 == 1)
                for (std::size_t i = begin; i < end; ++i) open_[sides[i].triangle] = 1;
        }
    }
    void join(const Side& a, const Side& b) {
        const bool opposed = a.forward == b.forward;
        const auto add = [&](Index from, Index to) {
            for (Neighbour& n : neighbours_[from])
                if (n.triangle == kNone) {
                    n = {to, opposed};
                    return;
                }
        };
        add(a.triangle, b.triangle);
        add(b.triangle, a.triangle);
    }

    /// Walks over every shell from its first triangle, and turns what opposes the way there.
    void gather() {
        std::vector<char> seen(mesh_.triangles.size(), 0);
        order_.reserve(mesh_.triangles.size());
        for (Index seed = 0; seed < mesh_.triangles.size(); ++seed) {
            if (seen[seed]) continue;
            Shell shell;
            shell.first = static_cast<Index>(order_.size());
            seen[seed] = 1;
            order_.push_back(seed);
            for (std::size_t at = shell.first; at < order_.size(); ++at)
                for (const Neighbour& n : neighbours_[order_[at]]) {
                    if (n.triangle == kNone || seen[n.triangle]) continue;
                    seen[n.triangle] = 1;
                    turned_[n.triangle] = turned_[order_[at]] ^ static_cast<char>(n.opposed);
                    order_.push_back(n.triangle);
                }
            shell.count = static_cast<Index>(order_.size()) - shell.first;
            shells_.push_back(shell);
        }
    }

    /// Box, volume and openness; the larger part of the area keeps the winding that it was given.
    void measure(Shell& shell) {
        double kept = 0, turned = 0;
        for (Index i = shell.first; i < shell.first + shell.count; ++i) {
            const auto c = corners(order_[i]);
            (turned_[order_[i]] ? turned : kept) += (c[1] - c[0]).cross(c[2] - c[0]).norm();
            if (i == shell.first) shell.lower = shell.upper = c[0];
            for (const Vec3d& x : c) shell.lower = shell.lower.cwiseMin(x), shell.upper = shell.upper.cwiseMax(x);
            shell.volume += signed_volume(c);
            shell.closed = shell.closed && !open_[order_[i]];
        }
        if (turned <= kept) return;
        shell.volume = -shell.volume;
        for (Index i = shell.first; i < shell.first + shell.count; ++i) turned_[order_[i]] ^= 1;
    }

    /// Whether most of some of a shell's triangles are within another one, by its winding number.
    bool holds(const Shell& outer, const Shell& inner) const {
        if ((outer.lower.array() > inner.lower.array()).any() || (outer.upper.array() < inner.upper.array()).any())
            return false;
        constexpr Index kAsked = 8;
        double sum = 0;
        const Index asked = std::min(inner.count, kAsked);
        for (Index k = 0; k < asked; ++k) {
            const auto c = corners(order_[inner.first + k * (inner.count / asked)]);
            const Vec3d at = (c[0] + c[1] + c[2]) / 3;
            double angle = 0;
            for (Index i = outer.first; i < outer.first + outer.count; ++i) {
                auto t = corners(order_[i]);
                for (Vec3d& x : t) x -= at;
                angle += half_solid_angle(t[0], t[1], t[2]);
            }
            sum += std::abs(angle / (2 * kPi));
        }
        return sum > 0.5 * asked;
    }

    /// From the largest to the smallest, so that what holds another one comes before it.
    void turn_closed() {
        std::vector<Shell*> closed, outermost;
        for (Shell& shell : shells_)
            if (shell.closed && shell.volume != 0) closed.push_back(&shell);
        std::stable_sort(closed.begin(), closed.end(),
                         [](const Shell* a, const Shell* b) { return std::abs(a->volume) > std::abs(b->volume); });
        for (Shell* shell : closed) {
            const auto outer =
                std::find_if(outermost.begin(), outermost.end(), [&](const Shell* o) { return holds(*o, *shell); });
            if (outer != outermost.end()) {
                shell->turned = (*outer)->turned;
                continue;
            }
            shell->turned = shell->volume < 0;
            outermost.push_back(shell);
        }
    }

    void turn_open() {
        double volume = 0;
        for (const Shell& shell : shells_)
            if (!shell.closed) volume += shell.volume;
        for (Shell& shell : shells_)
            if (!shell.closed) shell.turned = volume < 0;
    }

    const TriangleMesh& mesh_;
    Vec3d middle_{0, 0, 0};
    std::vector<std::array<Neighbour, 3>> neighbours_;
    std::vector<char> open_;    // triangles with a side that has no other triangle beyond it
    std::vector<char> turned_;  // against the file, shells not counted
    std::vector<Index> order_;  // triangles, shell by shell
    std::vector<Shell> shells_;
};

/// Normals of vertices of turned triangles that point against what is around them now.
void follow_with_normals(TriangleMesh& mesh, const std::vector<char>& turned) {
    if (mesh.normals.size() != mesh.vertices.size()) return;
    std::vector<char> touched(mesh.vertices.size(), 0);
    std::vector<Vec3d> around(mesh.vertices.size(), Vec3d::Zero());
    for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
        const auto& [a, b, c] = mesh.triangles[k];
        const Vec3d p = mesh.vertices[a].cast<double>();
        const Vec3d n = (mesh.vertices[b].cast<double>() - p).cross(mesh.vertices[c].cast<double>() - p);
        for (const Index v : mesh.triangles[k]) {
            around[v] += n;
            touched[v] |= turned[k];
        }
    }
    for (std::size_t v = 0; v < touched.size(); ++v)
        if (touched[v] && mesh.normals[v].cast<double>().dot(around[v]) < 0) mesh.normals[v] = -mesh.normals[v];
}

}  // namespace

std::size_t orient_outward(TriangleMesh& mesh) {
    if (mesh.triangles.empty()) return 0;
    const std::vector<char> turned = Shells(mesh).turned();
    std::size_t count = 0;
    for (std::size_t k = 0; k < turned.size(); ++k)
        if (turned[k]) {
            turn_triangle(mesh, k);
            ++count;
        }
    if (count > 0) follow_with_normals(mesh, turned);
    return count;
}

}  // namespace thixo
