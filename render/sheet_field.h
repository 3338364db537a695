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
    /// About the signed distance from x [m], > 0 before the sheet. Where surfels' supports hold x it is that of the
    /// algebraic sphere that the ray's blend fits. Elsewhere it is that of a plane with x on the side on which the
    /// nearest surfel has it. A sheet without surfels bounds nothing.
    float distance(const Vec3f& x) const;
    /// Whether the middle of a surfel is nearer to x than `reach`.
    bool within(const Vec3f& x, float reach) const;

  private:
    static constexpr std::size_t kBundle = 8;
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
        bool disputed = false;
    };
    /// Where the discs of a part of the tree are and look.
    struct Bundle {
        Vec3f centre, half;  // of the box of their places
        Vec3f normal;        // axis of the cone of their normals
        float cosine, sine;  // of its half angle; no cone where it is 90 degrees or more
        float margin;        // a thousand times less than their size [m]
        /// 1 where x is before the planes of all, -1 where it is behind all, else 0.
        int side(const Vec3f& x) const;
    };
    template <bool by_bundles>
    void nearest(std::size_t begin, std::size_t end, std::size_t node, const Vec3f& x, Vec3f& away,
                 Nearest& best) const;
    float far_distance(const Vec3f& x) const;
    void find_plane();
    void sort(std::size_t begin, std::size_t end, std::size_t node);
    Bundle bundle(std::size_t begin, std::size_t end) const;

    // A balanced kd-tree in place: the middle of a range parts it along the axis axis_[middle].
    std::vector<Disc> discs_;
    std::vector<unsigned char> axis_;
    std::vector<Bundle> bundles_;  // of ranges of kBundle discs and more; the parts of node k are 2 k + 1 and 2 k + 2
    float widest_ = 0;             // support [m]
    Vec3f lower_ = Vec3f::Zero(), upper_ = Vec3f::Zero();  // box of the discs' places
    bool flat_ = false;                                    // all discs lie in one plane
};

}  // namespace thixo::render
