// What is drawn of a body while it melts: a closed surface around its matter.
#include <gtest/gtest.h>

#include <algorithm>

#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"
#include "pipeline/geometry/point_grid.h"
#include "sim/loop/step.h"
#include "sim/stage/setup.h"
#include "sim/surface/volume.h"
#include "tests/physics/gate.h"
#include "tests/physics/pour_check.h"
#include "tests/physics/tracers.h"
#include "tests/sim/surface/discs.h"

namespace thixo {
namespace {

/// Particles with no surfel nearer than a spacing.
std::vector<Vec3> deep_places(const Simulation& s) {
    const Real spacing = s.problem.smoothing.spacing;
    PointGrid grid;
    grid.build(s.surface.surfels.position, spacing);
    std::vector<Vec3> deep;
    for (const Vec3& x : s.particles.position) {
        bool near = false;
        grid.for_each_neighbour(x, spacing, [&](Index, Real) { near = true; });
        if (!near) deep.push_back(x);
    }
    return deep;
}

/// Share of rays from deep inside that leave unseen.
double holes(const Simulation& s, std::size_t rays) {
    const std::vector<Vec3> from = deep_places(s);
    if (from.empty()) return 0;
    const fixture::Discs discs(s.surface.surfels, fixture::widest(s.surface.surfels));
    const auto frame = static_cast<std::uint64_t>(s.clock.frame);
    return parallel_sum(rays,
                        [&](std::size_t k) {
                            const Vec3& x = from[random_bits(7, k, frame, 2) % from.size()];
                            return discs.hit(x, fixture::random_direction(k + frame * rays), 1) ? 0.0 : 1.0;
                        }) /
           static_cast<double>(rays);
}

/// The surface that the solids of a scene would show if none had begun to melt, up to their edges.
SurfelCloud solid_surface(const Simulation& s) {
    Solids solids = s.solids;
    SurfaceState shown;
    std::vector<Index> source;
    displace_embedded(s.embedded, solids, shown, source);
    SurfelCloud cloud;
    for (std::size_t i = 0; i < source.size(); ++i) {
        if (s.embedded.beyond[source[i]]) continue;
        cloud.position.push_back(shown.surfels.position[i]);
        cloud.axis1.push_back(shown.surfels.axis1[i]);
        cloud.axis2.push_back(shown.surfels.axis2[i]);
        cloud.normal.push_back(shown.surfels.normal[i]);
    }
    return cloud;
}

/// How far from the matter a disc's rim reaches at most: from the particle nearest to it, in spacings.
double standing_out(const Simulation& s) {
    constexpr int kAngles = 16;
    const Real spacing = s.problem.smoothing.spacing, reach = 4 * spacing;
    PointGrid grid;
    grid.build(s.particles.position, reach);
    const SurfelCloud& cloud = s.surface.surfels;
    std::vector<double> farthest(cloud.size());
    parallel_for(cloud.size(), [&](std::size_t i) {
        for (int k = 0; k < kAngles; ++k) {
            const Real angle = 2 * static_cast<Real>(kPi) * static_cast<Real>(k) / kAngles;
            const Vec3 x = cloud.position[i] + std::cos(angle) * cloud.axis1[i] + std::sin(angle) * cloud.axis2[i];
            Real least = square(reach);
            grid.for_each_neighbour(x, reach, [&](Index, Real r2) { least = std::min(least, r2); });
            farthest[i] = std::max(farthest[i], static_cast<double>(std::sqrt(least) / spacing));
        }
    });
    return std::ranges::max(farthest);
}

/// Share of the particles that are liquid.
double molten(const Simulation& s) {
    const auto liquid = std::ranges::count_if(s.particles.melt, [](Real b) { return b >= 1; });
    return static_cast<double>(liquid) / static_cast<double>(s.particles.size());
}

/// How far what is painted on the body is from its matter, in parts of the body's size.
struct Paint {
    double median = 0, most = 0;       // of 9 surfels in 10
    double own = 0;                    // the median error of the measure itself
    double off_body = 0, covered = 0;  // 99 of 100 places that are painted are as near the body's first surface
};
Paint paint_of(const gate::Tracers::Errors& e, double size) {
    const auto part = [&](const std::vector<double>& v, std::size_t percent) {
        return v.empty() ? 1 : v[v.size() * percent / 100] / size;
    };
    return {part(e.painted, 50), part(e.painted, 90), part(e.own, 50), part(e.off_body, 99), e.covered};
}
void report_paint(const std::string& scene, const std::string& when, const Paint& paint) {
    const auto say = [&](const char* what, double part) { gate::report(scene, what + (", " + when), "%", 100 * part); };
    say("texture from its matter, median, of the body's size", paint.median);
    say("texture from its matter, 9 surfels in 10", paint.most);
    say("the same of tracers by each other", paint.own);
    say("texture off the body, 99 surfels in 100", paint.off_body);
    say("surfels among tracers", paint.covered);
}

struct Drawn {
    double volume_error = 0, holes = 0;
    double pop = 0, pop99 = 0;                 // see gate::moves_when_frozen, the largest of all frames [h]
    double taken_over = 0, taken_over_99 = 0;  // moves as the animated surface takes over from the solid's [h]
    double standing_out = 0;                   // in the first ten frames, see standing_out [spacings]
    Paint half, end;
};
void note_moves(const std::vector<Real>& moves, double& most, double& most99) {
    most = std::max(most, static_cast<double>(moves.back()));
    most99 = std::max(most99, static_cast<double>(moves[moves.size() * 99 / 100]));
}
/// `body_size`: the body's breadth [m].
Drawn melt(const std::string& scene, double body_size) {
    Simulation s = make_simulation(gate::load(scene));
    refresh_surface(s);
    const Real radius = static_cast<Real>(s.problem.scene.surface.radius) * s.problem.smoothing.spacing;
    gate::Tracers tracers(s);
    Drawn drawn;
    gate::Tracers::Errors paint;
    int frames = 0;
    while (s.clock.frame < s.problem.scene.frames.last) {
        advance_frame(s, [&] {
            tracers.follow(s);
            return false;
        });
        // Before, its sheets reach past the edges, and are trimmed when they are drawn.
        if (s.mixed_surface.animated.size() == 0) continue;
        const double volume = surface_volume(s.surface, s.particles, s.walls, radius);
        const double matter =
            parallel_sum(s.particles.size(), [&](std::size_t j) { return matter_volume(s.particles, j); });
        drawn.volume_error = std::max(drawn.volume_error, std::abs(volume / matter - 1));
        if (frames < 10) drawn.standing_out = std::max(drawn.standing_out, standing_out(s));
        if (frames == 0)
            note_moves(gate::moves_between(s, solid_surface(s), s.surface.surfels), drawn.taken_over,
                       drawn.taken_over_99);
        note_moves(gate::moves_when_frozen(s), drawn.pop, drawn.pop99);
        drawn.holes += holes(s, 40000);
        if (paint.painted.empty() && molten(s) >= 0.5) paint = tracers.errors(s);
        ++frames;
    }
    drawn.holes /= frames;
    gate::report(scene, "melted", "%", 100 * molten(s));
    drawn.half = paint_of(paint, body_size);
    drawn.end = paint_of(tracers.errors(s), body_size);
    report_paint(scene, "half of it melted", drawn.half);
    report_paint(scene, "at the end", drawn.end);
    gate::report(scene, "largest error of the surface's volume", "%", 100 * drawn.volume_error);
    gate::report(scene, "rays from within that leave by a hole", "per million", 1e6 * drawn.holes);
    gate::report(scene, "largest move when nothing has moved, in supports", "1", drawn.pop);
    gate::report(scene, "move of 99 surfels in 100 when nothing has moved, in supports", "1", drawn.pop99);
    gate::report(scene, "a disc's rim from the nearest particle, first frames", "spacings", drawn.standing_out);
    gate::report(scene, "largest move as the solid's surface is taken over, in supports", "1", drawn.taken_over);
    gate::report(scene, "move of 99 surfels in 100 as it is taken over, in supports", "1", drawn.taken_over_99);
    return drawn;
}

// A line painted on the body stays on its matter to 1 % of the body: so does half of what the tracers can tell in a
// melt of half of it, and to the end.
void expect_paint_keeps(const Drawn& drawn) {
    EXPECT_LT(drawn.half.median, 0.005);
    EXPECT_LT(drawn.half.most, 0.04);  // the farthest lie on the plate
    EXPECT_LT(drawn.half.own, 0.0025);
    EXPECT_GT(drawn.half.covered, 0.6);
    EXPECT_LT(drawn.end.median, 0.01);
    // A fit continued past the zombies without bound paints places a third of the body away from it.
    EXPECT_LT(drawn.half.off_body, 0.06);
    EXPECT_LT(drawn.end.off_body, 0.06);
}

// A move of a tenth of a support h is seen as a pop.
void expect_no_pops(const Drawn& drawn, double taken_over) {
    EXPECT_LT(drawn.pop, 0.105);
    EXPECT_LT(drawn.pop99, 0.06);
    EXPECT_LT(drawn.taken_over, taken_over);
    EXPECT_LT(drawn.taken_over_99, 0.05);
}

// Where faces meet in edges that melt, and at the foot of the body, discs that end nowhere stood out as fins, up
// to 1.54 spacings from all matter.
void expect_no_fins(const Drawn& drawn) { EXPECT_LT(drawn.standing_out, 1.36); }

TEST(MeltingSurface, OfABallIsClosedAndHoldsItsVolume) {
    const Drawn drawn = melt("melting_ball", 0.2);
    EXPECT_LT(drawn.volume_error, 0.02);
    EXPECT_LT(drawn.holes, 1e-6);
    expect_paint_keeps(drawn);
    expect_no_pops(drawn, 0.03);
    expect_no_fins(drawn);
}

// Where faces meet in an edge discs are cut short, and what was trimmed there is drawn back onto its face.
TEST(MeltingSurface, OfABoxIsClosedAndHoldsItsVolume) {
    const Drawn drawn = melt("melting_box", 0.16);
    EXPECT_LT(drawn.volume_error, 0.02);
    EXPECT_LT(drawn.holes, 1e-6);
    expect_paint_keeps(drawn);
    expect_no_pops(drawn, 0.12);  // a few new surfels in the box's foot
    expect_no_fins(drawn);
}

}  // namespace
}  // namespace thixo
