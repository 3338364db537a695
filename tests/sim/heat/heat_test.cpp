#include "sim/heat/heat.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "tests/sim/fixture.h"
#include "tests/sim/heat/heat_of.h"

namespace thixo {
namespace {

scene::Scene block(const Vec3d& size) {
    scene::Scene scene = fixture::empty_space();
    scene.solver.expected_speed = 0.01;
    scene.materials[0].thermal.conductivity = 100;
    scene.materials[0].thermal.heat_capacity = 1000;
    scene.bodies = {fixture::body("block", fixture::shape_at({0, 0, 0}, scene::BoxShape{size, 0}))};
    return scene;
}

TEST(Heat, EnthalpyAndTemperatureAreInverse) {
    scene::Thermal ice;
    ice.heat_capacity = 2000;
    ice.latent_heat = 334000;
    ice.solidus = -1;
    ice.liquidus = 1;
    for (double t = -20; t <= 20; t += 0.37) EXPECT_NEAR(temperature_of(enthalpy(t, ice), ice), t, 1e-12);
    EXPECT_DOUBLE_EQ(enthalpy(1, ice) - enthalpy(-1, ice), 334000 + 2 * 2000);
    ice.latent_heat = 0;
    for (double t = -20; t <= 20; t += 0.37) EXPECT_NEAR(temperature_of(enthalpy(t, ice), ice), t, 1e-12);
}

TEST(Heat, OfAnInsulatedBodyIsConserved) {
    // Temperatures are random, there are two materials and latent heat, and particles move. The tolerance is the
    // rounding of single-precision sums, 1e-6 of sum C |T - mean|.
    scene::Scene scene = block({0.1, 0.1, 0.1});
    scene.materials[0].thermal.latent_heat = 20000;
    scene.materials[0].thermal.solidus = 20;
    scene.materials[0].thermal.liquidus = 40;
    scene::Material other = scene.materials[0];
    other.name = "oil";
    other.density = 800;
    other.thermal.conductivity = 10;
    scene.materials.push_back(other);
    scene.bodies.push_back(
        fixture::body("oil", fixture::shape_at({0.11, 0, 0}, scene::BoxShape{{0.1, 0.1, 0.1}, 0}), {-0.3, 0, 0}));
    scene.bodies[1].material = "oil";
    Simulation s = make_simulation(scene);
    double mean = 0, spread = 0;
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        s.particles.temperature[i] = 100 * random_unit(3, i, 0, 0);
        mean += s.particles.temperature[i] / static_cast<double>(s.particles.size());
    }
    for (std::size_t i = 0; i < s.particles.size(); ++i)
        spread += 1000 * static_cast<double>(s.particles.mass[i]) * std::abs(s.particles.temperature[i] - mean);
    const double before = fixture::heat_of(s);
    fixture::steps(s, 200, 1e-3);
    double least = 1e30, most = -1e30;
    for (const double t : s.particles.temperature) least = std::min(least, t), most = std::max(most, t);
    EXPECT_LT(std::abs(fixture::heat_of(s) - before), 1e-6 * spread);
    EXPECT_GE(least, 0);  // no new extremes
    EXPECT_LE(most, 100);
    EXPECT_GT(least, 1);  // and it did flow
}

TEST(Heat, ASourceGivesItsPower) {
    scene::Scene scene = block({0.1, 0.1, 0.1});
    scene::HeatSource source;
    source.name = "lamp";
    source.region = fixture::shape_at({0, 0, 0}, scene::Sphere{1});
    source.power = 5e6;
    source.from = 0.05;
    source.to = 0.15;
    scene.world.heat_sources = {source};
    Simulation s = make_simulation(scene);
    const double before = fixture::heat_of(s);
    fixture::steps(s, 200, 1e-3);
    const double volume = static_cast<double>(s.particles.size()) * 1e-6;
    EXPECT_NEAR(fixture::heat_of(s) - before, 5e6 * volume * 0.1,
                0.015 * 5e6 * volume * 0.1);  // to a step of 1 ms at each end
}

TEST(Heat, AGaussianPulseSpreads) {
    // In a block that is wide enough, a pulse spreads as in free space:
    //     (t0/(t + t0))^(3/2) exp(-r^2/(4 a (t + t0)))
    // It begins with a width of 1.7 supports, because the kernel smooths narrower ones. 2 % of the peak everywhere.
    constexpr double a = 1e-4, start = 6, later = 9;  // m^2/s, s
    scene::Scene scene = block({0.3, 0.3, 0.3});
    Simulation s = make_simulation(scene);
    const auto exact = [&](double r2, double t) { return std::pow(start / t, 1.5) * std::exp(-r2 / (4 * a * t)); };
    for (std::size_t i = 0; i < s.particles.size(); ++i)
        s.particles.temperature[i] = exact(static_cast<double>(s.particles.position[i].squaredNorm()), start);
    fixture::steps(s, 100, (later - start) / 100);
    double worst = 0;
    for (std::size_t i = 0; i < s.particles.size(); ++i)
        worst = std::max(worst, std::abs(s.particles.temperature[i] -
                                         exact(static_cast<double>(s.particles.position[i].squaredNorm()), later)));
    EXPECT_LT(worst, 0.02 * exact(0, later));
}

TEST(Heat, WithoutConductivityNothingChanges) {
    scene::Scene scene = block({0.1, 0.1, 0.1});
    scene.materials[0].thermal.conductivity = 0;
    scene.bodies[0].temperature = 77;
    Simulation s = make_simulation(scene);
    fixture::steps(s, 5, 1e-3);
    for (const double t : s.particles.temperature) EXPECT_EQ(t, 77);
    EXPECT_EQ(s.stats.heat_steps, 0);
}

TEST(Heat, BelowAbsoluteZeroOrBeyondReasonARunStops) {
    scene::Scene scene = block({0.06, 0.06, 0.06});
    scene::HeatSource source;
    source.region = fixture::shape_at({0, 0, 0}, scene::BoxShape{{1, 1, 1}, 0});
    source.power = -1e11;
    scene.world.heat_sources = {source};
    Simulation s = make_simulation(scene);
    std::string said;
    try {
        while (s.clock.frame < 50) advance_frame(s);
    } catch (const DivergedError& e) {
        said = e.what();
    }
    EXPECT_NE(said.find("temperature of particle"), std::string::npos) << said;
    EXPECT_NE(said.find("heat source"), std::string::npos) << said;

    scene.materials[0].thermal.conductivity = 1e9;
    scene.materials[0].thermal.heat_capacity = 1e-3;
    Simulation fast = make_simulation(scene);
    try {
        advance_frame(fast);
        ADD_FAILURE() << "heat spread";
    } catch (const InputError& e) {
        EXPECT_NE(std::string(e.what()).find("materials." + fast.problem.scene.materials[0].name), std::string::npos);
    }
}

}  // namespace
}  // namespace thixo
