// Solids that break: where, at what load, into what. Dissertation 5.6.
#include <gtest/gtest.h>

#include <set>
#include <tuple>

#include "pipeline/contract/scene_io.h"
#include "sim/fracture/crack_step.h"
#include "sim/fracture/painted.h"
#include "sim/fracture/sheets.h"
#include "sim/fracture/sight.h"
#include "sim/solid/elasticity.h"
#include "sim/solid/stable_step.h"
#include "sim/stage/frame_output.h"
#include "tests/sim/fracture/bars.h"
#include "tests/sim/identity.h"

namespace thixo {
namespace {

constexpr double kStrength = 8e3;  // Pa; the rubber has 1e5

/// A bar along x, 12 x 3 x 3 cm, whose ends are drawn apart at 5 cm/s each, with a band in the middle that is weaker.
scene::Scene bar_scene(scene::SolidSteps steps = scene::SolidSteps::leapfrog, double weakness = 0.8) {
    scene::Scene s = fixture::breakable_bar(kStrength);
    s.solver.solids = steps;
    s.materials[0].fracture.scores = {
        {.region = fixture::shape_at({0.01, 0, 0}, scene::BoxShape{{0.006, 1, 1}, 0}), .factor = weakness}};
    fixture::draw_ends_apart(s);
    return s;
}

using fixture::pull;

class Bars : public testing::TestWithParam<scene::SolidSteps> {};

TEST_P(Bars, PartWhereTheyAreWeakestAcrossThePull) {
    Simulation s = make_simulation(bar_scene(GetParam()));
    pull(s, 0.6);
    ASSERT_GE(s.solids.bodies.size(), 2u);
    // Across the pull, in the weak band: within two spacings of its plane.
    const Cracks& cracks = s.solids.cracks;
    ASSERT_FALSE(cracks.vertex.empty());
    const Vec3 origin = s.solids.bodies[0].origin;
    for (const Vec3& v : cracks.vertex) EXPECT_NEAR((v + origin).x(), 0.01, 2 * 0.006);
    // Two halves. Crumbs of an element, as rigid bodies of its four parts, may fall from between them.
    for (const SolidBody& body : s.solids.bodies)
        EXPECT_TRUE(body.size() > s.particles.size() / 4 || (body.rigid && body.size() == 4)) << body.size();
    EXPECT_LE(s.solids.bodies.size(), 4u);
    EXPECT_EQ(s.solids.bodies[1].parent, s.solids.bodies[0].id);
}

/// The mean tension in the middle of the bar when the first crack begins [Pa].
double load_at_the_first_crack(Simulation& s) {
    while (s.clock.time < 1 && !s.solids.cracks.any()) {
        s.clock.next_frame = s.clock.time + 1;
        step(s);
    }
    EXPECT_TRUE(s.solids.cracks.any());
    std::vector<Symmetric> stress;
    find_stress(s.solids, stress);
    double sum = 0, count = 0;
    for (Index i = 0; i < s.solids.elements.size(); ++i) {
        const Real x = s.solids.elements.rest[i].x;
        if (std::abs(x) > 0.025) continue;
        sum += largest_tension(stress[i]).value;
        ++count;
    }
    return sum / count;
}

TEST_P(Bars, AreAsStrongAsTheirMaterial) {
    double load[3], strain[3];
    const double strength[3] = {0.5 * kStrength, kStrength, 1.5 * kStrength};
    for (int k = 0; k < 3; ++k) {
        scene::Scene scene = bar_scene(GetParam(), 0.9);
        scene.materials[0].fracture.strength = strength[k];
        Simulation s = make_simulation(scene);
        load[k] = load_at_the_first_crack(s);
        strain[k] = s.clock.time;
    }
    // In proportion to the strength, to a twentieth: the issue of a load that is spread evenly.
    EXPECT_NEAR(load[0] / load[1], 0.5, 0.025);
    EXPECT_NEAR(load[2] / load[1], 1.5, 0.075);
    EXPECT_LT(strain[0], strain[1]);
    EXPECT_LT(strain[1], strain[2]);
}

TEST(Cracks, RunOnBesideRubberThatIsPoured) {
    // Emitted rubber has no rest shape, and is matter of no crack.
    scene::Scene scene = fixture::breakable_bar(kStrength);
    scene.bodies[0].cracks = {
        {.points = {{.at = {0, -0.015, 0.015}}, {.at = {0, 0.015, 0.015}}}, .image = {}, .depth = 0.01}};
    scene.materials.push_back(scene.materials[0]);
    scene.materials[1].name = "poured";
    scene.materials[1].fracture = {};
    scene::Emitter tap;
    tap.name = "tap";
    tap.material = "poured";
    tap.position = {0, 0, -0.5};
    tap.radius = 0.015;
    scene.emitters = {tap};
    Simulation s = make_simulation(scene);
    ASSERT_FALSE(s.solids.cracks.fronts.empty());
    const std::size_t bar = s.particles.size();
    fixture::steps(s, 40, 5e-4);
    EXPECT_GT(s.particles.size(), bar + 20) << "rubber is poured";
    EXPECT_FALSE(s.solids.cracks.fronts.empty());
    for (const CrackedMatter& matter : s.crack_scratch.matter) EXPECT_EQ(matter.elements().size(), bar);
}

TEST(Cracks, BeginAtALowerLoadInWarmMatter) {
    // The strength falls evenly to a half at 100 degC. The bounds are those of AreAsStrongAsTheirMaterial.
    double load[3];
    const double temperature[3] = {0, 60, 200};
    for (int k = 0; k < 3; ++k) {
        scene::Scene scene = bar_scene(scene::SolidSteps::leapfrog, 0.9);
        scene.materials[0].fracture.by_temperature = {{20, 1}, {100, 0.5}};
        scene.bodies[0].temperature = temperature[k];
        Simulation s = make_simulation(scene);
        load[k] = load_at_the_first_crack(s);
    }
    EXPECT_NEAR(load[1] / load[0], 0.75, 0.0375);
    EXPECT_NEAR(load[2] / load[0], 0.5, 0.025);
}

TEST(Cracks, BeginWhereMatterHasBecomeHot) {
    // Heat comes into one half of the bar while it is drawn: it parts there, though a band of the cold half is weaker.
    scene::Scene scene = bar_scene();
    scene.materials[0].fracture.by_temperature = {{20, 1}, {100, 0.3}};
    scene.materials[0].thermal.conductivity = 0.1;
    scene::HeatSource torch;
    torch.region = fixture::shape_at({-0.025, 0, 0}, scene::BoxShape{{0.012, 1, 1}, 0});
    torch.power = 3e9;
    scene.world.heat_sources = {torch};
    Simulation s = make_simulation(scene);
    pull(s, 0.6);
    ASSERT_GE(s.solids.bodies.size(), 2u);
    const Vec3 origin = s.solids.bodies[0].origin;
    double off = 0;
    for (const Vec3& v : s.solids.cracks.vertex) off = std::max(off, std::abs((v + origin).x() + 0.025));
    EXPECT_LT(off, 0.006 + 2 * 0.006);
}

TEST(Cracks, ThatLeaveStiffStencilsHaveTheRatesTakenAnew) {
    // A cut below the top layer of the bar, halfway to its middle: beside it stencils are left with bonds on one side. They are
    // stiffer than sub-steps of the rates of before can bear, which use 0.64 of the limit (stable_step.cpp).
    scene::Scene scene = fixture::breakable_bar(1e12);
    scene.materials[0].fracture.opacity = 0.3;
    Simulation s = make_simulation(scene);
    Solids& solids = s.solids;
    fixture::steps(s, 1, 1e-5);
    const double whole = solids.rates[0].stiffest;
    const Breaking& breaking = solids.breaking[0];
    const auto at = [&](Real y) -> Vec3 { return Vec3(Real(0.06), y, Real(0.009)) - breaking.origin; };
    paint_crack({at(Real(-0.015)), at(Real(0.015))}, {Real(0.05), 1}, breaking, solids);
    find_crossings(CrackedMatter(solids, breaking), solids.elements, 0, solids.cracks);
    fixture::steps(s, 1, 1e-6);  // its end weakens the bonds
    const Bonds& bonds = solids.elements.bonds;
    EXPECT_NE(bonds.version, solids.rates_version);
    EXPECT_EQ(bonds.weakened, 0u) << "it counts as a change that cracks make all the time";
    set_zero_energy(solids.laws, solids.elements);
    const double now = find_fastest_rates(solids.laws, solids.bodies, solids.elements)[0].stiffest;
    EXPECT_GT(now, whole / 0.64);
    fixture::steps(s, 1, 1e-6);
    EXPECT_NEAR(solids.rates[0].stiffest / now, 1, 1e-3);
}

TEST(Cracks, AreWatchedByABoundThatNoLoadExceeds) {
    // Loads are looked at a sub-step after the stretch that bounds them: they change by less than a fiftieth in it.
    Simulation s = make_simulation(bar_scene());
    int bounded = 0, looked = 0;
    while (s.clock.time < 1 && !s.solids.cracks.any()) {
        s.clock.next_frame = s.clock.time + 1;
        step(s);
        std::vector<Symmetric> stress;
        find_stress(s.solids, stress);
        double load = 0;
        for (Index i = 0; i < stress.size(); ++i)
            load =
                std::max(load, static_cast<double>(largest_tension(stress[i]).value / s.solids.elements.strength[i]));
        EXPECT_GE(load_now(s.solids), 0.98 * load) << s.clock.time;
        (load < static_cast<double>(kWatched) ? bounded : looked) += 1;
    }
    EXPECT_GT(bounded, 0);
    EXPECT_GT(looked, 0);
}

TEST(Cracks, SeeALoadThatComesAndGoesWithinAStep) {
    // A ball of 3 cm strikes the floor at 5 m/s and bounces within 10 ms, in the middle of a step of 42 ms. It breaks as
    // with steps of a fifth of a millisecond: at the same time, but for the sub-steps between two looks at the load.
    double begun[2];
    for (const double longest : {0.04, 2e-4}) {
        scene::Scene scene = fixture::rubber_scene(1);
        scene.solver.spacing = 0.006;
        scene.solver.time_step.maximum = longest;
        scene.materials[0].fracture.strength = kStrength;
        scene.world.boundaries = {fixture::floor_at(0)};
        scene.bodies = {fixture::body("ball", fixture::shape_at({0, 0, 0.06}, scene::Sphere{0.03}), {0, 0, -5})};
        Simulation s = make_simulation(scene);
        s.clock.next_frame = 1;
        while (s.clock.time < 0.05 && !s.solids.cracks.any()) step(s);
        ASSERT_TRUE(s.solids.cracks.any()) << longest;
        begun[longest < 1e-3 ? 1 : 0] = s.clock.time;
    }
    EXPECT_GT(begun[1], 0.03 / 5);
    // Eight sub-steps of some a sixth of the time in which a wave crosses a spacing, and a step of cracks.
    EXPECT_NEAR(begun[0], begun[1], 1e-3);
}

TEST(Cracks, OfAnImpactGiveNoEnergy) {
    // A plaster ball strikes the floor at 3 m/s. What breaks off under it has no more energy than the ball brought. An
    // element that hung on a few weak bonds would burst there.
    scene::Scene scene = fixture::rubber_scene(20);
    scene.world.gravity = {0, 0, 0};
    scene.solver.spacing = 0.008;
    scene.materials[0].density = 1200;
    scene.materials[0].elastic.youngs_modulus = 4e6;
    scene.materials[0].elastic.poisson_ratio = 0.2;
    scene.materials[0].elastic.volume_stiffness = 4e6;
    scene.materials[0].fracture.strength = 1e5;
    scene.world.boundaries = {fixture::floor_at(0)};
    scene.bodies = {fixture::body("ball", fixture::shape_at({0, 0, 0.062}, scene::Sphere{0.06}), {0, 0, -3})};
    scene.frames.fps = 240;
    Simulation s = make_simulation(scene);
    const auto kinetic = [&] {
        double sum = 0;
        for (std::size_t i = 0; i < s.particles.size(); ++i)
            sum += 0.5 * static_cast<double>(s.particles.mass[i] * s.particles.velocity[i].squaredNorm());
        return sum;
    };
    const double before = kinetic();
    for (int frame = 0; frame < 4; ++frame) {
        ASSERT_TRUE(advance_frame(s));
        EXPECT_LT(kinetic(), before) << "frame " << s.clock.frame;
    }
    EXPECT_GT(s.solids.cracks.cracks.size(), 3u);
}

TEST(Cracks, TellThatAFixedStepIsTooLongForThem) {
    // At its strength a crack may go a quarter of a width in a step; 20 m/s need some 70 us then.
    scene::Scene scene = bar_scene();
    scene.materials[0].fracture.speed = 20;
    for (const double fixed : {2e-3, 2e-5}) {
        scene.solver.time_step.fixed = fixed;
        Simulation s = make_simulation(scene);
        s.clock.next_frame = 1;
        while (s.clock.time < 0.6 && s.solids.cracks.step > 1e-3) step(s);
        ASSERT_LT(s.solids.cracks.step, 1e-3);
        step(s);
        EXPECT_EQ(s.stats.long_steps > 0, fixed > 1e-3);
        EXPECT_STREQ(s.stats.overstepped, fixed > 1e-3 ? "cracks" : "");
    }
}

TEST_P(Bars, KeepMassAndMomentumWhenTheyPart) {
    scene::Scene scene = bar_scene(GetParam());
    scene.handles.clear();
    scene.materials[0].fracture.strength = 1e13;
    Simulation s = make_simulation(scene);
    // Two halves that fly apart: the middle is torn with no force from outside.
    for (const Index i : s.solids.bodies[0].elements) {
        const Real v = s.solids.elements.rest[i].x > 0.01 ? Real(2) : Real(-1.4);
        s.solids.elements.velocity[i] = quad(Vec3(v, 0, 0));
        s.particles.velocity[s.solids.particle_of[i]] = Vec3(v, 0, 0);
    }
    for (Real& strength : s.solids.elements.strength) strength = kStrength / 4;
    const Vec3d momentum = fixture::momentum(s.particles), angular = fixture::angular_momentum(s.particles);
    double mass = 0;
    for (const Real m : s.particles.mass) mass += static_cast<double>(m);
    const double motion = fixture::motion(s.particles);
    pull(s, 0.3);
    ASSERT_GE(s.solids.bodies.size(), 2u);
    double after = 0;
    for (const Real m : s.particles.mass) after += static_cast<double>(m);
    EXPECT_EQ(after, mass);
    EXPECT_LT((fixture::momentum(s.particles) - momentum).norm(), 1e-5 * motion);
    // Velocities of leapfrog are those of half a step before, carried on. Implicit steps are solved to a tolerance.
    const double exact = 1e-4;
    EXPECT_LT((fixture::angular_momentum(s.particles) - angular).norm(), exact * motion * 0.12);
    EXPECT_TRUE(std::ranges::all_of(s.particles.position, [](const Vec3& x) { return x.allFinite(); }));
}

TEST_P(Bars, BreakAlikeAtAnyThreadCountAndAfterAResume) {
    scene::Scene scene = bar_scene(GetParam());
    scene.surface.enabled = true;
    scene.frames.fps = 60;
    fixture::expect_same_at_any_thread_count(scene, [](Simulation& s) { pull(s, 0.6); });
    // From a checkpoint with the crack half way through.
    Simulation s = make_simulation(scene);
    while (!s.solids.cracks.any()) ASSERT_TRUE(advance_frame(s));
    fixture::expect_resumes(s, 6);
    EXPECT_GE(s.solids.bodies.size(), 2u);
}

INSTANTIATE_TEST_SUITE_P(Steps, Bars, testing::Values(scene::SolidSteps::leapfrog, scene::SolidSteps::implicit_euler));

TEST(Cracks, ConductNoHeatAcross) {
    // The left half is hot. Whole, the bar warms its right half; parted, it does not: rounding of sums in single
    // precision, 1e-6 of what the whole one conducts.
    double heat[2];
    for (const bool parted : {false, true}) {
        scene::Scene scene = bar_scene();
        scene.materials[0].thermal.conductivity = 50;
        scene.materials[0].thermal.heat_capacity = 100;
        Simulation s = make_simulation(scene);
        if (parted) pull(s, 0.6);
        ASSERT_EQ(s.solids.bodies.size(), parted ? 2u : 1u);
        std::set<std::int64_t> right_half;  // by ids: pieces may part once more
        for (Index e = 0; e < s.solids.elements.size(); ++e)
            if (parted ? s.solids.elements.owner[e] != 0 : s.solids.elements.rest[e].x > 0)
                right_half.insert(s.solids.elements.id[e]);
        const auto right = [&](std::size_t i) { return right_half.contains(s.particles.id[i]); };
        for (std::size_t i = 0; i < s.particles.size(); ++i) s.particles.temperature[i] = right(i) ? 0 : 100;
        for (Index i = 0; i < s.solids.elements.size(); ++i) s.solids.elements.velocity[i] = quad(Vec3::Zero());
        s.clock.next_frame = s.clock.time + 1;
        const double start = s.clock.time;
        while (s.clock.time < start + 0.01) step(s);
        double sum = 0;
        for (std::size_t i = 0; i < s.particles.size(); ++i)
            if (right(i)) sum += static_cast<double>(s.particles.mass[i]) * s.particles.temperature[i];
        heat[parted ? 1 : 0] = std::abs(sum);
    }
    EXPECT_GT(heat[0], 0);
    EXPECT_LT(heat[1], 1e-6 * heat[0]);
}

TEST(Cracks, SurfelsBoundAsFrontsPassHaveTheWeightsOfThoseBoundAtOnce) {
    // A run that continues binds all at once. The discs are wide, so that they reach far across the notch and the crack.
    Simulation s = make_simulation(scene::load_scene(THIXO_SOURCE_DIR "/tests/faults/breaking.yaml"));
    for (int frame = 0; frame < 5; ++frame) {
        ASSERT_TRUE(advance_frame(s));
        EmbeddedSurface anew = s.embedded;
        const CrackSight sight(s.solids);
        bind_surfels(s.solids, std::vector<std::uint8_t>(s.solids.bodies.size(), 1), anew, element_sight(sight));
        ASSERT_TRUE(anew.begin == s.embedded.begin) << "frame " << s.clock.frame;
        for (std::size_t k = 0; k < anew.weight.size(); ++k) {
            const SurfelWeight &a = anew.weight[k], &b = s.embedded.weight[k];
            ASSERT_EQ(std::tie(a.at, a.along1, a.along2, a.element), std::tie(b.at, b.along1, b.along2, b.element))
                << "frame " << s.clock.frame << ", weight " << k;
        }
    }
    EXPECT_TRUE(s.solids.cracks.any());
}

TEST(Cracks, LoadsAndFrontsStandInTheFrame) {
    Simulation s = make_simulation(bar_scene());
    const auto loads = [&] { return make_frame(s, {}).particles.get<float>("load"); };
    evaluate(s);
    EXPECT_EQ(std::ranges::max(loads()), 0) << "before the first step nothing pulls";
    EXPECT_TRUE(make_frame(s, {}).fronts.empty());
    while (s.clock.time < 1 && !s.solids.cracks.any()) {
        s.clock.next_frame = s.clock.time + 1;
        step(s);
    }
    evaluate(s);
    const Frame frame = make_frame(s, {});
    // The crack began in this step, by a load of one strength.
    EXPECT_NEAR(std::ranges::max(frame.particles.get<float>("load")), 1, 0.1);
    EXPECT_GT(std::ranges::max(frame.particles.get<float>("von_mises")), 0.5 * kStrength);
    ASSERT_EQ(frame.fronts.size(), s.solids.cracks.fronts.size());
    ASSERT_FALSE(frame.fronts.empty());
    for (const FrameFront& front : frame.fronts)
        for (const auto& node : front.nodes) {
            // The ends are drawn apart: a node at 10 mm has gone on by as large a part of its half.
            const double drawn = 0.05 * s.clock.time;
            EXPECT_NEAR(node[0], 0.01 * (1 + drawn / 0.05), 2 * 0.006);
            EXPECT_LT(std::hypot(node[1], node[2]), 0.015 * std::sqrt(2.0) + 0.006);
        }
}

TEST(Cracks, FacesStandInTheFrameWithTheirTrimTrees) {
    scene::Scene scene = bar_scene();
    scene.surface.enabled = true;
    Simulation s = make_simulation(scene);
    pull(s, 0.6);
    ASSERT_GE(s.solids.bodies.size(), 2u);  // two halves; a crumb may fall from between them
    refresh_surface(s);
    evaluate(s);
    const Frame frame = make_frame(s, {});
    ASSERT_EQ(frame.bodies.size(), s.solids.bodies.size());
    std::vector<double> area(s.solids.bodies.size(), 0);
    double across = 0;  // surfels that look along the pull
    for (std::size_t i = 0; i < s.surface.size(); ++i) {
        if (s.embedded.sheet[s.embedded_source[i]] < kFirstCrackSheet) continue;
        area[static_cast<std::size_t>(s.surface.body[i])] += 1;
        across += std::abs(s.embedded.rest.normal[s.embedded_source[i]].x()) > Real(0.8) ? 1 : 0;
    }
    EXPECT_GT(across, 0.8 * (area[0] + area[1])) << "the faces stand across the pull, but where two cracks have met";
    for (int b = 0; b < 2; ++b) {
        EXPECT_GT(area[static_cast<std::size_t>(b)], 20) << "a face with surfels";
        ASSERT_TRUE(frame.bodies[static_cast<std::size_t>(b)].trim.has_value());
    }
    std::vector<std::int64_t> ids = s.surface.id;
    std::ranges::sort(ids);
    EXPECT_EQ(std::ranges::adjacent_find(ids), ids.end()) << "ids of surfels are unique";
}

}  // namespace
}  // namespace thixo
