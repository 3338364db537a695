// Straight ways from one place to many, side by side in lanes.
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include "pipeline/geometry/near_runs.h"

namespace thixo {

/// A triangle, as ways ask for it.
struct WayTriangle {
    WayTriangle(const Vec3& a_, const Vec3& b_, const Vec3& c_) : a(a_), e1(b_ - a_), e2(c_ - a_) {
        const Vec3 across = e1.cross(e2);
        area = across.norm();
        normal = across.normalized();
        size = std::max(e1.norm(), e2.norm());
        doubt = std::max(Real(1), square(size) / std::max(area, std::numeric_limits<Real>::min()));
    }
    Vec3 a, e1, e2;  // corner, edges from there [m]
    Vec3 normal;     // unit
    Real size;       // of the longer edge at a [m]
    Real area;       // |e1 x e2|, twice the triangle's [m^2]
    Real doubt;      // how many times worse than rounding its normal is: slivers have hardly one
};

class WayFan {
  public:
    void start(const Vec3& from) {
        from_ = from;
        count_ = 0;
        longest_ = 0;
        for (auto* a : {&x_, &y_, &z_}) a->clear();
    }
    void add(const Vec3& to) {
        const Vec3 way = to - from_;
        x_.push_back(way.x());
        y_.push_back(way.y());
        z_.push_back(way.z());
        longest_ = std::max(longest_, way.norm());
        ++count_;
    }
    /// To be called once after the last way.
    void finish() {
        for (auto* a : {&x_, &y_, &z_}) a->resize((count_ + kLanes - 1) / kLanes * kLanes, Real(0));
    }
    const Vec3& from() const { return from_; }
    /// The length of the longest way [m].
    Real longest() const { return longest_; }

    /// Calls f(k) for every way that may cross the triangle. None that crosses it is left out; some that pass it by
    /// less than rounding are named as well. The quantities are those of Moeller & Trumbore 1997:
    ///     d.n,  s.n,  d.(e2 x s),  d.(s x e1),     s = from - a,  d the way
    /// The products with s are the same for all ways. Most triangles lie beyond all ways, or these beside them: the
    /// distances from the plane show it first.
    template <class F>
    void for_each_near_crossing(const WayTriangle& triangle, F&& f) const;

  private:
    Vec3 from_{0, 0, 0};
    std::vector<Real> x_, y_, z_;  // of the ways [m]
    std::size_t count_ = 0;
    Real longest_ = 0;
};

template <class F>
void WayFan::for_each_near_crossing(const WayTriangle& t, F&& f) const {
    constexpr Real kRounding = 16 * std::numeric_limits<Real>::epsilon(), kEdge = Real(1e-5);
    const Vec3 s = from_ - t.a;
    const Real above = s.dot(t.normal), off = kRounding * t.doubt * 2 * (longest_ + t.size);
    if (std::abs(above) > longest_ + off) return;
    if (s.squaredNorm() > square((longest_ + t.size) * (1 + kEdge))) return;  // no point of it is farther from a
    // A way that crosses comes from the side of `from`. Where rounding leaves that in doubt, both sides count.
    const bool doubtful = std::abs(above) <= off;
    const Real side = above < 0 ? Real(-1) : Real(1), least = std::abs(above) * (1 - kEdge) - off;
    const Vec3 down = -side * t.normal;
    Vec3 pu(0, 0, 0), pv(0, 0, 0);
    const Real slack = kRounding * t.size * longest_ * (longest_ + 2 * t.size);
    bool prepared = false;
    for (std::size_t k = 0; k < x_.size(); k += kLanes) {
        const Lanes x = load(&x_[k]), y = load(&y_[k]), z = load(&z_[k]);
        const auto dot = [&](const Vec3& v) { return x * v.x() + y * v.y() + z * v.z(); };
        const Lanes through = dot(down);
        const auto reaches = through >= (doubtful ? -longest_ - off : least);
        if (!any_lane(reaches)) continue;
        if (!prepared) {
            pu = t.e2.cross(s);
            pv = s.cross(t.e1);
            prepared = true;
        }
        const Lanes d = (through < 0 ? -through : through) * t.area, over = d * kEdge + slack;
        const auto inside = [&](Real sign) {
            const Lanes u = dot(pu) * sign, v = dot(pv) * sign;
            return (u >= -over) & (v >= -over) & (u + v <= d + over);
        };
        const auto found = doubtful ? (inside(1) | inside(-1)) : inside(side);
        for_each_set_lane(reaches & found, [&](Index l) {
            if (k + l < count_) f(k + l);
        });
    }
}

}  // namespace thixo
