#include "pipeline/contract/shortfall.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <tuple>

#include "pipeline/base/error.h"
#include "pipeline/contract/shortfall_json.h"

namespace thixo {
namespace {

bool adds_up(Lack lack) { return lack == Lack::cut_off || lack == Lack::passed || lack == Lack::long_step; }

auto key_of(const Shortfall& s) { return std::tie(s.lack, s.name); }

std::string cut_off_text(const Shortfall& s) {
    const bool pressure = s.name == "density" || s.name == "divergence";
    return fmt::format(
        "{} of {} {} solves ended before they reached their tolerance (worst residual {:.3g}); {}", s.count, s.of,
        s.name, s.worst,
        pressure ? "raise solver.iterations, or lower solver.time_step.maximum" : "lower solver.time_step.maximum");
}

}  // namespace

void merge_shortfalls(const std::vector<Shortfall>& frame, std::vector<Shortfall>& list) {
    for (const Shortfall& s : frame) {
        const auto at = std::ranges::lower_bound(list, key_of(s), {}, key_of);
        if (at == list.end() || key_of(*at) != key_of(s)) {
            list.insert(at, s);
            continue;
        }
        at->worst = std::max(at->worst, s.worst);
        if (adds_up(s.lack)) {
            at->count += s.count;
            at->of += s.of;
        } else if (s.count >= at->count) {
            at->count = s.count;
            at->of = s.of;
        }
    }
}

Json shortfalls_json(const std::vector<Shortfall>& list) {
    Json json = Json::array();
    for (const Shortfall& s : list)
        json.push_back({{"kind", kLackWords[static_cast<std::size_t>(s.lack)]},
                        {"name", s.name},
                        {"count", s.count},
                        {"of", s.of},
                        {"worst", s.worst},
                        {"text", shortfall_text(s)}});
    return json;
}

std::vector<Shortfall> parse_shortfalls(const Json& json, const std::string& file) {
    const JsonPlace place{file, "shortfalls"};
    std::vector<Shortfall> list;
    for (const Json& j : json) {
        object_or_fail(j, place);
        const std::string word = text_at(j, "kind", place);
        const auto known = std::ranges::find(kLackWords, word);
        if (known == kLackWords.end()) throw CacheError("{}: {} has the unknown kind '{}'", file, place.path, word);
        list.push_back({.lack = static_cast<Lack>(known - kLackWords.begin()),
                        .name = text_at(j, "name", place),
                        .count = integer_at(j, "count", 0, INT64_MAX, place),
                        .of = integer_at(j, "of", 0, INT64_MAX, place),
                        .worst = number_at(j, "worst", place)});
    }
    return list;
}

std::string shortfall_text(const Shortfall& s) {
    const double percent = s.of > 0 ? 100.0 * static_cast<double>(s.count) / static_cast<double>(s.of) : 0;
    switch (s.lack) {
        case Lack::blocked:
            return fmt::format(
                "emitter '{}' is blocked: {:.3g} % ({} of {} particles) found no place; move its opening out of the "
                "obstacle, or make room before it",
                s.name, percent, s.count, s.of);
        case Lack::cut_off:
            return cut_off_text(s);
        case Lack::passed:
            return fmt::format(
                "{} times a particle went through a wall; make the wall thicker than two spacings, or leave out "
                "solver.time_step.fixed",
                s.count);
        case Lack::inside:
            return fmt::format("{} of {} particles are inside walls; thicken the wall, or slow what presses on them",
                               s.count, s.of);
        case Lack::crushed:
            return fmt::format(
                "body '{}' is crushed: {} of {} particles have less than half their volume or are inside out; raise "
                "its material's volume_stiffness (about E) or youngs_modulus",
                s.name, s.count, s.of);
        case Lack::runaway:
            return fmt::format(
                "thin films run away on walls: {} surfels for {} particles; let thick liquids stick to walls (no_slip: "
                "true), "
                "lower solver.spacing, or try pressure: dfsph",
                s.count, s.of);
        case Lack::long_step:
            return fmt::format(
                "{} of {} steps of solver.time_step.fixed were too long: up to {:.3g} times the {} limit; leave it "
                "out, or lower it",
                s.count, s.of, s.worst, s.name);
        case Lack::energy:
            return fmt::format(
                "motion gained {:.3g} J from nowhere, seen in {} of {} frames; the step is too long, or matter starts "
                "too close together",
                s.worst, s.count, s.of);
    }
    return {};
}

}  // namespace thixo
