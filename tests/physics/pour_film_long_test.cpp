// The surface of a film: fig. 6.10 from the first drop until the glass is still, 240 frames, a million rays in each.
#include <fmt/core.h>
#include <gtest/gtest.h>

#include "pipeline/contract/scene_io.h"
#include "sim/stage/setup.h"
#include "tests/physics/gate.h"
#include "tests/physics/pour_check.h"

namespace thixo {
namespace {

TEST(PourFilm, IsClosedHoldsItsVolumeAndDoesNotPop) {
    Simulation s =
        make_simulation(scene::load_scene(THIXO_SOURCE_DIR "/configs/thesis/fig_6_10_pour.yaml", {"frames.last=241"}));
    fmt::print("{:>5} {:>9} {:>8} {:>6} {:>7} {:>8} {:>8} {:>7} {:>8}\n", "frame", "particles", "surfels", "holes",
               "volume", "pop [h]", "99% [h]", "pieces", "bridges");
    double holes = 0, rays = 0, volume = 0, pop = 0, pop99 = 0;
    std::size_t bridges = 0;
    gate::check_pour(s, 241, 1'000'000, [&](const gate::PourFrame& f) {
        fmt::print("{:5} {:9} {:8} {:6} {:7.4f} {:8.3f} {:8.3f} {:7} {:8}\n", f.frame, f.particles, f.surfels, f.holes,
                   f.volume, f.pop, f.pop99, f.pieces, f.bridges);
        holes += static_cast<double>(f.holes);
        rays += static_cast<double>(f.rays);
        // The first drops of the jet are too few to have a volume to two per cent.
        if (f.particles > 500) volume = std::max(volume, std::abs(f.volume - 1));
        pop = std::max(pop, f.pop);
        pop99 = std::max(pop99, f.pop99);
        bridges += f.bridges;
    });
    const auto at_most = [](const char* what, const char* unit, double measured, double bound, const char* source) {
        gate::expect({"film of a pour", what, unit, measured, 0, bound, source});
    };
    // The need is no hole in a million rays of any frame. A ray or two of all 240 frames may meet one.
    at_most("rays from within that leave by a hole", "per million", 1e6 * holes / rays, 0.02,
            "need: none in a million of a frame");
    at_most("largest error of the enclosed volume", "%", 100 * volume, 2, "need: two hundredths");
    at_most("largest move when nothing has moved, in supports", "1", pop, 0.1, "need: a move of a tenth of h is seen");
    at_most("largest move of 99 surfels in 100, in supports", "1", pop99, 0.05, gate::kBoundOnChange);
    at_most("surface pieces about liquid that does not touch", "1", static_cast<double>(bridges), 0, "need: none");
}

}  // namespace
}  // namespace thixo
