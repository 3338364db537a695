// What is drawn of a liquid has its volume, in a splash too.
#include <gtest/gtest.h>

#include <algorithm>

#include "pipeline/contract/scene_io.h"
#include "pipeline/geometry/implicit_surface.h"
#include "sim/setup.h"
#include "sim/step.h"
#include "sim/surface/volume.h"
#include "sim/walls.h"
#include "tests/physics/gate.h"

namespace thixo {
namespace {

/// How far the old surfels in the room are from the surface of the new ones, at 99 of 100 less than this [m].
double moved(const SurfelCloud& old, const Simulation& s, Real support) {
    const SurfelCloud& now = s.surface.surfels;
    PointGrid grid;
    grid.build(now.position, support);
    const Poly6 w(support);
    std::vector<double> way;
    for (std::size_t i = 0; i < old.size(); ++i) {
        const Vec3& x = old.position[i];
        if (wall_distance(s.walls, x) < 0) continue;
        SurfelAverage average;
        grid.for_each_neighbour(x, support, [&](Index j, Real r2) {
            if (now.normal[j].dot(old.normal[i]) > Real(0.7))
                average.add(w.value(r2), now.position[j] - x, now.normal[j]);
        });
        if (average.defined()) way.push_back(static_cast<double>(std::abs(average.value())));
    }
    std::ranges::sort(way);
    return way[way.size() * 99 / 100];
}

// An update brings the surface to where the particles have it: another one, with nothing moved, finds little to do.
TEST(SurfacePops, AreSmallInASplash) {
    Simulation s = make_simulation(scene::load_scene(THIXO_SOURCE_DIR "/configs/quickstart.yaml"));
    refresh_surface(s);
    const scene::Surface& surface = s.problem.scene.surface;
    const Real support = static_cast<Real>(surface.radius * surface.support) * s.problem.smoothing.spacing;
    double most = 0;
    while (s.clock.frame <= 8) {
        advance_frame(s);
        if (s.clock.frame < 4) continue;  // until then there is but a short jet
        const SurfelCloud before = s.surface.surfels;
        refresh_surface(s);
        most = std::max(most, moved(before, s, support) / s.problem.smoothing.support);
    }
    gate::report("surface in a pour", "move of 99 surfels in 100 when nothing has moved, in supports", "1", most);
    EXPECT_LT(most, 0.12);
}

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
    gate::report("surface in a pour", "largest shift for it, in spacings", "1",
                 largest / s.problem.scene.solver.spacing);
}

}  // namespace
}  // namespace thixo
