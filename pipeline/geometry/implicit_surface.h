// The smooth surface that a cloud of surfels represents, as the zero set of an implicit function.
// Source: dissertation 2.5.1 (Adamson & Alexa 2004).
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "pipeline/base/lanes.h"
#include "pipeline/geometry/kernels.h"
#include "pipeline/geometry/point_grid.h"

namespace thixo {

/// Sums of the weighted average of surfels around a point x:
///     a(x) = sum w_i s_i / sum w_i  [m]
///     n(x) = unit(sum w_i n_i)  [1]
struct SurfelAverage {
    /// Adds a surfel of weight w at offset = s_i - x [m] with unit normal n_i.
    void add(Real w, const Vec3& offset, const Vec3& n) {
        weight += w;
        position += w * offset;
        normal += w * n;
        planes -= w * n.dot(offset);
    }
    /// False where no surfel was added or the normals cancel: F is undefined there.
    bool defined() const { return weight > 0 && normal.squaredNorm() > square(Real(1e-6) * weight); }
    /// F(x) = n(x).(x - a(x))  [m], > 0 outside. Requires defined().
    Real value() const { return -normal.dot(position) / (normal.norm() * weight); }
    Vec3 unit_normal() const { return normal.normalized(); }

    Real weight = 0;
    Vec3 position{0, 0, 0};  // sum of w_i (s_i - x)
    Vec3 normal{0, 0, 0};    // sum of w_i n_i
    Real planes = 0;         // sum of w_i n_i.(x - s_i)
};

/// The sums of a SurfelAverage over runs of surfels.
struct SurfelSums {
    void add(Lanes a, Lanes dx, Lanes dy, Lanes dz, Lanes mx, Lanes my, Lanes mz) {
        weight += a;
        x += a * dx;
        y += a * dy;
        z += a * dz;
        nx += a * mx;
        ny += a * my;
        nz += a * mz;
        planes -= a * (mx * dx + my * dy + mz * dz);
    }
    SurfelAverage average() const {
        return {
            sum_of(weight), {sum_of(x), sum_of(y), sum_of(z)}, {sum_of(nx), sum_of(ny), sum_of(nz)}, sum_of(planes)};
    }

    Lanes weight{}, x{}, y{}, z{}, nx{}, ny{}, nz{}, planes{};
};

/// Selects surfels. Thin sheets need it, because surfels of the other side must not enter the average.
struct SurfelSelection {
    Vec3 reference{0, 0, 0};               // unit normal that surfels must agree with; zero: any
    Real least_cosine = Real(0.70710678);  // of the angle between normal and reference: 45 degrees
    std::optional<std::int32_t> group{};   // body or sheet; empty: any
};

/// How a projection or a search for a root ended.
enum class SurfaceStatus {
    converged,
    step_cap,     ///< the largest number of steps was taken; the result is the last iterate
    left_domain,  ///< an iterate has no surfel within the support: F is undefined there
    no_root,      ///< a root was sought where F does not change sign
};

struct SurfaceProjection {
    Vec3 position{0, 0, 0};  // [m]
    Vec3 normal{0, 0, 0};    // n at the position, unit
    int steps = 0;
    SurfaceStatus status = SurfaceStatus::left_domain;
};

struct SurfaceRoot {
    Real t = 0;  // from + t (to - from), in [0, 1]
    int steps = 0;
    SurfaceStatus status = SurfaceStatus::no_root;
};

/// Limits at which iterations stop.
struct ProjectionLimits {
    Real tolerance = Real(1e-4);  // steps below this part of the support end the iteration
    int steps = 20;
};

class ImplicitSurface {
  public:
    /// F and its terms at one point.
    struct Sample {
        Real value = 0;         // F [m]
        Vec3 average{0, 0, 0};  // a [m]
        Vec3 normal{0, 0, 0};   // n, unit
        Real planes =
            0;  // mean signed distance sum w_i n_i.(x - s_i) / sum w_i from the surfels' planes [m] (Shen et al. 2004)
        Vec3 gradient{0, 0, 0};  // grad F [1]; zero where evaluate gives the value alone
        Real agreement = 1;      // |sum w_i n_i| / sum w_i: 1 where normals are equal, small inside a thin sheet
    };

    /// Copies the surfels. `support` h_s > 0 [m]; `groups` (body or sheet of each surfel) may be empty.
    void build(std::span<const Vec3> positions, std::span<const Vec3> normals, Real support,
               std::span<const std::int32_t> groups = {});

    Real support() const { return support_; }

    /// F(x) = n(x).(x - a(x))  [m], with the weights w_poly6(x - s_i, h_s). Empty where x is outside the supports of
    /// all chosen surfels, and where their normals cancel.
    std::optional<Sample> evaluate(const Vec3& x, const SurfelSelection& selection = {}) const;
    /// The same with the gradient
    ///     grad F = n - (grad a)^T n + (grad n)^T (x - a)  [1]
    std::optional<Sample> evaluate_gradient(const Vec3& x, const SurfelSelection& selection = {}) const;

    /// Normal of the surfel nearest to x; empty where none is within the support.
    std::optional<Vec3> nearest_normal(const Vec3& x) const;

    /// Iterates until the step is small:
    ///     x <- x - F(x) n(x)
    SurfaceProjection project_simple(const Vec3& x, const SurfelSelection& selection = {},
                                     const ProjectionLimits& limits = {}) const;
    /// Ends nearly below the start point x0. Iterates
    ///     x' <- x0 - (n(x').(x0 - a(x'))) n(x')
    SurfaceProjection project_almost_orthogonal(const Vec3& x, const SurfelSelection& selection = {},
                                                const ProjectionLimits& limits = {}) const;
    /// Ends at the foot point of x0 (2.52). Iterates
    ///     x' <- x0 - q grad F(x'),  q = n(x').(x0 - a(x')) / (n(x').grad F(x'))
    SurfaceProjection project_orthogonal(const Vec3& x, const SurfelSelection& selection = {},
                                         const ProjectionLimits& limits = {}) const;

    /// Root of F on the segment by Brent's method. F must be defined at both ends, with opposite signs. The root is
    /// exact to `tolerance` supports.
    SurfaceRoot root(const Vec3& from, const Vec3& to, const SurfelSelection& selection = {},
                     const ProjectionLimits& limits = {}) const;

  private:
    template <class F>
    void for_each_selected(const Vec3& x, const SurfelSelection& selection, F&& f) const;

    Real support_ = 0;
    PointGrid grid_;
    std::vector<Vec3> position_, normal_;  // in the grid's order
    std::vector<std::int32_t> group_;
};

}  // namespace thixo
