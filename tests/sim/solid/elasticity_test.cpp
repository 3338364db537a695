// Laws of the elastic forces, in double state.
#include "sim/solid/elasticity.h"

#include <gtest/gtest.h>

#include "sim/bonds/weights.h"
#include "sim/solid/laws.h"
#include "sim/solid/plasticity.h"
#include "sim/state/solids.h"
#include "tests/sim/solid/blocks.h"

namespace thixo {
namespace {

using fixture::block;
using fixture::energy;
using fixture::forces;
using fixture::kDistance;
using fixture::prepared;
using fixture::rubber;
using fixture::turn;

Real largest(const std::vector<Vec3>& force) {
    Real most = 0;
    for (const Vec3& f : force) most = std::max(most, f.norm());
    return most;
}

/// Compares the forces with central differences of the energy. Differences over 1e-6 distances leave 1e-16/1e-6
/// rounding and 1e-12 truncation, relative to energies some thousand times the largest term: 1e-6 of the largest force.
void expect_forces_of_energy(const StressLaw& law, Elements e) {
    const std::vector<Vec3> force = forces(law, e);
    const Real step = Real(1e-6) * kDistance, scale = largest(force);
    ASSERT_GT(scale, 0);
    for (std::size_t i = 0; i < e.size(); i += 7)
        for (int a = 0; a < 3; ++a) {
            Real& u = (&e.displacement[i].x)[a];
            const Real here = u;
            u = here + step;
            const Real more = energy({law}, e);
            u = here - step;
            const Real less = energy({law}, e);
            u = here;
            EXPECT_NEAR(force[i][a], (less - more) / (2 * step), 1e-6 * scale) << "particle " << i << " axis " << a;
        }
}

TEST(Elasticity, ALinearDisplacementIsReproducedExactlyOnIrregularParticles) {
    Elements e = prepared(block(6, 5, 5, kDistance, Real(0.3)), rubber());
    Mat3 gradient;
    gradient << 0.1, 0.02, -0.05, 0.3, -0.1, 0.07, -0.04, 0.2, 0.15;
    fixture::move(e, [&](const Vec3& m) { return Vec3(m + gradient * m + Vec3(1, 2, 3)); });
    std::vector<Mat3> found;
    find_gradients(e, found);
    for (const Mat3& h : found) EXPECT_LT((h - gradient).norm(), 1e-12);  // rounding of places at 1 m
    // And nothing of it is left to the zero-energy modes, whatever their stiffness.
    StressLaw soft = rubber(), hard = rubber();
    soft.zero_energy = 0;
    hard.zero_energy = 100 * rubber().zero_energy;
    const auto a = forces(soft, prepared(e, soft)), b = forces(hard, prepared(e, hard));
    for (std::size_t i = 0; i < e.size(); ++i) EXPECT_LT((a[i] - b[i]).norm(), 1e-9 * largest(a));
}

TEST(Elasticity, AUniformStrainGivesTheStressOfTheLaw) {
    const StressLaw law = rubber();
    const Real modulus = 1e5, nu = Real(0.3), s = Real(0.01);
    const Real axial = s + s * s / 2, lateral = -nu * axial;
    const Symmetric stress = stress_of(law, {axial, lateral, lateral, 0, 0, 0});
    EXPECT_NEAR(stress.xx, modulus * axial, 1e-9 * modulus);
    EXPECT_NEAR(stress.yy, 0, 1e-9 * modulus);
    EXPECT_NEAR(stress_of(law, {0, 0, 0, s, 0, 0}).xy, modulus / (1 + nu) * s, 1e-9 * modulus);
}

TEST(Elasticity, AnOrthotropicLawPulledAlongAnAxisOfItsOwnHasThatAxisModulus) {
    // eps_a = s, eps_b = - nu_ab s in the material's axes, wherever they point: sigma_aa = E_a s and nothing else.
    const scene::Orthotropic o{{4e5, 1e5, 2e5}, {5e4, 3e4, 6e4}, {0.3, 0.2, 0.1}, {}};
    const Mat3 axes = turn();
    Elements e;
    e.anisotropic = {orthotropic_stiffness(o, axes.cast<double>())};
    const StressLaw law{.anisotropy = 0};
    const Real s = Real(0.01);
    for (int a = 0; a < 3; ++a) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        Vec3 own = Vec3::Zero();
        own[a] = s;
        own[b] = -static_cast<Real>(o.poisson_ratio[a]) * s;                                              // nu_ab
        own[c] = -static_cast<Real>(o.poisson_ratio[c] * o.youngs_modulus[a] / o.youngs_modulus[c]) * s;  // nu_ac
        const Mat3 strain = axes * own.asDiagonal() * axes.transpose();
        const Mat3 stress = matrix(stress_of(law, e, symmetric(strain)));
        const Mat3 expected = static_cast<Real>(o.youngs_modulus[a]) * s * axes.col(a) * axes.col(a).transpose();
        EXPECT_LT((stress - expected).norm(), 1e-9 * expected.norm());
        const Mat3 sheared = axes.col(a) * axes.col(b).transpose() + axes.col(b) * axes.col(a).transpose();
        const Mat3 shear = matrix(stress_of(law, e, symmetric(Mat3(s / 2 * sheared))));
        EXPECT_LT((shear - static_cast<Real>(o.shear_modulus[a]) * s * sheared).norm(), 1e-9 * shear.norm());
    }
}

TEST(Elasticity, ARigidMotionGivesNoForce) {
    StressLaw law = rubber();
    law.volume_stiffness = 1e5;
    Elements e = prepared(block(5, 5, 6, kDistance, Real(0.3)), law);
    fixture::move(e, [&](const Vec3& m) { return Vec3(turn() * m + Vec3(0.3, -1, 2)); });
    EXPECT_LT(largest(forces(law, e)), 1e-10 * law.mu * square(kDistance));
}

TEST(Elasticity, ForcesAreMinusTheGradientOfTheEnergy) {
    StressLaw law = rubber();
    law.volume_stiffness = 2e5;
    Elements e = prepared(block(5, 4, 5, kDistance, Real(0.3)), law);
    for (std::size_t i = 0; i < e.size(); ++i) e.plastic[i] = {Real(0.05), Real(-0.02), 0, Real(0.03), 0, Real(0.01)};
    fixture::shake(e, kDistance, Real(0.2));
    expect_forces_of_energy({law}, e);
    double of_elements = 0;
    for (std::size_t i = 0; i < e.size(); ++i) of_elements += elastic_energy_of(law, e, i);
    EXPECT_NEAR(of_elements, static_cast<double>(energy({law}, e)), 1e-9 * of_elements);
}

TEST(Elasticity, ForcesAreMinusTheGradientOfTheEnergyOfAPermanentShape) {
    StressLaw law = rubber();
    law.keeps_volume = 1;
    Elements e = prepared(block(5, 4, 5, kDistance, Real(0.3)), law);
    for (std::size_t i = 0; i < e.size(); ++i)
        e.plastic[i] = {Real(0.6), Real(-0.2), Real(-0.15), Real(0.1), 0, Real(0.05)};
    fixture::shake(e, kDistance, Real(0.2));
    expect_forces_of_energy({law}, e);
    double of_elements = 0;
    for (std::size_t i = 0; i < e.size(); ++i) of_elements += elastic_energy_of(law, e, i);
    EXPECT_NEAR(of_elements, static_cast<double>(energy({law}, e)), 1e-9 * of_elements);
}

TEST(Elasticity, SupportsOfTheirOwnKeepForcesTheGradientOfTheEnergy) {
    Elements bare = block(5, 5, 4, kDistance, Real(0.2));
    for (std::size_t i = 0; i < bare.size(); ++i) bare.support[i] *= Real(i % 3 == 0 ? 1.4 : 1);
    Elements e = prepared(std::move(bare), rubber());
    fixture::shake(e, kDistance, Real(0.2));
    expect_forces_of_energy(rubber(), e);
}

TEST(Elasticity, AFlatLayerResistsInItsPlaneAndTurnsFreely) {
    Elements e = prepared(block(7, 7, 1, kDistance, 0), rubber());
    EXPECT_EQ(e.bonds.flat.size(), e.size());
    fixture::move(e, [&](const Vec3& m) { return Vec3(turn() * m); });
    EXPECT_LT(largest(forces(rubber(), e)), 1e-10 * rubber().mu * square(kDistance));
    fixture::shake(e, kDistance, Real(0.2));
    expect_forces_of_energy(rubber(), e);
}

TEST(Elasticity, LoneParticlesAndPairsAreNoTrouble) {
    Elements e = prepared(block(2, 1, 1, kDistance, 0), rubber());
    e.displacement[1].x = Real(0.001);
    const auto pair = forces(rubber(), e);
    EXPECT_LT(pair[1].x(), 0);  // a rod of two pulls itself together
    EXPECT_NEAR(pair[0].x(), -pair[1].x(), 1e-12);
    EXPECT_EQ(largest(forces(rubber(), prepared(block(1, 1, 1, kDistance, 0), rubber()))), 0);
}

TEST(Elasticity, ForcesHaveNoSumAndNoTorque) {
    StressLaw law = rubber();
    law.volume_stiffness = 2e5;
    law.viscosity = 10;
    Elements e = prepared(block(6, 5, 5, kDistance, Real(0.3)), law);
    fixture::shake(e, kDistance, Real(0.3));
    for (std::size_t i = 0; i < e.size(); ++i) e.velocity[i] = {Real(i % 5), Real(i % 3), Real(i % 7), 0};
    const auto force = forces(law, e);
    Vec3 sum(0, 0, 0), torque(0, 0, 0);
    Real all = 0, arms = 0;
    for (std::size_t i = 0; i < e.size(); ++i) {
        const Vec3 x = xyz(e.rest[i]) + xyz(e.displacement[i]);
        sum += force[i];
        torque += x.cross(force[i]);
        all += force[i].norm();
        arms += x.norm() * force[i].norm();
    }
    EXPECT_LT(sum.norm(), 1e-13 * all);
    EXPECT_LT(torque.norm(), 1e-13 * arms);
}

TEST(Elasticity, ViscosityTakesEnergyOfStrainingAndNoneOfRigidMotion) {
    StressLaw law = rubber();
    law.viscosity = 10;
    Elements e = prepared(block(5, 5, 5, kDistance, Real(0.3)), law);
    const Vec3 spin(3, -2, 5);
    for (std::size_t i = 0; i < e.size(); ++i) e.velocity[i] = quad(spin.cross(xyz(e.rest[i])) + Vec3(1, 2, 3));
    EXPECT_LT(largest(forces(law, e)), 1e-10 * law.viscosity * kDistance * 5);
    for (std::size_t i = 0; i < e.size(); ++i) e.velocity[i] = quad(Vec3(xyz(e.rest[i]).x(), 0, 0));
    Real power = 0;
    const auto force = forces(law, e);
    for (std::size_t i = 0; i < e.size(); ++i) power += force[i].dot(xyz(e.velocity[i]));
    EXPECT_NEAR(power, -2 * law.viscosity * 125 * cube(kDistance),
                1e-9 * law.viscosity * 125 * cube(kDistance));  // 2 eta V (d/dt eps)^2
}

TEST(PlasticFlow, BelowTheYieldNothingStaysAndAboveItCreepsAtItsRate) {
    StressLaw law = rubber();
    law.yield = Real(0.02);
    law.creep = 10;
    Elements e = prepared(block(4, 4, 4, kDistance, Real(0.2)), law);
    std::vector<Mat3> gradients;
    const auto stretch = [&](Real s) {
        fixture::move(e, [&](const Vec3& m) { return Vec3(m.x() * (1 + s), m.y(), m.z()); });
        find_gradients(e, gradients);
        flow_plastically({law}, 0.01, gradients, e);
    };
    stretch(Real(0.019));
    for (const Symmetric& p : e.plastic) EXPECT_EQ(norm(p), 0);
    stretch(Real(0.1));
    for (const Symmetric& p : e.plastic) EXPECT_NEAR(p.xx, (1 - std::exp(-0.1)) * 0.105, 1e-12);
    law.most_plastic = Real(0.05);
    for (int k = 0; k < 20; ++k) stretch(Real(0.1));
    for (const Symmetric& p : e.plastic) EXPECT_NEAR(norm(p), 0.05, 1e-12);
    // A step longer than 1/k_creep ends where the strain yields.
    law.most_plastic = 0;
    flow_plastically({law}, 1, gradients, e);
    for (const Symmetric& p : e.plastic) EXPECT_NEAR(p.xx, 0.105 - 0.02, 1e-12);
}

/// The principal stresses of all elements, ascending.
std::vector<Vec3> principal_stresses(const StressLaw& law, const Elements& e) {
    std::vector<Vec3> out;
    for (std::size_t i = 0; i < e.size(); ++i) {
        const Mat3 h = gradient_of(e, static_cast<Index>(i));
        Eigen::SelfAdjointEigenSolver<Mat3> eigen(matrix(stress_of_shape(law, e, i, h)));
        out.push_back(eigen.eigenvalues());
    }
    return out;
}

TEST(PlasticFlow, NeighboursLostBehindACrackLeaveTheStressAsItIs) {
    // A block that was bent for good: its stretch differs within a support, and so does what half of a support shows.
    for (const Index keeps_volume : {0u, 1u}) {
        StressLaw law = rubber();
        law.creep = 1;
        law.keeps_volume = keeps_volume;
        Elements e = prepared(block(6, 5, 5, kDistance, Real(0.2)), law);
        fixture::move(e, [](const Vec3& m) { return Vec3(m + Vec3(20 * m.x() * m.x(), -5 * m.x() * m.y(), 0)); });
        std::vector<Mat3> gradients;
        find_gradients(e, gradients);
        for (std::size_t i = 0; i < e.size(); ++i) {
            const Symmetric strain = strain_of(e, i, gradients[i]);
            e.plastic[i] = plastic_beside(law, strain, {Real(0.01), Real(-0.004), Real(-0.003), Real(0.002), 0, 0});
        }
        const std::vector<Vec3> before = principal_stresses(law, e);
        const KeptStrains kept({law}, e, gradients);
        std::vector<WeakBond> cut;
        for (Index i = 0; i < e.size(); ++i)
            for (std::size_t k = e.bonds.begin[i]; k < e.bonds.begin[i + 1]; ++k)
                if (const Index j = e.bonds.neighbour[k]; (e.rest[i].x < 0.025) != (e.rest[j].x < 0.025))
                    cut.push_back({i, j, 0});
        weaken_bonds(cut, e);
        const auto change = [&] {
            const std::vector<Vec3> now = principal_stresses(law, e);
            Real most = 0;
            for (std::size_t i = 0; i < e.size(); ++i) most = std::max(most, (now[i] - before[i]).norm());
            return most / (law.mu * Real(0.01));
        };
        EXPECT_GT(change(), 1) << "the estimate alone would make stress";
        kept.restore({law}, e);
        EXPECT_LT(change(), 1e-9) << keeps_volume;
    }
}

}  // namespace
}  // namespace thixo
