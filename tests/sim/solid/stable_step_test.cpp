// Fastest rates of bodies, and the sub-step that they allow, in double state.
#include "sim/solid/stable_step.h"

#include <gtest/gtest.h>

#include "sim/solid/elasticity.h"
#include "tests/sim/solid/blocks.h"

namespace thixo {
namespace {

using fixture::block;
using fixture::forces;
using fixture::kDistance;
using fixture::prepared;
using fixture::rubber;

/// A body of one law with these rates, alone.
Solids body_with_rates(const StressLaw& law, const FastestRates& rates) {
    Solids s;
    s.elements = prepared(block(3, 3, 3, kDistance, 0), law);
    s.bodies = fixture::one_body(s.elements);
    s.laws = {law};
    s.rates = {rates};
    return s;
}

TEST(StableStep, TheStiffestModeIsThatOfTheStiffnessMatrix) {
    StressLaw law = rubber();
    law.volume_stiffness = 1e5;
    Elements e = prepared(block(4, 4, 3, kDistance, Real(0.2)), law);
    const auto n = static_cast<Eigen::Index>(e.size());
    Eigen::MatrixXd k(3 * n, 3 * n);
    const Real small = Real(1e-7) * kDistance;
    for (Eigen::Index c = 0; c < 3 * n; ++c) {
        Real& u = (&e.displacement[static_cast<std::size_t>(c / 3)].x)[c % 3];
        u = small;
        const auto force = forces(law, e);
        u = 0;
        for (Eigen::Index r = 0; r < 3 * n; ++r)
            k(r, c) = static_cast<double>(-force[static_cast<std::size_t>(r / 3)][r % 3] / small / e.mass[0]);
    }
    const double largest =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>((k + k.transpose()) / 2).eigenvalues().maxCoeff();
    const double found = find_stiffest({law}, fixture::one_body(e), e)[0];
    EXPECT_LE(found, largest * (1 + 1e-3));  // displacements of 1e-4 supports are linear to 1e-4
    EXPECT_GE(found, 0.9 * largest);         // the step leaves room for a third
}

TEST(StableStep, DampingIsTheRateOfAShearModulusInPlaceOfTheViscosity) {
    // Viscous stress is 2 eta d(eps)/dt: the matrix of the damping is that of a law with mu = eta alone.
    constexpr Real kViscosity = 40;
    StressLaw law = rubber();
    law.viscosity = kViscosity;
    Elements e = prepared(block(4, 4, 3, kDistance, Real(0.2)), law);
    const std::vector<SolidBody> bodies = fixture::one_body(e);
    const std::vector<FastestRates> rates = find_fastest_rates({law}, bodies, e);
    const StressLaw shear{.mu = kViscosity};
    Elements other = prepared(block(4, 4, 3, kDistance, Real(0.2)), shear);
    EXPECT_EQ(rates[0].damping, find_stiffest({shear}, bodies, other)[0]);
    EXPECT_EQ(rates[0].stiffest, find_stiffest({law}, bodies, e)[0]);
}

TEST(StableStep, MeasuringRatesLeavesTheElementsAsTheyWere) {
    StressLaw law = rubber();
    law.viscosity = 40;
    Elements e = prepared(block(4, 4, 3, kDistance, Real(0.2)), law);
    fixture::shake(e, kDistance, Real(0.1));
    e.plastic[5] = {Real(0.1), 0, 0, 0, 0, 0};
    const std::vector<Vec3> before = forces(law, e);
    find_fastest_rates({law}, fixture::one_body(e), e);
    const std::vector<Vec3> after = forces(law, e);
    for (std::size_t i = 0; i < e.size(); ++i) EXPECT_EQ(before[i], after[i]) << i;
}

TEST(StableStep, UsesTheStatedPartOfTheLimitOfLeapfrog) {
    // omega^2 dt^2/4 + d dt/2 = 0.64, to the rounding of a square root.
    for (const double omega2 : {1e4, 1e8})
        for (const double damping : {0.0, 1.0, 1e5}) {
            const Solids s = body_with_rates(rubber(), {omega2, damping});
            const double dt = stable_sub_step(s, false);
            EXPECT_NEAR(omega2 * square(dt) / 4 + damping * dt / 2, 0.64, 1e-12) << omega2 << " " << damping;
        }
}

TEST(StableStep, ShrinksWithStretchAsTheTangentOfTheLawGrows) {
    // The tangent of sigma = C eps along a bar of stretch s grows by (3 s^2 - 1)/2, and dt goes with its root.
    Solids s = body_with_rates(rubber(), {1e6, 0});
    const double dt = stable_sub_step(s, false);
    s.stiffening = static_cast<double>(stiffening_of(Real(1.44), 1));
    EXPECT_NEAR(stable_sub_step(s, false), dt / std::sqrt((3 * 1.44 - 1) / 2), 1e-12 * dt);
    // A body that is compressed throughout is not taken for softer.
    s.stiffening = static_cast<double>(stiffening_of(Real(0.5), 1));
    EXPECT_EQ(stable_sub_step(s, false), dt);
}

}  // namespace
}  // namespace thixo
