// Solids in contact, beside the laws of impact and of rest.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "tests/physics/gate.h"
#include "tests/sim/solid/blocks.h"

namespace thixo {
namespace {

/// Sums over the particles of each body.
struct Motion {
    double mass = 0;
    Vec3d momentum{0, 0, 0}, angular{0, 0, 0}, centre{0, 0, 0};
    double kinetic = 0;
};
std::vector<Motion> motions(const Simulation& s) {
    std::vector<Motion> all(s.problem.scene.bodies.size());
    const Particles& p = s.particles;
    for (std::size_t i = 0; i < p.size(); ++i) {
        Motion& m = all[static_cast<std::size_t>(p.body[i])];
        const double mass = static_cast<double>(p.mass[i]);
        const Vec3d x = p.position[i].cast<double>(), v = p.velocity[i].cast<double>();
        m.mass += mass;
        m.momentum += mass * v;
        m.angular += mass * x.cross(v);
        m.centre += mass * x;
        m.kinetic += mass * v.squaredNorm() / 2;
    }
    for (Motion& m : all) m.centre /= m.mass;
    return all;
}

TEST(TwoFreeBodies, KeepTheirMomentaInACollision) {
    // Velocities are rounded to 6e-8 at each of some hundred sub-steps. 1e-5 leaves room, and shows any force without
    // its opposite. The bodies slide and turn on each other, so that friction takes part. Both forces of a contact node
    // act at one place when it is found. The places move apart with the sliding until nodes are found again: at most by
    // a quarter of a particle's width, 3 mm. That is 5 % of the arm, in a tenth of the collision.
    Simulation s = make_simulation(gate::load("collision"));
    evaluate(s);
    const std::vector<Motion> before = motions(s);
    while (s.clock.frame < s.problem.scene.frames.last) advance_frame(s);
    const std::vector<Motion> after = motions(s);
    const double size = before[0].momentum.norm() + before[1].momentum.norm();
    const double arm = 0.05;
    gate::expect({"collision", "momentum lost over sum p", "1",
                  (after[0].momentum + after[1].momentum - before[0].momentum - before[1].momentum).norm() / size, 0,
                  1e-5, "Newton's third law"});
    gate::expect({"collision", "angular momentum lost over sum p r", "1",
                  (after[0].angular + after[1].angular - before[0].angular - before[1].angular).norm() / (size * arm),
                  0, 5e-3, "forces at one place"});
    EXPECT_GT((after[0].momentum - before[0].momentum).norm(), 0.5 * before[0].momentum.norm());
    EXPECT_LT(after[0].kinetic + after[1].kinetic, before[0].kinetic + before[1].kinetic);
}

TEST(NewtonsCradle, LastSphereTakesTheMomentum) {
    Simulation s = make_simulation(gate::load("cradle"));
    evaluate(s);
    const double given = motions(s)[0].momentum.x();
    while (s.clock.frame < s.problem.scene.frames.last) advance_frame(s);
    const std::vector<Motion> end = motions(s);
    double middle = 0;
    for (std::size_t b = 1; b < 4; ++b) middle = std::max(middle, end[b].momentum.norm() / given);
    gate::expect({"cradle", "momentum of the last sphere over that given", "1", end[4].momentum.x() / given, 1, 0.1,
                  "elastic impact"});
    gate::expect(
        {"cradle", "largest momentum of a middle sphere over that given", "1", middle, 0, 0.05, "elastic impact"});
}

TEST(StackedBlocks, ComeToRest) {
    Simulation s = make_simulation(gate::load("stacked"));
    const gate::Series series = gate::run(s);
    const auto energy = series.of("energy"), lower = series.of("lower"), upper = series.of("upper"), x = series.of("x");
    const double most = *std::max_element(energy.begin(), energy.end());
    gate::expect(
        {"stacked blocks", "kinetic energy at the end over its largest", "1", energy.back() / most, 0, 1e-4, "rest"});
    // It still vibrates a little. The means over half seconds show how far it creeps.
    const auto mean = [&](std::size_t from) {
        return std::accumulate(x.end() - static_cast<std::ptrdiff_t>(from),
                               x.end() - static_cast<std::ptrdiff_t>(from - 12), 0.0) /
               12;
    };
    gate::expect({"stacked blocks", "creep along the lower one in half a second", "m", mean(12) - mean(24), 0, 1e-5,
                  "friction holds"});
    // The blocks are compressed by the weight above them and by the springs of the contact, as if the upper weight were
    // spread evenly. The tolerance is a tenth of a spacing.
    gate::expect({"stacked blocks", "distance of the middles", "m", upper.back() - lower.back(), 0.06, 1e-3,
                  "a tenth of a spacing"});
}

TEST(BlockOnASolidSlope, SlidesWithWhatFrictionLeaves) {
    // Coefficients of 0.45 and 0.2: their geometric mean is 0.3.
    Simulation s = make_simulation(gate::load("slide_on_solid"));
    const gate::Series series = gate::run(s);
    const double measured = series.rate("speed", 4);  // after it has settled under its own weight
    const double law = 4.905 - 0.3 * 8.4957;
    gate::expect({"block on a solid slope", "acceleration", "m/s^2", measured, law, 0.03 * law, "Coulomb"});
}

TEST(BlockOnASolidSlope, SticksBelowTheAngleOfFriction) {
    // tan 30 degrees = 0.577. The block lands from a tenth of a millimetre and is then at rest. In a third of a second
    // it creeps by no more than places are rounded to, 1e-8 m. Friction without memory would let it creep at 20 mm/s.
    // As it lands it slides: by Coulomb's law 1.4 mm from the 25 mm/s that it has gained.
    Simulation s = make_simulation(gate::load(
        "slide_on_solid", {"materials.upper.friction=0.6", "materials.lower.friction=0.6", "frames.last=20"}));
    const gate::Series series = gate::run(s);
    const auto way = series.of("way");
    gate::expect({"block on a solid slope, steeper friction", "creep in the last third of a second", "m",
                  way.back() - way[12], 0, 1e-6, "Coulomb"});
    EXPECT_LT(way[12] - way[0], 0.002);
}

TEST(BlockOnASolidSlope, SlidesAndSticksInImplicitStepsToo) {
    Simulation slides = make_simulation(gate::load("slide_on_solid", {"solver.solids=implicit"}));
    const double law = 4.905 - 0.3 * 8.4957;
    gate::expect({"block on a solid slope, implicit", "acceleration", "m/s^2", gate::run(slides).rate("speed", 4), law,
                  0.03 * law, "Coulomb"});
    Simulation sticks =
        make_simulation(gate::load("slide_on_solid", {"solver.solids=implicit", "materials.upper.friction=0.6",
                                                      "materials.lower.friction=0.6", "frames.last=20"}));
    const auto way = gate::run(sticks).of("way");
    gate::expect({"block on a solid slope, implicit, steeper friction", "creep in the last third of a second", "m",
                  way.back() - way[12], 0, 1e-6, "Coulomb"});
}

TEST(TwoFreeBodies, KeepTheirMomentumInImplicitSteps) {
    Simulation s = make_simulation(gate::load("collision", {"solver.solids=implicit"}));
    evaluate(s);
    const std::vector<Motion> before = motions(s);
    while (s.clock.frame < s.problem.scene.frames.last) advance_frame(s);
    const std::vector<Motion> after = motions(s);
    const double size = before[0].momentum.norm() + before[1].momentum.norm();
    gate::expect({"collision, implicit", "momentum lost over sum p", "1",
                  (after[0].momentum + after[1].momentum - before[0].momentum - before[1].momentum).norm() / size, 0,
                  1e-5, "Newton's third law"});
    EXPECT_GT((after[0].momentum - before[0].momentum).norm(), 0.5 * before[0].momentum.norm());
    EXPECT_LT(after[0].kinetic + after[1].kinetic, before[0].kinetic + before[1].kinetic);
}

TEST(AFastBall, DoesNotPassThroughAPlate) {
    Simulation s = make_simulation(gate::load("shot"));
    evaluate(s);
    const std::vector<Motion> before = motions(s);
    while (s.clock.frame < s.problem.scene.frames.last) advance_frame(s);
    const std::vector<Motion> after = motions(s);
    // The ball is not accelerated: there is no more energy than before. It is still on its side of the plate under it.
    double kinetic = 0;
    for (const Motion& m : after) kinetic += m.kinetic;
    EXPECT_LE(kinetic, before[1].kinetic);
    double lowest = 1e9, plate = -1e9;
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        const Vec3& x = s.particles.position[i];
        if (s.particles.body[i] == 1)
            lowest = std::min(lowest, static_cast<double>(x.z()));
        else if (std::hypot(x.x(), x.y()) < 0.01)
            plate = std::max(plate, static_cast<double>(x.z()));
    }
    EXPECT_GT(after[1].centre.z(), plate);
    EXPECT_GT(after[1].momentum.z() - after[0].momentum.z() * after[1].mass / after[0].mass,
              before[1].momentum.z() * 0.6);
    gate::report("shot", "ball's speed after", "m/s", after[1].momentum.z() / after[1].mass);
}

TEST(AFastBall, GivesBackWhatPressesIt) {
    // Without friction and damping contact keeps energy. Its springs give back the energy that they take, even if the
    // matter around them has become softer or stiffer meanwhile. Half of the energy is strain. Leapfrog's velocities
    // are half a step behind, which leaves a hundredth.
    Simulation s =
        make_simulation(gate::load("shot", {"materials.plate.friction=0", "materials.ball.friction=0",
                                            "materials.plate.contact_damping=0", "materials.ball.contact_damping=0"}));
    evaluate(s);
    const auto energy = [&] {
        double sum = 0;
        for (const Motion& m : motions(s)) sum += m.kinetic;
        return s.solids.laws.empty() ? sum
                                     : sum + static_cast<double>(fixture::energy(s.solids.laws, s.solids.elements));
    };
    const double before = energy();
    while (s.clock.frame < s.problem.scene.frames.last) advance_frame(s);
    EXPECT_EQ(s.solids.contacts.nodes.size(), 0u);  // they have separated
    gate::expect({"shot, without friction and damping", "energy after over that before", "1", energy() / before, 1,
                  0.02, "contact is elastic"});
}

}  // namespace
}  // namespace thixo
