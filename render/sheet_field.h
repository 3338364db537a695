// The signed distance to a sheet of surfels anywhere, for trimming (dissertation 5.6.3).
#pragma once

#include <limits>
#include <vector>

#include "pipeline/geometry/surfel.h"

namespace thixo::render {

class SheetField {
  public:
    /// The surfels `members` of the cloud, all of one sheet.
    SheetField(const SurfelCloud& cloud, const std::vector<Index>& members);
    /// About the signed distance from x [m], > 0 before the sheet: the algebraic sphere that the ray's blend fits, where
    /// surfels' supports hold x; the plane of the nearest surfel elsewhere. A sheet without surfels bounds nothing.
    float distance(const Vec3f& x) const;

  private:
    struct Disc {
        Vec3f place, normal;
        Vec3f row1, row2;  // into the support's unit ball, with normal / height
        float height, size;
    };
    struct Sums;
    void gather(std::size_t begin, std::size_t end, const Vec3f& x, Sums& sums) const;
    struct Nearest {
        float distance2 = std::numeric_limits<float>::max();
        const Disc* disc = nullptr;
    };
    void nearest(std::size_t begin, std::size_t end, const Vec3f& x, Vec3f& away, Nearest& best) const;
    void find_plane();
    void sort(std::size_t begin, std::size_t end);

    // A balanced kd-tree in place: the middle of a range parts it along the axis axis_[middle].
    std::vector<Disc> discs_;
    std::vector<unsigned char> axis_;
    float widest_ = 0;   // support [m]
    bool flat_ = false;  // all discs lie in one plane
};

}  // namespace thixo::render
