#include "pipeline/geometry/sampled_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/bounds.h"
#include "pipeline/geometry/shape_checks.h"

namespace thixo {
namespace {

constexpr int kBlock = 8;           // cells along the edge of a block
constexpr int kNodes = kBlock + 1;  // samples along it: blocks share none, so that a query reads one block
constexpr double kMaxSamples = double(1u << 28);

using Index3 = Eigen::Array3i;

/// Trilinear interpolation at the fractions u of a cell. Its corner samples start at `at`, with the strides of y and z.
Real trilinear(const Real* at, int dy, int dz, const Vec3& u) {
    const auto along_x = [&](const Real* p) { return p[0] + u.x() * (p[1] - p[0]); };
    const auto along_y = [&](const Real* p) {
        const Real a = along_x(p), b = along_x(p + dy);
        return a + u.y() * (b - a);
    };
    const Real a = along_y(at), b = along_y(at + dz);
    return a + u.z() * (b - a);
}

/// The place of a block's sample i on a path from neighbour to neighbour. Every other row and layer runs backwards.
int snake(int i) {
    int x = i % kNodes, y = i / kNodes % kNodes;
    const int z = i / kNodes / kNodes;
    if (z % 2 == 1) y = kNodes - 1 - y;
    if ((y + z * kNodes) % 2 == 1) x = kNodes - 1 - x;
    return x + kNodes * (y + kNodes * z);
}

class Sampled final : public Shape::Node {
  public:
    Sampled(Shape shape, double cell, double band, const Box3& box)
        : shape_(std::move(shape)),
          bounds_(shape_.bounds()),
          origin_(box.lower),
          cell_(Real(cell)),
          inverse_cell_(Real(1 / cell)) {
        const Eigen::Array3d extent = (box.upper - box.lower).cast<double>().array();
        const Eigen::Array3d blocks = (extent / (cell * kBlock)).ceil().max(1);
        if (blocks.prod() > kMaxSamples)
            throw InputError(
                "sampling cell {} m needs more than {} blocks for a box of {} x {} x {} m; use a larger cell", cell,
                kMaxSamples, extent.x(), extent.y(), extent.z());
        blocks_ = blocks.cast<int>();
        upper_ = origin_ + Vec3((blocks_.cast<Real>() * (cell_ * kBlock)).matrix());
        sample_corners();
        find_near_blocks(band);
        sample_near_blocks();
    }

    Real distance(const Vec3& x) const override {
        const Vec3 inside = x.cwiseMax(origin_).cwiseMin(upper_);
        const Real d = interpolate(inside) + (x - inside).norm();
        const Real outside = bounds_ ? distance_to(*bounds_, x) : 0;
        return outside > 0 ? std::max(d, outside) : d;
    }
    std::optional<Box3> bounds() const override { return bounds_; }
    std::optional<TriangleMesh> exact_mesh(int segments) const override { return shape_.node().exact_mesh(segments); }
    std::shared_ptr<const FaceTree> faces(Real by) const override { return shape_.node().faces(by); }
    std::optional<Vec3f> colour(const Vec3& x) const override { return shape_.node().colour(x); }
    std::shared_ptr<const DirectSurface> direct_surface() const override { return shape_.node().direct_surface(); }
    std::shared_ptr<const PointSurfels> own_surfels() const override { return shape_.node().own_surfels(); }

  private:
    std::size_t block_count() const { return std::size_t(blocks_.x()) * blocks_.y() * blocks_.z(); }
    Vec3 block_lower(std::size_t b) const {
        const std::size_t nx = blocks_.x(), ny = blocks_.y();
        return origin_ + (cell_ * kBlock) * Vec3(Real(b % nx), Real(b / nx % ny), Real(b / nx / ny));
    }

    void sample_corners() {
        const std::size_t nx = blocks_.x() + 1, ny = blocks_.y() + 1, nz = blocks_.z() + 1;
        corners_.resize(nx * ny * nz);
        parallel_for(corners_.size(), [&](std::size_t k) {
            corners_[k] =
                shape_.distance(origin_ + (cell_ * kBlock) * Vec3(Real(k % nx), Real(k / nx % ny), Real(k / nx / ny)));
        });
    }

    /// A block is sampled finely where |distance| at its centre, a lower bound, is below the band plus half its
    /// diagonal.
    void find_near_blocks(double band) {
        const Real half = cell_ * kBlock / 2, reach = Real(band) + Real(1.0001 * std::sqrt(3.0)) * half;
        std::vector<char> near(block_count());
        parallel_for(near.size(), [&](std::size_t b) {
            near[b] = std::abs(shape_.distance(block_lower(b) + Vec3::Constant(half))) <= reach;
        });
        first_.assign(near.size(), kNone);
        for (std::size_t b = 0; b < near.size(); ++b)
            if (near[b]) {
                first_[b] = static_cast<Index>(near_.size());
                near_.push_back(static_cast<Index>(b));
            }
        if (double(near_.size()) * cube(kNodes) > kMaxSamples)
            throw InputError("sampling cell {} m needs {} samples; use a larger cell", cell_,
                             near_.size() * cube(kNodes));
    }

    void sample_near_blocks() {
        samples_.resize(near_.size() * cube(kNodes));
        parallel_for(
            near_.size(),
            [&](std::size_t k) {
                const Vec3 lower = block_lower(near_[k]);
                Vec3 x[cube(kNodes)];
                for (int i = 0; i < cube(kNodes); ++i)
                    x[snake(i)] =
                        lower + cell_ * Vec3(Real(i % kNodes), Real(i / kNodes % kNodes), Real(i / kNodes / kNodes));
                Real d[cube(kNodes)];
                shape_.node().distances(x, d, cube(kNodes));
                for (int i = 0; i < cube(kNodes); ++i) samples_[k * cube(kNodes) + i] = d[snake(i)];
            },
            1);
    }

    Real interpolate(const Vec3& x) const {
        const Vec3 g = (x - origin_) * inverse_cell_;
        const Index3 block = (g.array() / kBlock).cast<int>().max(0).min(blocks_ - 1);
        const std::size_t b = block.x() + std::size_t(blocks_.x()) * (block.y() + std::size_t(blocks_.y()) * block.z());
        const Vec3 local = g - Vec3((block * kBlock).cast<Real>().matrix());
        if (first_[b] == kNone) {
            const int dy = blocks_.x() + 1;
            const std::size_t dz = std::size_t(dy) * (blocks_.y() + 1);
            return trilinear(&corners_[block.x() + dy * std::size_t(block.y()) + dz * block.z()], dy,
                             static_cast<int>(dz), local / kBlock);
        }
        const Index3 cell = local.array().cast<int>().max(0).min(kBlock - 1);
        const std::size_t at =
            std::size_t(first_[b]) * cube(kNodes) + cell.x() + kNodes * (cell.y() + kNodes * cell.z());
        return trilinear(&samples_[at], kNodes, kNodes * kNodes, local - Vec3(cell.cast<Real>().matrix()));
    }

    Shape shape_;
    std::optional<Box3> bounds_;
    Vec3 origin_, upper_;
    Real cell_, inverse_cell_;
    Index3 blocks_;
    std::vector<Real> corners_;  // at the corners of blocks
    std::vector<Index> first_;   // block -> place among the finely sampled ones, kNone where it is far from the surface
    std::vector<Index> near_;    // its inverse
    std::vector<Real> samples_;  // kNodes^3 a near block
};

}  // namespace

Shape sampled(const Shape& shape, double cell, double band, std::optional<Box3> box) {
    positive_size(cell, "sampling cell");
    size_not_negative(band, "sampling band");
    if (!box) {
        box = shape.bounds();
        if (!box) throw InputError("an unbounded shape can be sampled in a box only; give one");
        box = grown(*box, Real(band));
    }
    return Shape(std::make_shared<Sampled>(shape, cell, band, *box));
}

}  // namespace thixo
