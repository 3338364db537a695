// Runs a small splash for six frames and prints figures that float and double runs must agree on. Not a test itself:
// precision_test compares.
#include <fmt/core.h>

#include "tests/sim/fixture.h"

int main() {
    using namespace thixo;
    scene::Scene scene = fixture::tank({0.12, 0.12, 0.2}, 0.05, 0.01);
    scene.bodies.push_back(fixture::body("drop", fixture::shape_at({0, 0, 0.12}, scene::Sphere{0.02})));
    Simulation s = make_simulation(scene);
    for (int k = 0; k < 3; ++k) advance_frame(s);
    Vec3d centre(0, 0, 0);
    double mass = 0, kinetic = 0;
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        const double m = s.particles.mass[i];
        mass += m;
        centre += m * s.particles.position[i].cast<double>();
        kinetic += 0.5 * m * static_cast<double>(s.particles.velocity[i].squaredNorm());
    }
    centre /= mass;
    fmt::print("{} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g}\n", s.particles.size(), mass, centre.x(), centre.y(), centre.z(),
               kinetic);
}
