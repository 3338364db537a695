#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/contract/check_args.h"
#include "pipeline/contract/stage_args.h"
#include "pipeline/driver/command.h"
#include "pipeline/driver/film.h"

namespace thixo {
namespace {

constexpr const char* kHelp = R"(Usage: thixo VERB ... [OPTION...]      thixo VERB --help lists a verb's options
  run SCENE                    simulate, render, encode: what is not there yet
  sim SCENE                    the cache only; continues by itself
  render SCENE-or-CACHE        the frames only
  relight SCENE-or-CACHE       the frames under lights of other strengths and colours, without a ray where they have light groups
  film SCENE-or-CACHE          a film of the frames, with another exposure, view, rate or codec
  preview SCENE-or-CACHE       quick pictures of particles or surfels; of a scene its first instant
  check A --against B          compare two frame folders or two caches
  validate SCENE               all problems of a scene at once; particles, memory and disk it will need
  info PATH                    what a scene, a cache or a frame holds
  export CACHE                 frames for other tools: ply, vtp, csv
  verify SCENE-or-CACHE        every file of an output folder against its checksum; --repair makes what is damaged again
The launcher ./thixo adds: setup (install packages), test [--all] (build and run the tests), --no-build.
SCENE is a YAML file; what it names lies in its folder or below, or in a folder that THIXO_FILES lists (DIR:DIR:...).
CACHE is an output folder or its cache/. Output goes to ./out/<scene>, a draft's to ./out/<scene>.draft.
Exit codes: 0 done; 1 a check found a difference; 2 bad usage or input; 3 the simulation diverged; 4 a cache is missing or damaged;
5 out of memory or disk; 6 with --strict, a run could not do all that its scene says; 130 and 143 interrupted, the state is saved.
)";

/// Adds options to a verb by name, each written once for all verbs that have it.
class Verb {
  public:
    Verb(CLI::App& app, const char* name, const char* what, const char* path, const char* path_what) {
        sub_ = app.add_subcommand(name, what);
        sub_->set_help_flag("--help,-h", "print this");
        sub_->add_option(path, command.path, path_what)->required()->type_name("");
    }
    Verb& frames() {
        sub_->add_option("--frames", command.frames, "frames such as 7, 1-100, 1-100x2 or 1,3,5-9; all when left out")
            ->type_name("RANGE");
        return *this;
    }
    Verb& out(const char* what = "output folder; ./out/<scene> when left out") {
        sub_->add_option("--out", command.out, what)->type_name("DIR");
        return *this;
    }
    Verb& scene() {  // what changes a scene as it is read
        sub_->add_option("--set", command.set, "changes a key of the scene; may be repeated")
            ->type_name("KEY.PATH=VALUE")
            ->expected(1)
            ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
            ->allow_extra_args(false);
        sub_->add_flag("--draft", command.draft, "half the particles per axis, half the resolution, few samples");
        return *this;
    }
    Verb& seed() {
        add_seed(*sub_, command.seed);
        return *this;
    }
    Verb& threads() {
        add_threads(*sub_, command.threads);
        return *this;
    }
    Verb& quiet() {
        sub_->add_flag("--quiet", command.quiet, "warnings and errors only");
        return *this;
    }
    Verb& json(const char* what = "the result as JSON") {
        sub_->add_flag("--json", command.json, what);
        return *this;
    }
    Verb& dry_run() {
        sub_->add_flag("--dry-run", command.dry_run, "print the commands, start none");
        return *this;
    }
    Verb& restart(const char* what) {
        sub_->add_flag("--restart", command.restart, what);
        return *this;
    }
    Verb& text(const char* name, std::string& value, const char* what, bool required = false) {
        sub_->add_option(name, value, what)->required(required);
        return *this;
    }
    Verb& number(const char* name, double& value, NumberRange range, const char* what) {
        add_number(*sub_, name, value, range, what);
        return *this;
    }
    Verb& choice(const char* name, std::string& value, const char* what, std::vector<std::string> choices,
                 bool required = false) {
        sub_->add_option(name, value, what)->check(CLI::IsMember(std::move(choices)))->required(required);
        return *this;
    }
    /// A whole number from 1 that stands for a key of the scene.
    Verb& count_key(const char* name, const char* key, const char* what) {
        sub_->add_option_function<int>(
                name, [this, key](int n) { command.set.push_back(fmt::format("{}={}", key, n)); }, what)
            ->check(CLI::PositiveNumber)
            ->type_name("N");
        return *this;
    }
    Verb& strict() {
        sub_->add_flag("--strict", command.strict, "exit 6 where a run cannot do all that its scene says");
        return *this;
    }
    Verb& flag(const char* name, bool& value, const char* what) {
        sub_->add_flag(name, value, what);
        return *this;
    }
    CLI::App& app() { return *sub_; }

    Command command;

  private:
    CLI::App* sub_;
};

using Verbs = std::vector<std::unique_ptr<Verb>>;  // by pointer: CLI11 keeps addresses of the members

Verb& add(Verbs& verbs, CLI::App& app, const char* name, const char* what, const char* path, const char* path_what) {
    verbs.push_back(std::make_unique<Verb>(app, name, what, path, path_what));
    return *verbs.back();
}

Verbs all_verbs(CLI::App& app) {
    constexpr const char* kScene = "scene file";
    constexpr const char* kEither = "scene file, output folder or its cache/";
    constexpr const char* kLook = "look file, laid over the scene's look; its frames go to frames.<look>/";
    Verbs verbs;
    Verb& run = add(verbs, app, "run", "Simulates, renders and encodes what is not there yet.", "SCENE", kScene);
    run.text("--look", run.command.look, kLook).restart("start the simulation and the frames over");
    run.flag("--verify", run.command.verify, "at the end check every file of the output folder");
    run.strict().frames().scene().seed().out().threads().quiet().json().dry_run();

    Verb& sim = add(verbs, app, "sim", "Simulates a scene into a cache; goes on where it stopped.", "SCENE", kScene);
    sim.strict()
        .restart("discard the cache that is there")
        .frames()
        .scene()
        .seed()
        .out()
        .threads()
        .quiet()
        .json()
        .dry_run();

    Verb& render =
        add(verbs, app, "render", "Renders the frames of a cache that are not there yet.", "SCENE-or-CACHE", kEither);
    render.text("--look", render.command.look, kLook).restart("replace frames made with another look");
    render.text("--crop", render.command.crop,
                "x,y,width,height: this part of the picture alone, in pixels from the top left");
    render.count_key("--width", "look.output.width", "sets look.output.width")
        .count_key("--height", "look.output.height", "sets look.output.height")
        .count_key("--samples", "look.output.samples", "sets look.output.samples");
    render.frames()
        .scene()
        .seed()
        .out(
            "the scene's output folder; of a cache the folder for frames/. ./out/<scene> or beside the cache when left "
            "out")
        .threads()
        .quiet()
        .json()
        .dry_run();

    Verb& relight =
        add(verbs, app, "relight", "Mixes the light groups of frames anew; renders where that is not enough.",
            "SCENE-or-CACHE", kEither);
    relight.text("--look", relight.command.look, kLook).restart("replace frames made with another look");
    relight.frames()
        .scene()
        .seed()
        .out("the scene's output folder; of a cache the folder for frames.relit/")
        .threads()
        .quiet()
        .json()
        .dry_run();

    Verb& film =
        add(verbs, app, "film", "Encodes the frames; with --set first makes them under that look, as relight does.",
            "SCENE-or-CACHE", kEither);
    film.text("--look", film.command.look, "look file whose frames.<look>/ are shown")
        .restart("replace frames made with another look");
    film.number("--fps", film.command.fps, {0, 1e6}, "frames a second; 0: the scene's");
    film.choice("--codec", film.command.codec, "h264 (when left out), h265 or prores", kCodecs);
    film.frames()
        .scene()
        .out("the scene's output folder; of a cache the folder of frames/ and the film")
        .threads()
        .quiet()
        .json();

    Verb& preview = add(verbs, app, "preview", "Quick pictures of a cache, or of a scene's first instant.",
                        "SCENE-or-CACHE", kEither);
    preview.choice("--what", preview.command.what, "particles, surfels or auto", {"auto", "particles", "surfels"});
    preview.text("--attribute", preview.command.attribute, "colour by this attribute, for example v or density");
    preview.frames()
        .scene()
        .seed()
        .out("the scene's output folder; ./out/<scene> when left out")
        .threads()
        .quiet()
        .json()
        .dry_run();

    Verb& check = add(verbs, app, "check", "Compares two frame folders or two caches; exit 1 where they differ.", "A",
                      "frame folder or cache");
    check.text("--against", check.command.against, "the reference: a frame folder or cache", true);
    check.flag("--update", check.command.update, "make A the reference");
    check.text("--diff", check.command.diff, "folder for a picture of every difference");
    check.number("--max-rel-mse", check.command.max_rel_mse, kRelMse,
                 "largest relative mean square error of a picture's channel; 0: equal bit for bit");
    check.choice("--tier", check.command.tier,
                 "of pictures: exact; passes, those alone that carry no noise; noise, colours up to their noise",
                 kCheckTiers);
    check.number("--max-flip", check.command.max_flip, kFlip, "largest mean FLIP of a picture; 0: no limit")
        .number("--max-flicker", check.command.max_flicker, kRelMse,
                "largest change between frames that the reference has not; 0: no limit");
    check.text("--junit", check.command.junit, "file for a report in JUnit's XML")
        .text("--html", check.command.html, "folder for a sheet of all pictures that differ");
    check.frames().threads().quiet().json().dry_run();

    Verb& validate =
        add(verbs, app, "validate", "Names all problems of a scene at once, else what it will need.", "SCENE", kScene);
    validate.flag("--print", validate.command.print, "print the scene with every default written out");
    validate.strict().scene().seed().json();

    Verb& info = add(verbs, app, "info", "Tells what a scene, a cache, a frame or a picture holds.", "PATH",
                     "scene file, output folder, cache file or picture");
    info.json();

    Verb& exporting =
        add(verbs, app, "export", "Writes frames of a cache for other tools.", "CACHE", "output folder or its cache/");
    exporting.choice("--to", exporting.command.to, "ply, vtp or csv", {"ply", "vtp", "csv"}, true);
    exporting.choice("--what", exporting.command.what, "particles (when left out) or surfels",
                     {"particles", "surfels"});
    exporting.frames().out("folder for the files; <CACHE>/export when left out").quiet().json();

    Verb& verify = add(verbs, app, "verify", "Checks every file of an output folder: cache, checkpoints, frames, film.",
                       "SCENE-or-CACHE", kEither);
    verify.flag("--repair", verify.command.repair, "make again what is damaged, to the same bytes");
    verify.scene().seed().out("the scene's output folder; ./out/<scene> when left out").threads().quiet().json();
    return verbs;
}

/// What no option and no path can be.
void require_words(const CLI::Option& option, const Command& command) {
    for (const std::string& word : option.results()) {
        if (word.empty()) throw InputError("{}: {} is empty", command.verb, option.get_name());
        if (command.json && !is_utf8(word))
            throw InputError("{}: {} is not UTF-8, which --json needs; leave out --json or use another name",
                             command.verb, option.get_name());
    }
}

}  // namespace

Command parse_command(int argc, char** argv) {
    CLI::App app("", "thixo");
    app.set_help_flag("");
    const Verbs verbs = all_verbs(app);
    app.require_subcommand(1);

    std::vector<std::string> words(argv + 1, argv + argc);
    Command none;
    if (words.empty())
        throw InputError("no verb given; thixo --help lists them, thixo run configs/quickstart.yaml is a start");
    if (words[0] == "--help" || words[0] == "-h" || words[0] == "help") none.text = kHelp;
    if (words[0] == "--version") none.text = "thixo " THIXO_VERSION "\n";
    if (!none.text.empty()) return none;

    const auto chosen =
        std::find_if(verbs.begin(), verbs.end(), [&](const auto& v) { return v->app().get_name() == words[0]; });
    if (chosen == verbs.end()) throw InputError("there is no verb '{}'; thixo --help lists them", words[0]);
    Verb& verb = **chosen;
    verb.command.verb = words[0];
    try {
        std::reverse(words.begin(), words.end());  // CLI11 takes words from the back
        app.parse(std::move(words));
    } catch (const CLI::CallForHelp&) {
        verb.command.text = verb.app().help("thixo");
    } catch (const CLI::ParseError& e) {
        throw InputError("{}: {}; thixo {} --help lists the options", verb.command.verb, e.what(), verb.command.verb);
    }
    for (const CLI::Option* option : verb.app().get_options()) require_words(*option, verb.command);
    if (!verb.command.frames.empty())
        parse_frame_range(verb.command.frames);  // for its message, before anything starts
    return verb.command;
}

}  // namespace thixo
