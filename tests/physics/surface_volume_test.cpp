// What is drawn of a liquid has its volume, in a splash too.
#include <gtest/gtest.h>

#include "pipeline/contract/scene_io.h"
#include "sim/setup.h"
#include "sim/step.h"
#include "sim/surface/volume.h"
#include "tests/physics/gate.h"

namespace thixo {
namespace {

TEST(SurfaceVolume, IsTheParticlesThroughAPour) {
    // The jet of the first scene strikes the floor of the glass: sheets and threads as thin as a particle, then a pool.
    Simulation s = make_simulation(scene::load_scene(THIXO_SOURCE_DIR "/configs/quickstart.yaml"));
    refresh_surface(s);
    const Real radius = static_cast<Real>(s.problem.scene.surface.radius) * s.problem.smoothing.spacing;
    double most = 0, largest = 0;
    while (s.clock.frame <= 16) {
        advance_frame(s);
        double matter = 0;
        for (const Real v : s.particles.rest_volume) matter += static_cast<double>(v);
        const double ratio = surface_volume(s.surface, s.particles, s.walls, radius) / matter;
        EXPECT_NEAR(ratio, 1, 0.02) << "frame " << s.clock.frame;
        most = std::max(most, std::abs(ratio - 1));
        for (const Real lift : s.surface.lift) largest = std::max(largest, static_cast<double>(std::abs(lift)));
    }
    gate::report("surface in a pour", "largest error of the enclosed volume", "%", 100 * most);
    gate::report("surface in a pour", "largest shift for it, in spacings", "1", largest / s.problem.scene.solver.spacing);
}

}  // namespace
}  // namespace thixo
