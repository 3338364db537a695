#include "pipeline/contract/stage_args.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>

#include "pipeline/base/error.h"
#include "pipeline/contract/argument_words.h"

namespace thixo {
namespace {

constexpr int kLargestFrame = 999999;

[[noreturn]] void bad_range(const std::string& text, std::string_view part, const char* why) {
    throw InputError("frame range '{}': '{}' {}; write for example 1-100, 1-100x2, 7 or 1,3,5-9", text, part, why);
}

int frame_number(const std::string& text, std::string_view digits, std::string_view part) {
    int number = 0;
    const auto [end, failure] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (digits.empty() || failure == std::errc::invalid_argument || end != digits.data() + digits.size() ||
        digits[0] == '-')
        bad_range(text, part, "is no frame number");
    if (failure == std::errc::result_out_of_range || number > kLargestFrame)
        bad_range(text, part, "is above 999999, the last frame there can be");
    return number;
}

void add_frames(const std::string& text, std::string_view part, std::vector<int>& frames) {
    std::string_view rest = part;
    int step = 1;
    const std::size_t dash = rest.find('-');
    if (const std::size_t x = rest.find('x'); x != std::string_view::npos) {
        if (dash == std::string_view::npos || dash > x) bad_range(text, part, "has a step but no range");
        step = frame_number(text, rest.substr(x + 1), part);
        if (step == 0) bad_range(text, part, "has a step of 0");
        rest = rest.substr(0, x);
    }
    const int first = frame_number(text, rest.substr(0, dash), part);
    const int last = dash == std::string_view::npos ? first : frame_number(text, rest.substr(dash + 1), part);
    if (last < first) bad_range(text, part, "ends before it starts");
    for (int frame = first; frame <= last; frame += step) frames.push_back(frame);
}

std::vector<std::string> print_common(const CommonArgs& a) {
    std::vector<std::string> words;
    put_text(words, "out", a.out);
    put_text(words, "frames", a.frames);
    for (const std::string& setting : a.set) put(words, "set", setting);
    if (a.threads != 0) put(words, "threads", std::to_string(a.threads));
    if (a.seed) put(words, "seed", std::to_string(*a.seed));
    put_if(words, "draft", a.draft);
    put_if(words, "quiet", a.quiet);
    put_if(words, "machine-progress", a.machine_progress);
    return words;
}

void add_common(CLI::App& app, CommonArgs& a) {
    app.add_option("--out", a.out, "output folder: holds cache/, frames/ and checkpoint/")->required();
    app.add_option("--frames", a.frames, "frames, for example 1-100x2; all of the scene when left out");
    // One value a time: by default CLI11 would take every following word as a further value.
    app.add_option_function<std::string>(
           "--set", [&a](const std::string& setting) { a.set.push_back(setting); },
           "key.path=value, changes a key of the scene; may be repeated")
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
        ->trigger_on_parse();
    add_threads(app, a.threads);
    add_seed(app, a.seed);
    app.add_flag("--draft", a.draft, "half the particles per axis, half the resolution, few samples");
    app.add_flag("--quiet", a.quiet, "warnings and errors only");
    app.add_flag("--machine-progress", a.machine_progress, "progress lines for the driver");
}

}  // namespace

std::vector<int> parse_frame_range(const std::string& text) {
    std::vector<int> frames;
    std::string_view rest = text;
    for (bool more = true; more;) {
        const std::size_t comma = rest.find(',');
        add_frames(text, rest.substr(0, comma), frames);
        if (frames.size() > 4 * kLargestFrame) bad_range(text, text, "names too many frames");
        more = comma != std::string_view::npos;
        if (more) rest = rest.substr(comma + 1);
    }
    std::sort(frames.begin(), frames.end());
    frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
    return frames;
}

std::vector<std::string> SimArgs::print() const {
    std::vector<std::string> words = print_common(*this);
    put_if(words, "restart", restart);
    put_if(words, "estimate", estimate);
    put_if(words, "initial", initial);
    put_path(words, scene);
    return words;
}

SimArgs SimArgs::parse(const std::vector<std::string>& args) {
    SimArgs a;
    CLI::App app("Simulates a scene and writes a cache.", "thixo-sim");
    add_common(app, a);
    app.add_flag("--restart", a.restart, "discard an existing cache");
    app.add_flag("--estimate", a.estimate, "print estimated particles, memory and disk as JSON; simulate nothing");
    app.add_flag("--initial", a.initial, "write the first frame only, no checkpoint");
    app.add_option("scene", a.scene, "scene file")->required();
    a.help = parse_words(app, args);
    return a;
}

Crop parse_crop(const std::string& text) {
    std::array<int, 4> numbers{};
    std::string_view rest = text;
    for (std::size_t k = 0; k < numbers.size(); ++k) {
        const auto [end, failure] = std::from_chars(rest.data(), rest.data() + rest.size(), numbers[k]);
        const bool last = k + 1 == numbers.size(), ends = end == rest.data() + rest.size();
        if (failure != std::errc() || numbers[k] < (k < 2 ? 0 : 1) || ends != last || (!last && *end != ','))
            throw InputError("--crop '{}' is no part of a picture; write x,y,width,height, for example 0,0,320,180",
                             text);
        if (!last) rest.remove_prefix(std::size_t(end - rest.data()) + 1);
    }
    return {numbers[0], numbers[1], numbers[2], numbers[3]};
}

std::vector<std::string> RenderArgs::print() const {
    std::vector<std::string> words = print_common(*this);
    put_text(words, "look", look);
    put_text(words, "pictures", pictures);
    put_text(words, "crop", crop);
    put_if(words, "follow", follow);
    put_if(words, "restart", restart);
    put_if(words, "relight", relight);
    put_if(words, "preview", preview);
    if (what != "auto") put(words, "what", what);
    put_text(words, "attribute", attribute);
    put_path(words, scene);
    return words;
}

RenderArgs RenderArgs::parse(const std::vector<std::string>& args) {
    RenderArgs a;
    CLI::App app("Renders the frames of a cache.", "thixo-render");
    add_common(app, a);
    app.add_option("--look", a.look, "look file, laid over the scene's look");
    app.add_option("--pictures", a.pictures, "folder for the frames; the output folder when left out");
    app.add_option("--crop", a.crop, "x,y,width,height: this part of the picture alone, in pixels");
    app.add_flag("--follow", a.follow, "wait for frames that a running simulation still makes");
    app.add_flag("--restart", a.restart, "replace frames made with another look");
    app.add_flag("--relight", a.relight, "mix the light groups of frames that are there, where that is enough");
    app.add_flag("--preview", a.preview, "quick pictures instead of ray tracing");
    app.add_option("--what", a.what, "preview: particles, surfels or auto")
        ->check(CLI::IsMember({"particles", "surfels", "auto"}));
    app.add_option("--attribute", a.attribute, "preview: colour by this attribute");
    app.add_option("scene", a.scene,
                   "scene whose look replaces the cache's; the look stored in the cache when left out");
    a.help = parse_words(app, args);
    if (!a.crop.empty()) parse_crop(a.crop);
    return a;
}

}  // namespace thixo
