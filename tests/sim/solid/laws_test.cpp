// Elastic laws resolved from a scene, in double state.
#include "sim/solid/laws.h"

#include <gtest/gtest.h>

#include "pipeline/contract/scene.h"
#include "sim/solid/elasticity.h"

namespace thixo {
namespace {

constexpr double kModulus = 3e5, kPoisson = 0.27;

scene::Material solid(const std::string& name, double modulus, double poisson) {
    scene::Material m;
    m.name = name;
    m.elastic.youngs_modulus = modulus;
    m.elastic.poisson_ratio = poisson;
    return m;
}

scene::Scene one_material() {
    scene::Scene s;
    s.materials = {solid("rubber", kModulus, kPoisson)};
    return s;
}

StressLaw law_of(const scene::Scene& s, std::size_t material = 0, double time = 0) {
    return law_at(resolve_materials(s, 1)[material], time);
}

Stiffness6 isotropic_stiffness(const StressLaw& law) {
    Stiffness6 c;
    for (int k = 0; k < 6; ++k) {
        Symmetric strain;
        (&strain.xx)[k] = k < 3 ? Real(1) : Real(0.5);  // engineering shear
        const Symmetric stress = stress_of(law, strain);
        for (int r = 0; r < 6; ++r) c(r, k) = (&stress.xx)[r];
    }
    return c;
}

TEST(Laws, ABarPulledAlongItsAxisHasYoungsModulusAndNarrowsByPoissonsRatio) {
    // Rounding of a few operations in double, 1e-15 of the modulus each.
    const StressLaw law = law_of(one_material());
    const Symmetric stress = stress_of(law, {Real(1), Real(-kPoisson), Real(-kPoisson), 0, 0, 0});
    EXPECT_NEAR(stress.xx, kModulus, 1e-14 * kModulus);
    for (const Real side : {stress.yy, stress.zz, stress.xy, stress.yz, stress.zx})
        EXPECT_NEAR(side, 0, 1e-14 * kModulus);
}

TEST(Laws, ShearHasTheShearModulus) {
    const StressLaw law = law_of(one_material());
    const Symmetric stress = stress_of(law, {0, 0, 0, Real(0.5), 0, 0});
    EXPECT_NEAR(stress.xy, kModulus / (2 * (1 + kPoisson)), 1e-14 * kModulus);
    EXPECT_EQ(stress.xx, 0);
}

TEST(Laws, AChangeOfMaterialIsLinearInTimeAndThenComplete) {
    scene::Scene s = one_material();
    s.materials.push_back(solid("wood", 5 * kModulus, kPoisson));
    s.materials[0].viscosity = 2;
    s.materials[1].viscosity = 6;
    s.materials[0].elastic.changes = {{.time = 3, .duration = 2, .material = "wood"}};
    const StressLaw before = law_of(s), after = law_of(s, 1, 0);
    EXPECT_EQ(law_of(s, 0, 1), before);
    for (const double part : {0.25, 0.5, 0.75}) {
        const StressLaw law = law_of(s, 0, 1 + 2 * part);
        EXPECT_NEAR(law.mu, (1 - part) * before.mu + part * after.mu, 1e-13 * after.mu);
        EXPECT_NEAR(law.lambda, (1 - part) * before.lambda + part * after.lambda, 1e-13 * after.lambda);
        EXPECT_NEAR(law.viscosity, 2 + 4 * part, 1e-13);
    }
    EXPECT_EQ(law_of(s, 0, 3), after);
    EXPECT_EQ(law_of(s, 0, 100), after);
}

TEST(Laws, AChangeWithoutDurationIsComplete) {
    scene::Scene s = one_material();
    s.materials.push_back(solid("wood", 5 * kModulus, 0.4));
    s.materials[0].elastic.changes = {{.time = 3, .duration = 0, .material = "wood"}};
    EXPECT_EQ(law_of(s, 0, 2.999), law_of(one_material()));
    EXPECT_EQ(law_of(s, 0, 3), law_of(s, 1, 0));
}

TEST(Laws, AMeltingLawGoesLinearlyFromTheSolidToTheLiquid) {
    scene::Scene s = one_material();
    s.materials[0].viscosity = 8;
    s.materials[0].melting = {
        .from = 50, .to = 60, .liquid = {.youngs_modulus = kModulus / 10, .poisson_ratio = kPoisson}};
    const ResolvedMaterial wax = resolve_materials(s, 1)[0];
    const auto at = [&](double b) { return melting_law(wax.melting, elastic_at(wax, 0), b); };
    const StressLaw cold = law_of(s);
    EXPECT_EQ(at(0), cold);
    for (const double b : {0.5, 1.0}) {
        EXPECT_NEAR(at(b).mu, (1 - 0.9 * b) * cold.mu, 1e-13 * cold.mu);
        EXPECT_NEAR(at(b).viscosity, (1 - b) * 8, 1e-13);  // elastic damping goes with the solid's share
    }
}

TEST(Laws, AShareScalesModuliAndDampingAndNoLimit) {
    scene::Scene s = one_material();
    s.materials[0].viscosity = 8;
    s.materials[0].elastic.volume_stiffness = 1e5;
    s.materials[0].elastic.yield_strain = 0.1;
    s.materials[0].elastic.creep = 5;
    const StressLaw law = law_of(s), half = scaled(law, Real(0.5));
    EXPECT_EQ(half.lambda, law.lambda / 2);
    EXPECT_EQ(half.mu, law.mu / 2);
    EXPECT_EQ(half.volume_stiffness, law.volume_stiffness / 2);
    EXPECT_EQ(half.viscosity, law.viscosity / 2);
    EXPECT_EQ(half.zero_energy, law.zero_energy / 2);
    EXPECT_EQ(half.yield, law.yield);
    EXPECT_EQ(half.creep, law.creep);
}

Mat3d some_axes() { return Eigen::AngleAxisd(0.7, Vec3d(2, -1, 1).normalized()).toRotationMatrix(); }

TEST(Laws, AnOrthotropicLawOfEqualModuliIsTheIsotropicOneAlongAnyAxes) {
    // The inverse of a 6x6 matrix of condition 5, and two turns: some hundred rounding errors of 1e-16.
    const double shear = kModulus / (2 * (1 + kPoisson));
    const scene::Orthotropic o{.youngs_modulus = Vec3d::Constant(kModulus),
                               .shear_modulus = Vec3d::Constant(shear),
                               .poisson_ratio = Vec3d::Constant(kPoisson)};
    const Stiffness6 isotropic = isotropic_stiffness(law_of(one_material()));
    for (const Mat3d& axes : {Mat3d(Mat3d::Identity()), some_axes()})
        EXPECT_LT((orthotropic_stiffness(o, axes) - isotropic).norm(), 1e-13 * isotropic.norm());
}

TEST(Laws, AnOrthotropicLawHasTheStatedComplianceAndIsSymmetric) {
    // A stress along axis 1 alone strains it by sigma/E_1, and axes 2 and 3 by -nu_12 sigma/E_1 and -nu_31 sigma/E_3.
    const scene::Orthotropic o{
        .youngs_modulus = {4e5, 1e5, 2e5}, .shear_modulus = {6e4, 5e4, 9e4}, .poisson_ratio = {0.3, 0.2, 0.1}};
    const Stiffness6 c = orthotropic_stiffness(o, Mat3d::Identity());
    Eigen::Matrix<Real, 6, 1> strain = Eigen::Matrix<Real, 6, 1>::Zero();
    strain[0] = Real(1 / 4e5);
    strain[1] = Real(-0.3 / 4e5);
    strain[2] = Real(-0.1 / 2e5);
    const Eigen::Matrix<Real, 6, 1> stress = c * strain;
    EXPECT_NEAR(stress[0], 1, 1e-13);
    for (int k = 1; k < 6; ++k) EXPECT_NEAR(stress[k], 0, 1e-13);
    const Stiffness6 turned = orthotropic_stiffness(o, some_axes());
    EXPECT_LT((turned - turned.transpose()).norm(), 1e-13 * turned.norm());
    EXPECT_NEAR(c(3, 3), 6e4, 1e-13 * 6e4);
    EXPECT_NEAR(c(4, 4), 5e4, 1e-13 * 5e4);
    EXPECT_NEAR(c(5, 5), 9e4, 1e-13 * 9e4);
}

}  // namespace
}  // namespace thixo
