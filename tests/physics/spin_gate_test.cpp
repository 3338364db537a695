// What spins without torque keeps its angular momentum.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "tests/physics/gate.h"
#include "tests/sim/fixture.h"

namespace thixo {
namespace {

std::string name_of(std::string law, const std::vector<std::string>& set) {
    for (const std::string& key : set) law += ", " + key.substr(key.rfind('.') + 1);
    return law;
}

/// Spins a drop for five turns. The largest change of its angular momentum on the way is held to a thousandth.
void expect_kept(const std::vector<std::string>& set) {
    Simulation s = make_simulation(gate::load("spinning_drop", set));
    evaluate(s);
    const double before = fixture::angular_momentum(s.particles).z();
    double most = 0;
    while (s.clock.frame < s.problem.scene.frames.last) {
        advance_frame(s);
        most = std::max(most, std::abs(fixture::angular_momentum(s.particles).z() / before - 1));
    }
    gate::expect({name_of("spinning drop", set), "largest change of angular momentum in five turns", "1", most, 0, 1e-3,
                  "no torque"});
}

// Pressure, viscosity and tension are inner forces. Where viscosity has a torque, the drop of honey loses its spin. The
// drop of water gains some where tension or the density solve has one.
TEST(SpinningDrop, OfHoneyKeepsItsAngularMomentum) {
    expect_kept({"solver.spacing=0.02"});
    expect_kept({"solver.spacing=0.0125"});
    expect_kept({"solver.spacing=0.02", "solver.time_step.maximum=0.0005"});
    expect_kept({"solver.spacing=0.02", "solver.viscosity=implicit"});
}

TEST(SpinningDrop, OfWaterKeepsItsAngularMomentum) {
    const std::string thin = "materials.water.viscosity=0.001";
    expect_kept({thin, "solver.spacing=0.02"});
    expect_kept({thin, "solver.spacing=0.0125"});
    expect_kept({thin, "solver.spacing=0.02", "solver.time_step.maximum=0.0005"});
}

constexpr double kSurfaceEnergy = 200 * 4 * kPi * square(0.1);  // of a sphere [J]

double kinetic_energy(const Particles& p) {
    double sum = 0;
    for (std::size_t i = 0; i < p.size(); ++i)
        sum += 0.5 * static_cast<double>(p.mass[i] * p.velocity[i].squaredNorm());
    return sum;
}

const std::vector<std::vector<std::string>> kResolutions{
    {"solver.spacing=0.02"}, {"solver.spacing=0.0125"}, {"solver.spacing=0.02", "solver.time_step.maximum=0.0005"}};

TEST(SpinningDrop, OfWaterGainsNoEnergy) {
    for (std::vector<std::string> set : kResolutions) {
        const std::string law = name_of("spinning drop", set);
        set.emplace_back("materials.water.viscosity=0.001");
        Simulation s = make_simulation(gate::load("spinning_drop", set));
        evaluate(s);
        // Means over turns: the drop swells and shrinks, and its surface gives and takes meanwhile.
        constexpr int kTurn = 13;  // frames, 12.6 of them
        std::vector<double> kinetic;
        while (s.clock.frame < s.problem.scene.frames.last) {
            advance_frame(s);
            kinetic.push_back(kinetic_energy(s.particles));
        }
        const double settling = *std::ranges::max_element(kinetic) - kinetic.back();
        double least = 1e300, growth = 0;
        for (std::size_t f = 0; f + kTurn <= kinetic.size(); f += kTurn) {
            const double mean = std::accumulate(&kinetic[f], &kinetic[f] + kTurn, 0.0) / kTurn;
            if (f > 0) growth = std::max(growth, mean / least - 1);
            least = std::min(least, mean);
        }
        gate::expect({law, "largest growth of kinetic energy from one turn to a later one", "1", growth, 0, 0.01,
                      "nothing gives it energy"});
        gate::report(law, "energy of motion that the cut surface gives as it settles, over its own", "1",
                     settling / kSurfaceEnergy);
    }
}

TEST(DropAtRest, ComesToRest) {
    for (std::vector<std::string> set : kResolutions) {
        const std::string law = name_of("drop at rest", set);
        set.emplace_back("materials.water.viscosity=0.001");
        set.emplace_back("bodies.drop.angular_velocity=[0, 0, 0]");
        Simulation s = make_simulation(gate::load("spinning_drop", set));
        while (s.clock.frame < s.problem.scene.frames.last) advance_frame(s);
        gate::expect({law, "kinetic over surface energy after three seconds", "1",
                      kinetic_energy(s.particles) / kSurfaceEnergy, 0, 1e-3, "need: a thousandth is not seen"});
    }
}

}  // namespace
}  // namespace thixo
