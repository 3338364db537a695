#include "pipeline/geometry/local_shape.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/bounds.h"
#include "pipeline/geometry/shape_checks.h"
#include "pipeline/geometry/sloped_shape.h"

namespace thixo {
namespace {

constexpr int kMostBlocks = 64;           // along an axis
const Real kHalfDiagonal = Real(0.8661);  // of a cube of edge 1, rounded up

/// A cube of `blocks` (a power of two) blocks along an edge, and the shape that is evaluated in it.
struct Cube {
    Eigen::Array3i at;  // its first block
    int blocks;
    std::optional<SlopedShape> part;
};

class Blocks final : public Shape::Node, public SlopedNode {
  public:
    Blocks(Shape shape, const Box3& box, Real edge, int along)
        : shape_(std::move(shape)), origin_(box.lower), edge_(edge) {
        count_ = ((box.upper - box.lower) / edge).array().ceil().cast<int>().max(1).min(along);
        part_.resize(std::size_t(count_.x()) * count_.y() * count_.z());
        std::vector<Cube> cubes{{Eigen::Array3i::Zero(), along, std::nullopt}};
        while (!cubes.empty()) cubes = refine(cubes);
    }
    bool empty() const {
        return std::ranges::none_of(part_, [](const auto& part) { return part.has_value(); });
    }

    Real distance(const Vec3& x) const override { return part_at(x).distance(x); }
    Real sloped(const Vec3& x, Real step, Vec3& slope) const override { return part_at(x).sloped(x, step, slope); }
    std::optional<Box3> bounds() const override { return shape_.bounds(); }
    std::optional<TriangleMesh> exact_mesh(int segments) const override { return shape_.node().exact_mesh(segments); }
    std::shared_ptr<const FaceTree> faces(Real by) const override { return shape_.node().faces(by); }
    std::optional<Vec3f> colour(const Vec3& x) const override { return shape_.node().colour(x); }
    std::shared_ptr<const DirectSurface> direct_surface() const override { return shape_.node().direct_surface(); }
    std::shared_ptr<const PointSurfels> own_surfels() const override { return shape_.node().own_surfels(); }

  private:
    std::size_t index(const Eigen::Array3i& b) const {
        return b.x() + std::size_t(count_.x()) * (b.y() + std::size_t(count_.y()) * b.z());
    }

    const SlopedShape& part_at(const Vec3& x) const {
        const Eigen::Array<Real, 3, 1> place = (x - origin_).array() / edge_;
        if (!((place >= 0).all() && (place < count_.cast<Real>()).all())) return shape_;
        const std::optional<SlopedShape>& part = part_[index(place.cast<int>())];
        return part ? *part : shape_;
    }

    /// Drops the parts that do not matter in each cube. Returns the cubes near the surface that can be divided further,
    /// as eight each.
    std::vector<Cube> refine(std::vector<Cube>& cubes) {
        std::vector<char> near(cubes.size());
        parallel_for(
            cubes.size(),
            [&](std::size_t k) {
                Cube& c = cubes[k];
                const Real size = edge_ * Real(c.blocks);
                const Ball3 ball{origin_ + edge_ * c.at.cast<Real>().matrix() + Vec3::Constant(size / 2),
                                 Real(1.001) * kHalfDiagonal * size};
                if (auto part = parts_within(c.part ? *c.part : shape_, ball)) c.part = SlopedShape(*std::move(part));
                const Real d = (c.part ? *c.part : shape_).distance(ball.centre);
                near[k] = c.blocks > 1 && std::abs(d) <= ball.radius;
            },
            1);
        std::vector<Cube> parts;
        for (std::size_t k = 0; k < cubes.size(); ++k) {
            const Cube& c = cubes[k];
            if (!near[k]) {
                fill(c);
                continue;
            }
            for (int corner = 0; corner < 8; ++corner) {
                const int half = c.blocks / 2;
                const Eigen::Array3i at = c.at + half * Eigen::Array3i(corner & 1, corner >> 1 & 1, corner >> 2);
                if ((at < count_).all()) parts.push_back({at, half, c.part});
            }
        }
        return parts;
    }

    void fill(const Cube& c) {
        const Eigen::Array3i end = (c.at + c.blocks).min(count_);
        for (int z = c.at.z(); z < end.z(); ++z)
            for (int y = c.at.y(); y < end.y(); ++y)
                for (int x = c.at.x(); x < end.x(); ++x) part_[index({x, y, z})] = c.part;
    }

    SlopedShape shape_;
    Vec3 origin_;
    Real edge_;
    Eigen::Array3i count_;
    std::vector<std::optional<SlopedShape>> part_;  // of each block; empty: the whole shape
};

}  // namespace

std::optional<Shape> parts_within(const Shape& shape, const Ball3& ball) {
    const auto* parted = dynamic_cast<const PartedNode*>(&shape.node());
    return parted ? parted->within(ball) : std::nullopt;
}

Shape by_blocks(const Shape& shape, double block) {
    positive_size(block, "block");
    const auto bounds = shape.bounds();
    if (!bounds || !dynamic_cast<const PartedNode*>(&shape.node())) return shape;
    // Places just outside are evaluated as often as places just inside.
    const Box3 box = grown(*bounds, Real(block));
    const Real extent = (box.upper - box.lower).maxCoeff();
    int along = 1;
    while (along < kMostBlocks && Real(along) * Real(block) < extent) along *= 2;
    auto blocks = std::make_shared<Blocks>(shape, box, extent / Real(along), along);
    return blocks->empty() ? shape : Shape(std::move(blocks));
}

}  // namespace thixo
