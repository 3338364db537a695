// What spins without torque keeps its angular momentum.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

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

struct Energies {
    double kinetic, surface;  // [J]
};

Energies energies_of(Simulation& s) {
    const std::vector<Vec3> kept = s.particles.acceleration;
    add_tension(s.particles, {s.neighbours, s.walls, s.problem.smoothing, s.sweep}, s.problem.tension,
                s.problem.materials, s.tension);
    s.particles.acceleration = kept;
    double kinetic = 0;
    for (std::size_t i = 0; i < s.particles.size(); ++i)
        kinetic += 0.5 * static_cast<double>(s.particles.mass[i] * s.particles.velocity[i].squaredNorm());
    return {kinetic, tension_energy(s.tension, s.particles.size())};
}

const std::vector<std::vector<std::string>> kResolutions{
    {"solver.spacing=0.02"}, {"solver.spacing=0.0125"}, {"solver.spacing=0.02", "solver.time_step.maximum=0.0005"}};

TEST(SpinningDrop, OfWaterGainsNoEnergy) {
    for (std::vector<std::string> set : kResolutions) {
        const std::string law = name_of("spinning drop", set);
        set.emplace_back("materials.water.viscosity=0.001");
        Simulation s = make_simulation(gate::load("spinning_drop", set));
        evaluate(s);
        double least = 1e300, growth = 0;
        while (s.clock.frame < s.problem.scene.frames.last) {
            const Energies e = energies_of(s);
            least = std::min(least, e.kinetic + e.surface);
            growth = std::max(growth, (e.kinetic + e.surface) / least - 1);
            advance_frame(s);
        }
        gate::expect({law, "largest growth of kinetic and surface energy in five turns", "1", growth, 0, 0.01,
                      "nothing gives it energy"});
    }
}

TEST(DropAtRest, ComesToRest) {
    for (std::vector<std::string> set : kResolutions) {
        const std::string law = name_of("drop at rest", set);
        set.emplace_back("materials.water.viscosity=0.001");
        set.emplace_back("bodies.drop.angular_velocity=[0, 0, 0]");
        Simulation s = make_simulation(gate::load("spinning_drop", set));
        while (s.clock.frame < s.problem.scene.frames.last) advance_frame(s);
        const Energies e = energies_of(s);
        gate::expect({law, "kinetic over surface energy after three seconds", "1", e.kinetic / e.surface, 0, 1e-3,
                      "need: a thousandth is not seen"});
    }
}

}  // namespace
}  // namespace thixo
