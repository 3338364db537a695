// The walls' part of the SPH sums of a particle. It consists of integrals of the kernels over the wall's volume,
// tabulated in the wall's own frame. (Density maps: Koschier & Bender 2017; volume maps: Bender et al. 2019.)
#pragma once

#include <oneapi/tbb/concurrent_unordered_map.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "pipeline/base/random.h"
#include "pipeline/geometry/shape.h"
#include "sim/space/wall_kernel.h"

namespace thixo {

/// Integrals over the wall's volume at a place x.
struct WallIntegrals {
    Real distance = 0;       // signed, > 0 outside of the wall [m]
    Real share = 0;          // integral of w_poly6(x - y) dy [1]: the wall's share of the relative density
    Vec3 gradient{0, 0, 0};  // integral of grad_x w_spiky(x - y) dy [1/m]
    Real laplacian = 0;      // integral of lap w_visc(x - y) dy [1/m^2]
};

/// The integrals of a half-space whose surface is at `distance` (in closed form), normal (0, 0, 1) towards x.
WallIntegrals half_space_integrals(Real distance, Real support);

/// Tables of one solid. Blocks are made where they are first asked for: memory and time go where matter comes, and
/// unbounded walls need no box. Every value is a pure function of the place, whichever thread asks first. Where the
/// solid is a half-space as far as the kernel reaches, a block stores its plane, and values are those of the
/// closed form. Where it is nearly one, the closed form is tabulated at h/4. Elsewhere the solid is sampled at h/8 and
/// summed at h/4, trilinear in between.
class WallMap {
  public:
    WallMap(Shape solid, Real support);
    /// The wall of the implicit solver. The share is that of `kernel` at the distance from the planes that the wall
    /// consists of near x. The planes come from the shape's own distances; concave edges are rounded to half a support.
    /// The gradient is exactly that of the share, so that a wall returns the energy that it takes. Interpolation would
    /// not do that. The first plane touches the nearest point of the wall. Where another wall is nearer a support
    /// farther on, the edge is concave, and that wall gives the second plane. The third is found in the same way.
    WallMap(Shape solid, const WallKernel& kernel);
    WallMap(WallMap&&) = default;

  private:
    struct Block;
    struct Page;

  public:
    /// The page of blocks last used, and a ball without walls: a place in it needs no look-up.
    struct Cursor {
        std::uint64_t key = ~std::uint64_t(0);
        Page* page = nullptr;
        Vec3 centre{0, 0, 0};
        Real radius2 = 0;  // [m^2]
    };

    /// Integrals at x. Beyond one support from the wall they are zero, and distance is a lower bound, at least the
    /// support.
    WallIntegrals at(const Vec3& x, Cursor& cursor) const;
    WallIntegrals at(const Vec3& x) const {
        Cursor cursor;
        return at(x, cursor);
    }
    /// Distance, exact nearer than a quarter of the support. `normal` becomes the unit normal from the wall, the
    /// gradient of the distance; zero beyond one support.
    Real distance(const Vec3& x, Vec3& normal, Cursor& cursor) const;
    Real distance(const Vec3& x, Vec3& normal) const {
        Cursor cursor;
        return distance(x, normal, cursor);
    }
    Real support() const { return support_; }
    const Shape& solid() const { return solid_; }

  private:
    static constexpr int kCells = 4;  // per axis of a block, each h/4
    static constexpr int kNodes = kCells + 1;
    static constexpr int kFine = 2;                            // samples per cell and axis
    static constexpr int kReach = 8;                           // samples per support
    static constexpr int kSide = kCells * kFine + 2 * kReach;  // samples per axis that a block needs
    /// distance, share, laplacian, gradient x y z, and two to fill a register.
    struct alignas(8 * sizeof(Real)) Node {
        Real value[8];
    };
    struct Block {
        Real far = 0;             // > 0: nothing within reach; a lower bound of the distance
        std::vector<Node> nodes;  // kNodes^3, x fastest; empty: far, or a half-space
        bool flat = false;        // the solid is nearly a half-space as far as the kernel reaches
        Vec3 normal{0, 0, 0};     // the half-space: distance = normal.x + offset
        Real offset = 0;          // [m]
        bool plane() const { return nodes.empty() && far <= 0; }
    };
    /// A cube of kPage^3 blocks: particles in cell order seldom leave it.
    static constexpr int kPageBits = 3, kPage = 1 << kPageBits;
    struct Page {
        std::array<std::atomic<const Block*>, std::size_t(kPage) * kPage * kPage> blocks{};
        ~Page();
    };
    struct StencilRow {     // one row of samples along x in the kernel's ball
        int y, z, x0, x1;   // offsets, x in [x0, x1)
        std::size_t first;  // into the weights
    };
    struct Weight {
        Real share, x, y, z, laplacian;
    };
    struct Place {  // in a block with nodes
        std::array<int, 3> cell;
        Vec3 part;  // in [0, 1]
    };

    const Block& block_at(const Vec3& x, Cursor& cursor, Vec3& inside) const;
    static Place place(const Vec3& inside);
    Block make_block(const Vec3& origin) const;
    Real unevenness(const Vec3& centre, Real& distance, Vec3& normal) const;
    std::vector<Real> occupancy(const Vec3& origin) const;
    struct Plane {
        Real distance = 0;     // signed, > 0 outside of the wall [m]
        Vec3 normal{0, 0, 0};  // unit, from the wall
    };
    struct Planes {
        std::array<Plane, 3> list;
        int count = 0;
    };
    static Vec3 way_off(const Planes& planes, Real radius);
    Plane nearest_face(const Vec3& x, Real distance) const;
    Planes planes_near(const Block& block, const Vec3& x, Real distance, const Vec3& gradient) const;
    void take_rounded_planes(const Vec3& x, const Block& block, WallIntegrals& w) const;
    WallIntegrals sum(const std::vector<Real>& filled, int i, int j, int k) const;
    void make_stencil();

    Shape solid_;
    std::optional<WallKernel> kernel_;
    Real support_, cell_, sample_;
    std::vector<StencilRow> rows_;
    std::vector<Weight> weights_;
    struct Hash {  // keys are three coordinates side by side: without mixing, 2^n buckets would depend on x alone
        std::size_t operator()(std::uint64_t key) const { return mix64(key); }
    };
    using Table = oneapi::tbb::concurrent_unordered_map<std::uint64_t, std::unique_ptr<Page>, Hash>;
    std::unique_ptr<Table> pages_;
};

}  // namespace thixo
