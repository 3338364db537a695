// Laws of plastic flow, in double state.
#include "sim/solid/plasticity.h"

#include <gtest/gtest.h>

namespace thixo {
namespace {

constexpr Symmetric kStretched{Real(0.3), Real(-0.12), Real(-0.1), Real(0.05), Real(-0.02), Real(0.03)};

StressLaw clay(bool keeps_volume) {
    StressLaw law{.lambda = 1e5, .mu = 1e5, .yield = Real(0.02), .creep = 10};
    law.keeps_volume = keeps_volume ? 1 : 0;
    return law;
}
Real determinant(const Symmetric& plastic) { return (Mat3::Identity() + 2 * matrix(plastic)).determinant(); }

struct State {
    Symmetric plastic;
    Real hardened = 0;
    Real size(const StressLaw& law, const Symmetric& strain) const { return flowing_size(law, strain, plastic); }
};
State flowed(const StressLaw& law, Real time, int steps, const Symmetric& strain) {
    State s;
    for (int k = 0; k < steps; ++k) flow_plastically(law, time / Real(steps), strain, s.plastic, s.hardened);
    return s;
}

TEST(Plasticity, AFlowEndsAlikeAfterOneStepOrMany) {
    // The exponential is exact in any number of steps. A return along dev e bends with the metric, by the square of the
    // flow. The returns that follow leave a thousandth of it.
    for (const bool keeps_volume : {false, true}) {
        const StressLaw law = clay(keeps_volume);
        const Real before = State{}.size(law, kStretched);
        for (const Real time : {Real(0.03), Real(0.1), Real(10)}) {
            const Real expected = std::max(before * std::exp(-law.creep * time), law.yield);
            for (const int steps : {1, 7, 300, 20000})
                EXPECT_NEAR(flowed(law, time, steps, kStretched).size(law, kStretched), expected, 2e-3 * expected)
                    << keeps_volume << ' ' << time << ' ' << steps;
        }
    }
}

TEST(Plasticity, AStepLongerThanTheCreepEndsOnTheYieldSurface) {
    for (const bool keeps_volume : {false, true}) {
        const StressLaw law = clay(keeps_volume);
        const State s = flowed(law, 1000, 1, kStretched);
        EXPECT_NEAR(s.size(law, kStretched), law.yield, 1e-3 * law.yield);
    }
}

TEST(Plasticity, DeviatoricFlowKeepsTheVolumeAtAnyStrain) {
    // To twice and half the length, with shear: by rounding alone.
    const StressLaw law = clay(true);
    for (const Symmetric& strain :
         {Symmetric{Real(1.5), Real(-0.25), Real(-0.25)}, Symmetric{Real(-0.375), Real(0.5), Real(0.5)}, kStretched})
        for (const int steps : {1, 50}) {
            State s;
            for (int k = 1; k <= steps; ++k) {
                const Real a = Real(k) / Real(steps);
                const Symmetric now{a * strain.xx, a * strain.yy, a * strain.zz,
                                    a * strain.xy, a * strain.yz, a * strain.zx};
                flow_plastically(law, 1, now, s.plastic, s.hardened);
            }
            EXPECT_NEAR(determinant(s.plastic), 1, 1e-12);
            EXPECT_GT(norm(s.plastic), 0.1);
        }
}

TEST(Plasticity, OfDilatationAloneNothingFlowsDeviatorically) {
    const StressLaw law = clay(true);
    const State s = flowed(law, 1, 1, {Real(0.2), Real(0.2), Real(0.2)});
    EXPECT_LT(norm(s.plastic), 1e-15);
    EXPECT_GT(norm(flowed(clay(false), 1, 1, {Real(0.2), Real(0.2), Real(0.2)}).plastic), 0.1);
}

TEST(Plasticity, TheYieldSurfaceGrowsLinearlyWithTheFlow) {
    for (const bool keeps_volume : {false, true})
        for (const int steps : {1, 40}) {
            StressLaw law = clay(keeps_volume);
            law.hardening = Real(0.5);
            const State s = flowed(law, 1000, steps, kStretched);
            const Real surface = law.yield + law.hardening * s.hardened;
            EXPECT_NEAR(s.size(law, kStretched), surface, 1e-3 * surface);
            EXPECT_NEAR(s.hardened, State{}.size(law, kStretched) - surface, 1e-3 * surface);
            // What has flowed bears as much again without flowing.
            EXPECT_EQ(remaining_part(law, 1, surface * Real(0.999), s.hardened), 1);
        }
}

TEST(Plasticity, PermanentStrainHasItsLimit) {
    for (const bool keeps_volume : {false, true}) {
        StressLaw law = clay(keeps_volume);
        law.most_plastic = Real(0.1);
        const State s = flowed(law, 10, 20, kStretched);
        EXPECT_NEAR(norm(s.plastic), 0.1, keeps_volume ? 2e-3 : 1e-12);
        if (keeps_volume) {
            EXPECT_NEAR(determinant(s.plastic), 1, 1e-12);
        }
    }
}

}  // namespace
}  // namespace thixo
