// The elastic scenes of the dissertation that have published counts, whole films without writing a frame: what a step
// of physics and an update of the surface cost, beside the figures of a Pentium IV of 3 GHz (5.10): fig. 5.5 (200
// particles, 10k surfels) in real time, 30 frames a second; fig. 5.24 (2.7k particles, 465k surfels) 2 s a frame. Of
// fig. 5.26 (two bodies of 390 particles and 10k surfels) no time is given. A published frame is one step and one
// surface, so `times published` is its time over that of a step and an update here; aim: 50 on one core. Steps are the
// leapfrog's sub-steps. Besides: milliseconds of a step by phase (elasticity and all else that moves the bodies;
// contact), of an update by phase (displacing surfels; contact between bodies and with walls), and seconds of a frame
// of film, 1/24 s, with its steps and its one update.
//   published_bench [THREADS [FIGURE...]]      FIGURE: a file of configs/thesis without .yaml
#include <fmt/core.h>

#include <string>
#include <vector>

#include "pipeline/base/parallel.h"
#include "pipeline/base/timer.h"
#include "pipeline/contract/scene_io.h"
#include "sim/setup.h"
#include "sim/solid/contact_surface.h"
#include "sim/step.h"

namespace {

using namespace thixo;

struct Figure {
    std::string file;
    double published = 0;  // [s]; 0: none
};

/// Sums over a film [s].
struct Cost {
    double set_up = 0, physics = 0, contact = 0, surface = 0, displacing = 0, touching = 0;
    std::int64_t steps = 0, frames = 0, updates = 0;
};

/// The two parts of the update that has just been made, once more.
void update_by_parts(Simulation& s, Cost& cost) {
    if (!s.solids.phases.any) {
        ScopedTimer timer(cost.displacing);
        displace_embedded(s.embedded, s.solids, s.surface, s.embedded_source);
    }
    ScopedTimer timer(cost.touching);
    draw_contacts(s.embedded, s.embedded_source, s.walls, s.solids, s.surface);
}

Cost film(Simulation& s, double set_up) {
    Cost cost;
    cost.set_up = set_up;
    const scene::Frames& frames = s.problem.scene.frames;
    s.clock.frame = frames.first;
    evaluate(s);
    refresh_surface(s);
    s.stats = StepStats{};
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
    const std::string path = std::string(THIXO_SOURCE_DIR "/configs/thesis/") + figure.file + ".yaml";
    Simulation s = make_simulation(scene::load_scene(path));
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

}  // namespace

int main(int argc, char** argv) {
    const int threads = argc > 1 ? std::stoi(argv[1]) : 1;
    set_thread_count(threads);
    std::vector<Figure> figures = {{"fig_5_05_bust", 1.0 / 30}, {"fig_5_24_octopus", 2}, {"fig_5_26_collide", 0}};
    fmt::print("threads: {}\n{:<18} {:>9} {:>8} {:>7} | {:<26} | {:<26} | {:>6} {:>8} | {:>9} {:>6}\n", threads,
               "figure", "particles", "surfels", "set-up", "ms a step = elastic + contact",
               "ms an update = move + touch", "steps", "s/frame", "published", "times");
    for (const Figure& figure : figures) {
        bool asked = argc <= 2;
        for (int i = 2; i < argc; ++i) asked |= figure.file == argv[i];
        if (asked) measure(figure);
    }
}
