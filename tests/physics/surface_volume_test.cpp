// The surface of a liquid encloses its volume, in a splash too.
#include <gtest/gtest.h>

#include <algorithm>

#include "pipeline/contract/scene_io.h"
#include "sim/loop/step.h"
#include "sim/space/walls.h"
#include "sim/stage/setup.h"
#include "sim/surface/volume.h"
#include "tests/physics/gate.h"
#include "tests/physics/pour_check.h"

namespace thixo {
namespace {

// The checks of the long film test, in the first splash of the first scene.
TEST(PourFrames, AreClosedAndStill) {
    Simulation s = make_simulation(scene::load_scene(THIXO_SOURCE_DIR "/configs/quickstart.yaml"));
    double pop = 0, pop99 = 0, rays = 0, holes = 0;
    std::size_t bridges = 0;
    gate::check_pour(s, 12, 20'000, [&](const gate::PourFrame& f) {
        pop = std::max(pop, f.pop);
        pop99 = std::max(pop99, f.pop99);
        rays += static_cast<double>(f.rays);
        holes += static_cast<double>(f.holes);
        bridges += f.bridges;
    });
    EXPECT_GT(rays, 0);
    gate::report("surface in a pour", "largest move when nothing has moved, in supports", "1", pop);
    gate::expect({"surface in a pour", "move of 99 surfels in 100 when nothing has moved, in supports", "1", pop99, 0,
                  0.1, "need: a move of a tenth of h is seen"});
    gate::expect({"surface in a pour", "rays from within that leave by a hole", "per million", 1e6 * holes / rays, 0,
                  20, gate::kBoundOnChange});
    EXPECT_EQ(bridges, 0u);
}

TEST(SurfaceVolume, IsTheParticlesThroughAPour) {
    // The jet of the first scene strikes the floor of the glass. It makes sheets and threads as thin as a particle,
    // then a pool.
    Simulation s = make_simulation(scene::load_scene(THIXO_SOURCE_DIR "/configs/quickstart.yaml"));
    refresh_surface(s);
    const Real radius = static_cast<Real>(s.problem.scene.surface.radius) * s.problem.smoothing.spacing;
    double most = 0, largest = 0;
    while (s.clock.frame <= 16) {
        advance_frame(s);
        double matter = 0;
        for (const Real v : s.particles.rest_volume) matter += static_cast<double>(v);
        const double ratio = surface_volume(s.surface, s.particles, s.walls, radius) / matter;
        most = std::max(most, std::abs(ratio - 1));
        for (const Real lift : s.surface.lift) largest = std::max(largest, static_cast<double>(std::abs(lift)));
    }
    gate::expect(
        {"surface in a pour", "largest error of the enclosed volume", "%", 100 * most, 0, 2, "need: two hundredths"});
    gate::report("surface in a pour", "largest shift for it, in spacings", "1",
                 largest / s.problem.scene.solver.spacing);
}

}  // namespace
}  // namespace thixo
