// The tangent of the elastic forces, in double state.
#include "sim/solid/stiffness.h"

#include <gtest/gtest.h>

#include "tests/sim/solid/blocks.h"

namespace thixo {
namespace {

using fixture::block;
using fixture::forces;
using fixture::kDistance;
using fixture::prepared;
using fixture::rubber;

/// A strained block with dents, of uneven stencils; one that is flat too.
Elements strained(const StressLaw& law, int height) {
    Elements e = prepared(block(5, 4, height, kDistance, height > 1 ? Real(0.3) : Real(0)), law);
    for (std::size_t i = 0; i < e.size(); ++i) e.plastic[i] = {Real(0.05), Real(-0.02), 0, Real(0.03), 0, Real(0.01)};
    fixture::shake(e, kDistance, Real(0.2));
    return e;
}

std::vector<Quad> some_change(const Elements& e) {
    std::vector<Quad> du(e.size());
    for (std::size_t i = 0; i < e.size(); ++i)
        for (std::uint64_t a = 0; a < 3; ++a) (&du[i].x)[a] = static_cast<Real>(random_unit(5, i, a, 3) - 0.5);
    return du;
}

StressLaw every_term() {
    StressLaw law = rubber();
    law.volume_stiffness = 2e5;
    return law;
}

/// Central differences of the forces along du over 1e-7 distances: truncation 1e-14, rounding 1e-16/1e-7: 1e-7.
void expect_derivative(const StressLaw& law, Elements e) {
    const std::vector<Quad> du = some_change(e), u = e.displacement;
    Stiffness k;
    linearise({law}, e, 1, Tangent::exact, k);
    std::vector<Vec3> product(e.size());
    multiply(e, k, du, product);
    const Real step = Real(1e-7) * kDistance;
    const auto shifted = [&](Real by) {
        for (std::size_t i = 0; i < e.size(); ++i) e.displacement[i] = quad(xyz(u[i]) + by * xyz(du[i]));
        return forces(law, e);
    };
    const auto more = shifted(step), less = shifted(-step);
    Real scale = 0;
    for (const Vec3& f : product) scale = std::max(scale, f.norm());
    for (std::size_t i = 0; i < e.size(); ++i)
        EXPECT_LT((product[i] - (more[i] - less[i]) / (2 * step)).norm(), 1e-6 * scale) << "particle " << i;
}

TEST(Stiffness, IsMinusTheDerivativeOfTheForces) {
    expect_derivative(every_term(), strained(every_term(), 5));
    expect_derivative(rubber(), strained(rubber(), 1));
}

TEST(Stiffness, IsMinusTheDerivativeOfTheForcesOfAPermanentShape) {
    StressLaw law = every_term();
    law.keeps_volume = 1;
    expect_derivative(law, strained(law, 5));
}

TEST(Stiffness, IsMinusTheDerivativeOfTheForcesOfAnAnisotropicLaw) {
    StressLaw law = every_term();
    Elements e = strained(law, 5);
    Stiffness6 c;
    for (int a = 0; a < 6; ++a)
        for (int b = 0; b < 6; ++b) c(a, b) = Real(1e4) * (a == b ? 10 + a : 1 + a * b % 5);
    e.anisotropic = {Stiffness6(c + c.transpose())};
    law.anisotropy = 0;
    expect_derivative(law, e);
    law.keeps_volume = 1;
    expect_derivative(law, e);
}

TEST(Stiffness, OfViscosityIsThatOfAStepBackwardsInTime) {
    // From rest, f(u, u/dt) to first order in u.
    const Real dt = Real(0.003);
    StressLaw law = rubber();
    law.viscosity = 500;
    Elements e = prepared(block(5, 4, 5, kDistance, Real(0.3)), law);
    const std::vector<Quad> du = some_change(e);
    Stiffness k;
    linearise({law}, e, static_cast<double>(dt), Tangent::exact, k);
    std::vector<Vec3> product(e.size());
    multiply(e, k, du, product);
    const Real step = Real(1e-6) * kDistance;
    for (std::size_t i = 0; i < e.size(); ++i) {
        e.displacement[i] = quad(step * xyz(du[i]));
        e.velocity[i] = quad(step / dt * xyz(du[i]));
    }
    const auto force = forces(law, e);
    Real scale = 0;
    for (const Vec3& f : product) scale = std::max(scale, f.norm());
    for (std::size_t i = 0; i < e.size(); ++i) EXPECT_LT((product[i] - force[i] / step).norm(), 1e-5 * scale);
}

TEST(Stiffness, IsSymmetricAndTheDefiniteOneTakesWorkForEveryChange) {
    const StressLaw law = every_term();
    const Elements e = strained(law, 5);
    for (const Tangent tangent : {Tangent::exact, Tangent::definite}) {
        Stiffness k;
        linearise({law}, e, 1, tangent, k);
        std::vector<Quad> a = some_change(e), b = a;
        for (std::size_t i = 0; i < e.size(); ++i) b[i] = {a[i].y, -a[i].x, square(a[i].z), 0};
        std::vector<Vec3> ka(e.size()), kb(e.size());
        multiply(e, k, a, ka);
        multiply(e, k, b, kb);
        Real ab = 0, ba = 0, size = 0, work = 0;
        for (std::size_t i = 0; i < e.size(); ++i) {
            ab += xyz(a[i]).dot(kb[i]);
            ba += xyz(b[i]).dot(ka[i]);
            work -= xyz(a[i]).dot(ka[i]);
            size += xyz(a[i]).norm() * ka[i].norm();
        }
        EXPECT_NEAR(ab, ba, 1e-12 * size);
        EXPECT_TRUE(work > 0 || tangent == Tangent::exact);
    }
}

TEST(Stiffness, DiagonalBlocksAreThoseOfTheMatrixAtRest) {
    StressLaw law = every_term();
    law.viscosity = 30;
    for (const int height : {4, 1}) {
        const Elements e = prepared(block(4, 4, height, kDistance, height > 1 ? Real(0.3) : Real(0)), law);
        std::vector<Symmetric> elastic, viscous;
        find_diagonal({law}, e, elastic, viscous);
        Stiffness k;
        linearise({law}, e, 0.5, Tangent::exact, k);
        for (std::size_t i = 0; i < e.size(); i += 5)
            for (int a = 0; a < 3; ++a) {
                std::vector<Quad> du(e.size(), Quad{0, 0, 0, 0});
                du[i] = quad(Vec3::Unit(a));
                std::vector<Vec3> product(e.size());
                multiply(e, k, du, product);
                const Mat3 block = matrix(elastic[i]) + 2 * matrix(viscous[i]);
                EXPECT_LT((block.col(a) + product[i]).norm(), 1e-10 * block.norm());
            }
    }
}

}  // namespace
}  // namespace thixo
