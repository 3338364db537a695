#include "pipeline/check/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace thixo {

namespace {

using Json = nlohmann::ordered_json;

Json finite_or_null(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }

Json json_of(const PictureDifference& d, Json frame) {
    frame["pixels_different"] = d.pixels_different;
    frame["max_abs"] = finite_or_null(d.max_abs);
    frame["rel_mse"] = finite_or_null(d.rel_mse);
    frame["psnr"] = finite_or_null(d.psnr);
    if (d.worst_x >= 0) frame["worst"] = {{"x", d.worst_x}, {"y", d.worst_y}, {"channel", d.worst_channel}};
    frame["not_finite"] = {d.not_finite_a, d.not_finite_b};
    return frame;
}

Json json_of(const FrameReport& f) {
    Json frame = {{"name", f.name}, {"same", f.same()}, {"damaged", f.damaged}, {"problems", f.problems}};
    if (f.has_picture) frame = json_of(f.picture, std::move(frame));
    if (f.measures) {
        frame["flip"] = f.measures->flip;
        frame["brightness"] = finite_or_null(f.measures->brightness);
        frame["flicker"] = f.measures->flicker < 0 ? Json(nullptr) : finite_or_null(f.measures->flicker);
    }
    if (f.noise)
        frame["noise"] = {
            {"tests", f.noise->tests}, {"failed", f.noise->failed}, {"least_probable", f.noise->least_probable}};
    for (const AttributeDifference& d : f.attributes)
        frame["attributes"].push_back({{"name", d.name},
                                       {"different", d.different},
                                       {"max_abs", finite_or_null(d.max_abs)},
                                       {"worst_id", d.worst_id}});
    return frame;
}

std::string numbers(const FrameReport& f) {
    std::string text;
    if (const PictureDifference& d = f.picture; f.has_picture && d.pixels_different > 0)
        text +=
            fmt::format("    {} pixels differ, at most by {:.6g} in {} at ({}, {}); relMSE {:.4g}, PSNR {:.2f} dB\n",
                        d.pixels_different, d.max_abs, d.worst_channel, d.worst_x, d.worst_y, d.rel_mse, d.psnr);
    if (f.measures)
        text += fmt::format("    FLIP {:.4g}, brightness {:.5g} of the reference's{}\n", f.measures->flip,
                            f.measures->brightness,
                            f.measures->flicker < 0 ? "" : fmt::format(", flicker {:.4g}", f.measures->flicker));
    for (const AttributeDifference& d : f.attributes)
        text += fmt::format("    {}: {} points differ, at most by {:.6g} at id {}\n", d.name, d.different, d.max_abs,
                            d.worst_id);
    return text;
}

std::string lines_of(const Update& update) {
    std::string text;
    for (const auto& [word, names] :
         {std::pair{"added", &update.added}, {"replaced", &update.replaced}, {"removed", &update.removed}})
        for (const std::string& name : *names) text += fmt::format("{} {}\n", word, name);
    return text;
}

}  // namespace

bool CheckReport::same() const {
    return std::all_of(frames.begin(), frames.end(), [](const FrameReport& f) { return f.same(); });
}

bool CheckReport::damaged() const {
    return std::any_of(frames.begin(), frames.end(), [](const FrameReport& f) { return f.damaged; });
}

const FrameReport* CheckReport::most_flicker() const {
    const FrameReport* most = nullptr;
    for (const FrameReport& f : frames)
        if (f.measures && f.measures->flicker >= 0 && (!most || f.measures->flicker > most->measures->flicker))
            most = &f;
    return most;
}

std::string summary(const CheckReport& report) {
    const auto failing = std::ranges::count_if(report.frames, [](const FrameReport& f) { return !f.same(); });
    const std::string how = report.tier == "rel_mse"  ? fmt::format("within relMSE {}", report.max_rel_mse)
                            : report.tier == "passes" ? "in the passes without noise"
                            : report.tier == "noise"  ? "up to noise"
                                                      : "bit for bit";
    const bool both = std::ranges::any_of(report.frames, &FrameReport::has_picture);
    const char* thing = report.kind != "cache" ? "pictures" : both ? "frames and pictures" : "frames";
    if (failing == 0) return fmt::format("same: {} {} agree {}", report.frames.size(), thing, how);
    return fmt::format("different: {} of {} {} do not agree {}", failing, report.frames.size(), thing, how);
}

std::string print_text(const CheckReport& report) {
    std::string text;
    for (const FrameReport& f : report.frames) {
        if (f.same()) continue;
        text += fmt::format("{}: {}\n", f.name, fmt::join(f.problems, "; "));
        text += numbers(f);
    }
    for (const std::string& note : report.notes) text += fmt::format("note, not compared: {}\n", note);
    if (report.updated) {
        text += lines_of(report.update);
        const Update& u = report.update;
        return text + fmt::format("{} is now the reference: {} files added, {} replaced, {} removed\n", report.b,
                                  u.added.size(), u.replaced.size(), u.removed.size());
    }
    if (const FrameReport* worst = report.same() ? nullptr : report.most_flicker())
        text += fmt::format("flicker: at most {:.4g}, at {}\n", worst->measures->flicker, worst->name);
    return text + summary(report) + "\n";
}

std::string print_json(const CheckReport& report) {
    Json document = {{"a", report.a},
                     {"b", report.b},
                     {"kind", report.kind},
                     {"tier", report.tier},
                     {"max_rel_mse", report.max_rel_mse},
                     {"same", report.same()},
                     {"damaged", report.damaged()},
                     {"frames", Json::array()}};
    for (const FrameReport& f : report.frames) document["frames"].push_back(json_of(f));
    document["notes"] = report.notes;
    if (report.updated)
        document["updated"] = {
            {"added", report.update.added}, {"replaced", report.update.replaced}, {"removed", report.update.removed}};
    // Paths are bytes and JSON is UTF-8. Bytes that are no UTF-8 become the replacement character.
    return document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace thixo
