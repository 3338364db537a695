// What spins without torque keeps its angular momentum.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/physics/gate.h"
#include "tests/sim/fixture.h"

namespace thixo {
namespace {

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
    std::string law = "spinning drop";
    for (const std::string& key : set) law += ", " + key.substr(key.rfind('.') + 1);
    gate::expect({law, "largest change of angular momentum in five turns", "1", most, 0, 1e-3, "no torque"});
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

}  // namespace
}  // namespace thixo
