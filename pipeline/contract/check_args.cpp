#include "pipeline/contract/check_args.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "pipeline/base/error.h"
#include "pipeline/contract/argument_words.h"

namespace thixo {

std::vector<std::string> CheckArgs::print() const {
    std::vector<std::string> words;
    put(words, "against", against);
    put_text(words, "frames", frames);
    if (max_rel_mse != 0) put(words, "max-rel-mse", fmt::format("{}", max_rel_mse));
    if (tier != kCheckTiers.front()) put(words, "tier", tier);
    if (max_flip != 0) put(words, "max-flip", fmt::format("{}", max_flip));
    if (max_flicker != 0) put(words, "max-flicker", fmt::format("{}", max_flicker));
    put_text(words, "junit", junit);
    put_text(words, "html", html);
    put_text(words, "diff", diff);
    if (threads != 0) put(words, "threads", std::to_string(threads));
    put_if(words, "update", update);
    put_if(words, "json", json);
    put_if(words, "quiet", quiet);
    put_path(words, path);
    return words;
}

CheckArgs CheckArgs::parse(const std::vector<std::string>& args) {
    CheckArgs a;
    CLI::App app("Compares two frame folders, two caches or two pictures.", "thixo-check");
    app.add_option("path", a.path, "frame folder, cache (output folder or its cache/) or EXR picture")->required();
    app.add_option("--against", a.against, "the reference, of the same sort")->required();
    app.add_option("--frames", a.frames, "frames, for example 1-100x2; all when left out");
    add_number(app, "--max-rel-mse", a.max_rel_mse, kRelMse,
               "pictures: passes where no channel's mean of (a - b)^2/(b^2 + 0.01) is larger; 0 (default): equal "
               "bit for bit");
    app.add_option("--tier", a.tier, "pictures: exact (default), passes (those without noise alone), noise")
        ->check(CLI::IsMember(kCheckTiers));
    add_number(app, "--max-flip", a.max_flip, kFlip, "pictures: largest mean FLIP that passes; 0 (default): no limit");
    add_number(app, "--max-flicker", a.max_flicker, kRelMse,
               "pictures: largest change from frame to frame that the reference has not; 0 (default): no limit");
    app.add_option("--junit", a.junit, "file for a report in JUnit's XML");
    app.add_option("--html", a.html, "folder for a sheet of all pictures that differ");
    app.add_option("--diff", a.diff, "folder for a picture of every difference");
    add_threads(app, a.threads);
    app.add_flag("--update", a.update, "make A the reference");
    app.add_flag("--json", a.json, "report as one JSON document");
    app.add_flag("--quiet", a.quiet, "no report, only the exit code");
    a.help = parse_words(app, args);
    return a;
}

}  // namespace thixo
