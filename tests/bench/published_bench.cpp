// Scenes of the dissertation with published times: whole films, of which no frame is written. The published times are
// those of a Pentium IV of 3 GHz (5.10 and table 6.1):
//     fig. 5.5    200 particles, 10k surfels              1/30 s a frame
//     fig. 5.24   2.7k particles, 465k surfels            2 s a frame
//     fig. 5.26   two bodies of 390 and 10k each          no time given
//     fig. 6.9    3.9k particles, 56k surfels             3.1 s a step, 20 s an iteration of the surface
// A published frame of chapter 5 is one step and one surface. `times` is its time over that of one step and one update
// here; the aim is 50 on one core. Steps are the leapfrog's sub-steps. The columns split a step into elasticity and
// contact, and an update into moving surfels and contact. They also give the seconds of a frame of film (1/24 s), with
// all its steps and its one update.
// For fig. 6.9 a step includes the forces of liquids and heat, and an update here makes up to six iterations. Its film
// runs for FRAMES frames. The lines below it split a step and an update into their parts.
//     published_bench [THREADS [FIGURE[:FRAMES]...]]      FIGURE: a file of configs/thesis without .yaml
#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "pipeline/base/parallel.h"
#include "pipeline/base/timer.h"
#include "pipeline/contract/scene_io.h"
#include "sim/loop/step.h"
#include "sim/stage/setup.h"
#include "sim/surface/contact_surface.h"

namespace {

using namespace thixo;

struct Figure {
    std::string file;
    double published = 0;         // [s]; 0: none
    double step = 0, update = 0;  // published apart [s]
};

/// Sums over a film [s].
struct Cost {
    double set_up = 0, physics = 0, contact = 0, surface = 0, displacing = 0, touching = 0;
    std::int64_t steps = 0, frames = 0, updates = 0;
};

/// Repeats the two parts of the last update.
void update_by_parts(Simulation& s, Cost& cost) {
    if (!s.solids.softening.any) {
        ScopedTimer timer(cost.displacing);
        displace_embedded(s.embedded, s.solids, s.surface, s.embedded_source);
    }
    ScopedTimer timer(cost.touching);
    draw_contacts(s.embedded, s.embedded_source, s.walls, s.solids, s.surface);
}

Simulation scene_of(const Figure& figure) {
    const std::string path = std::string(THIXO_SOURCE_DIR "/configs/thesis/") + figure.file + ".yaml";
    Simulation s = make_simulation(scene::load_scene(path));
    s.clock.frame = s.problem.scene.frames.first;
    evaluate(s);
    refresh_surface(s);
    s.stats = StepStats{};
    return s;
}

Cost film(Simulation& s, double set_up) {
    Cost cost;
    cost.set_up = set_up;
    const scene::Frames& frames = s.problem.scene.frames;
    while (s.clock.frame < frames.last) {
        advance_frame(s);
        update_by_parts(s, cost);
        ++cost.frames;
    }
    cost.physics = s.stats.solids_seconds + s.stats.integration_seconds;
    cost.contact = s.stats.contact_seconds;
    cost.surface = s.stats.surface_seconds;
    cost.steps = s.stats.solid_sub_steps;
    cost.updates = s.stats.surface_updates;
    return cost;
}

void measure(const Figure& figure) {
    const double begin = wall_seconds();
    Simulation s = scene_of(figure);
    const Cost c = film(s, wall_seconds() - begin);
    const double steps = static_cast<double>(c.steps), updates = static_cast<double>(c.updates);
    const double step = c.physics / steps, update = c.surface / updates;
    const double parts = static_cast<double>(c.frames);
    const std::string times =
        figure.published > 0 ? fmt::format("{:.0f}", figure.published / (step + update)) : std::string("-");
    fmt::print(
        "{:<18} {:>9} {:>8} {:>7.2f} | {:>7.3f} = {:>7.3f} + {:>6.3f} | {:>7.2f} = {:>7.2f} + {:>6.2f} | {:>6.1f} "
        "{:>8.4f} | {:>9} {:>6}\n",
        figure.file, s.particles.size(), s.surface.size(), c.set_up, 1e3 * step, 1e3 * (c.physics - c.contact) / steps,
        1e3 * c.contact / steps, 1e3 * update, 1e3 * c.displacing / parts, 1e3 * c.touching / parts, steps / parts,
        (c.physics + c.surface) / parts,
        figure.published > 0 ? fmt::format("{:.3f}", figure.published) : std::string("-"), times);
}

/// A film of melting matter, up to frame `last`.
void measure_melting(const Figure& figure, int last) {
    Simulation s = scene_of(figure);
    const scene::Frames& frames = s.problem.scene.frames;
    last = std::min(last, frames.last);
    const int first = s.clock.frame;
    const double begin = wall_seconds();
    double surfels = 0;
    while (s.clock.frame < last) {
        advance_frame(s);
        surfels += static_cast<double>(s.surface.size());
    }
    const double seconds = wall_seconds() - begin, parts = last - first;
    const StepStats& t = s.stats;
    const SurfaceSeconds& u = t.surface.seconds;
    const double melt = parallel_sum(s.particles.size(), [&](std::size_t i) { return double(s.particles.melt[i]); });
    const double steps = t.steps, updates = t.surface_updates;
    const double physics = (t.neighbours_seconds + t.density_seconds + t.forces_seconds + t.viscosity_seconds +
                            t.heat_seconds + t.pressure_seconds + t.solids_seconds + t.integration_seconds) /
                           steps;
    const double update = t.surface_seconds / updates;
    fmt::print("{}: frames {} to {}, {} particles ({:.0f} % molten at the end), {:.0f} surfels in the mean\n",
               figure.file, first, last, s.particles.size(), 100 * melt / static_cast<double>(s.particles.size()),
               surfels / parts);
    fmt::print("  a step    {:7.2f} ms, published {:.1f} s: {:.0f} times\n", 1e3 * physics, figure.step,
               figure.step / physics);
    const auto ms = [&](const char* name, double sum, double count) {
        fmt::print("{} {:.2f}  ", name, 1e3 * sum / count);
    };
    fmt::print("    ");
    ms("neighbours", t.neighbours_seconds, steps);
    ms("density", t.density_seconds, steps);
    ms("forces", t.forces_seconds, steps);
    ms("viscosity", t.viscosity_seconds, steps);
    ms("heat", t.heat_seconds, steps);
    ms("elastic", t.solids_seconds - t.contact_seconds, steps);
    ms("contact", t.contact_seconds, steps);
    ms("integration", t.integration_seconds, steps);
    fmt::print("\n  an update {:7.2f} ms, published {:.0f} s an iteration: {:.0f} times, by surfel {:.0f}\n",
               1e3 * update, figure.update, figure.update / update,
               figure.update / 56e3 / (update / (surfels / parts)));
    fmt::print("    ");
    ms("displacing", u.displacing, updates);
    ms("field", u.field, updates);
    ms("relaxing", u.relaxing, updates);
    ms("resampling", u.resampling, updates);
    ms("fitting", u.fitting, updates);
    ms("volume", u.volume, updates);
    ms("texture", u.texture, updates);
    fmt::print("\n  a frame of film {:.3f} s: {:.1f} steps, {:.2f} updates\n", seconds / parts, steps / parts,
               updates / parts);
}

}  // namespace

int main(int argc, char** argv) {
    const int threads = argc > 1 ? std::stoi(argv[1]) : 1;
    set_thread_count(threads);
    std::vector<Figure> figures = {{"fig_5_05_bust", 1.0 / 30}, {"fig_5_24_octopus", 2}, {"fig_5_26_collide", 0}};
    const Figure melting{.file = "fig_6_09_melting_bust", .step = 3.1, .update = 20};
    fmt::print("threads: {}\n{:<18} {:>9} {:>8} {:>7} | {:<26} | {:<26} | {:>6} {:>8} | {:>9} {:>6}\n", threads,
               "figure", "particles", "surfels", "set-up", "ms a step = elastic + contact",
               "ms an update = move + touch", "steps", "s/frame", "published", "times");
    const auto asked = [&](const std::string& file, int& last) {
        if (argc <= 2) return true;
        for (int i = 2; i < argc; ++i) {
            const std::string argument = argv[i];
            const std::size_t colon = argument.find(':');
            if (argument.substr(0, colon) != file) continue;
            if (colon != std::string::npos) last = std::stoi(argument.substr(colon + 1));
            return true;
        }
        return false;
    };
    int last = std::numeric_limits<int>::max();
    for (const Figure& figure : figures)
        if (asked(figure.file, last)) measure(figure);
    if (asked(melting.file, last)) measure_melting(melting, last);
}
