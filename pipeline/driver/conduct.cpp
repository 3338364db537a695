#include "pipeline/driver/conduct.h"

#include <fmt/format.h>
#include <sys/wait.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <optional>

#include "pipeline/base/error.h"
#include "pipeline/base/timer.h"
#include "pipeline/contract/cache.h"
#include "pipeline/driver/job.h"
#include "pipeline/driver/progress_board.h"

namespace thixo {
namespace {

void say(const std::string& text) { std::fwrite(text.data(), 1, text.size(), stderr); }

/// Starts stages, shows what they say, and knows which ended how.
class Conductor {
  public:
    Conductor(const Stages& stages, Display display) : stages_(stages), board_(display.terminal, display.quiet) {}

    int run() {
        sim_ = start(sim_call(stages_), {.out = false, .err = true});
        while (!sim_->status || (render_ && !render_->status)) {
            if (!render_ && cache_accepted_ && interrupted() == 0)
                render_ = start(render_call(stages_, true), {.out = false, .err = true});
            wait();
            if (sim_->status && !sim_ok_) sim_ended();
        }
        say(board_.interrupt());
        return outcome();
    }

  private:
    void wait() {
        std::vector<Process*> running;
        for (std::optional<Process>* p : {&sim_, &render_})
            if (*p && !(*p)->status) running.push_back(&**p);
        wait_a_moment(running, [&](Process& from, bool, const std::string& line) { heard(from, line); });
    }

    void heard(Process& from, const std::string& line) {
        if (const std::optional<ProgressReport> report = parse_progress(line)) {
            if (sim_ && &from == &*sim_) cache_accepted_ = true;
            say(board_.update(*report, wall_seconds()));
        } else {
            say(board_.interrupt() + line + "\n");
        }
    }

    void sim_ended() {
        sim_ok_ = WIFEXITED(*sim_->status) && WEXITSTATUS(*sim_->status) == kDone;
        if (*sim_ok_) cache_accepted_ = true;  // a finished cache may need no progress line
        // A follower would wait for frames that never come.
        if (!*sim_ok_ && render_ && !render_->status && !render_->told) {
            render_->told = true;
            tell(*render_, SIGTERM);
        }
        if (*sim_ok_ && !render_ && interrupted() == 0)
            render_ = start(render_call(stages_, false), {.out = false, .err = true});
    }

    int outcome() {
        if (const int number = interrupted()) throw InterruptedError(number);
        if (!*sim_ok_) {
            const bool render_failed = render_ && !render_->told;
            if (cache_accepted_ && !render_failed) render_what_is_there();
            return exit_code(*sim_);
        }
        return exit_code(*render_);
    }

    /// The frames asked for that a failed simulation did cache.
    void render_what_is_there() {
        std::string frames;
        try {
            const std::vector<int> wanted =
                stages_.render.frames.empty() ? std::vector<int>() : parse_frame_range(stages_.render.frames);
            for (const int n : CacheReader(stages_.sim.out).frames())
                if (wanted.empty() || std::binary_search(wanted.begin(), wanted.end(), n))
                    frames += fmt::format("{}{}", frames.empty() ? "" : ",", n);
        } catch (const Error&) {
            return;  // no readable cache: the simulation's own message says why
        }
        if (frames.empty()) return;
        Stages rest = stages_;
        rest.render.frames = frames;
        rest.render.restart = false;  // done by the follower
        render_ = start(render_call(rest, false), {.out = false, .err = true});
        while (!render_->status) wait();
        say(board_.interrupt());
        if (const int number = interrupted()) throw InterruptedError(number);
    }

    Stages stages_;
    ProgressBoard board_;
    std::optional<Process> sim_, render_;
    bool cache_accepted_ = false;
    std::optional<bool> sim_ok_;
};

}  // namespace

ProgramCall sim_call(const Stages& stages) {
    SimArgs args = stages.sim;
    args.machine_progress = true;
    return stage_call("thixo-sim", args.print());
}

ProgramCall render_call(const Stages& stages, bool follow) {
    RenderArgs args = stages.render;
    args.machine_progress = true;
    args.follow = follow;
    return stage_call("thixo-render", args.print());
}

int conduct(const Stages& stages, Display display) { return Conductor(stages, display).run(); }

}  // namespace thixo
