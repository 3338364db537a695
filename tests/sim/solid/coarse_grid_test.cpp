// The coarse correction of implicit steps, in double state.
#include "sim/solid/coarse_grid.h"

#include <gtest/gtest.h>

#include "sim/solid/stiffness.h"
#include "tests/sim/solid/blocks.h"

namespace thixo {
namespace {

using fixture::block;
using fixture::kDistance;
using fixture::prepared;

constexpr double kStep = 1e-3;

StressLaw damped_rubber() {
    StressLaw law = fixture::rubber();
    law.volume_stiffness = 2e5;
    law.viscosity = 30;
    return law;
}

/// A block of elements with its coarse grid, factored for kStep.
struct Gridded {
    StressLaw law = damped_rubber();
    Elements e;
    CoarseGrid grid;

    Gridded(int nx, int ny, int nz, const std::vector<std::size_t>& held = {},
            const std::vector<Symmetric>& bounds = {})
        : e(prepared(block(nx, ny, nz, kDistance, Real(0.3)), law)) {
        std::vector<std::uint8_t> is_held(e.size(), 0);
        for (const std::size_t i : held) is_held[i] = 1;
        grid.prepare({law}, fixture::one_body(e), e, is_held);
        if (grid.nodes() > 0) grid.factor(kStep, bounds);
    }
    std::vector<Vec3> correction(const std::vector<Vec3>& r) {
        std::vector<Vec3> z(e.size(), Vec3::Zero());
        grid.add_correction(r, z);
        return z;
    }
    /// (M/dt^2 + K) u, K multiplied stencil by stencil.
    std::vector<Vec3> product(const std::vector<Quad>& u) const {
        Stiffness k;
        linearise({law}, e, kStep, Tangent::exact, k);
        std::vector<Vec3> r(e.size());
        multiply(e, k, u, r);
        for (std::size_t i = 0; i < e.size(); ++i) r[i] = e.mass[i] / square(Real(kStep)) * xyz(u[i]) - r[i];
        return r;
    }
};

std::vector<Vec3> some_forces(std::size_t n, std::uint64_t use) {
    std::vector<Vec3> r(n);
    for (std::size_t i = 0; i < n; ++i)
        for (std::uint64_t a = 0; a < 3; ++a) r[i][int(a)] = static_cast<Real>(random_unit(5, i, a, use) - 0.5);
    return r;
}

double dot_of(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += static_cast<double>(a[i].dot(b[i]));
    return sum;
}

/// From (M/dt^2 + K) u the grid finds u = f(m), if its nodes represent f. Its matrix is shifted by 1e-9 on the
/// diagonal, of which its condition makes no more than 1e-4.
template <class F>
void expect_solved_at_once(F&& f) {
    Gridded g(9, 8, 7);
    ASSERT_GT(g.grid.nodes(), 8u);
    std::vector<Quad> u(g.e.size());
    for (std::size_t i = 0; i < g.e.size(); ++i) u[i] = quad(f(xyz(g.e.rest[i])));
    const std::vector<Vec3> z = g.correction(g.product(u));
    for (std::size_t i = 0; i < g.e.size(); ++i) EXPECT_LT((z[i] - xyz(u[i])).norm(), 1e-4 * kDistance) << i;
}

TEST(CoarseGrid, SolvesALinearDisplacementAtOnce) {
    Mat3 gradient;
    gradient << 0.1, 0.02, -0.05, 0.3, -0.1, 0.07, -0.04, 0.2, 0.15;
    expect_solved_at_once([&](const Vec3& m) { return Vec3(gradient * m + Vec3(0.01, 0.02, 0.005)); });
}

TEST(CoarseGrid, SolvesATrilinearDisplacementAtOnce) {
    // Of the size of the block's width, 0.08 m, in every one of its terms.
    expect_solved_at_once([](const Vec3& m) {
        const Vec3 q = m / Real(0.08);
        return Vec3(Real(0.02) * q.x() * q.y() * q.z(), Real(0.03) * q.x() * q.y() - Real(0.01) * q.z(),
                    Real(0.02) * q.y() * q.z() + Real(0.01) * q.x() * q.z());
    });
}

TEST(CoarseGrid, CorrectionIsSymmetricAndPositive) {
    // Conjugate gradients need both. Cholesky's method keeps symmetry to rounding times the matrix's condition, 1e4.
    const std::vector<std::size_t> held{0, 1, 2};
    std::vector<Symmetric> bounds(6 * 6 * 5);
    for (std::size_t i = 0; i < bounds.size(); i += 3) bounds[i] = {Real(500), Real(300), Real(200), Real(50), 0, 0};
    Gridded g(6, 6, 5, held, bounds);
    ASSERT_GT(g.grid.nodes(), 0u);
    const std::vector<Vec3> a = some_forces(g.e.size(), 1), b = some_forces(g.e.size(), 2);
    const std::vector<Vec3> za = g.correction(a), zb = g.correction(b);
    EXPECT_NEAR(dot_of(a, zb), dot_of(b, za), 1e-10 * std::sqrt(dot_of(a, za) * dot_of(b, zb)));
    EXPECT_GT(dot_of(a, za), 0);
    EXPECT_GT(dot_of(b, zb), 0);
}

TEST(CoarseGrid, ElementsThatAreHeldNeitherMoveNorPush) {
    const std::vector<std::size_t> held{3, 17, 40};
    Gridded g(6, 6, 5, held);
    std::vector<Vec3> r = some_forces(g.e.size(), 1);
    const std::vector<Vec3> z = g.correction(r);
    for (const std::size_t i : held) {
        EXPECT_EQ(z[i], Vec3(Vec3::Zero()));
        r[i] *= 100;
    }
    EXPECT_EQ(g.correction(r), z);
}

TEST(CoarseGrid, ABodyOfFewElementsHasNone) {
    Gridded g(3, 3, 3);
    EXPECT_EQ(g.grid.nodes(), 0u);
    for (const Vec3& z : g.correction(some_forces(g.e.size(), 1))) EXPECT_EQ(z, Vec3(Vec3::Zero()));
}

}  // namespace
}  // namespace thixo
