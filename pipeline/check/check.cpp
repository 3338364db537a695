#include "pipeline/check/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <optional>

#include "pipeline/check/compare_frames.h"
#include "pipeline/check/compare_manifests.h"
#include "pipeline/check/compare_noisy.h"
#include "pipeline/check/compare_pictures.h"
#include "pipeline/check/difference_picture.h"
#include "pipeline/check/inputs.h"
#include "pipeline/check/sequence.h"
#include "pipeline/check/update.h"
#include "pipeline/contract/atomic_file.h"
#include "pipeline/contract/cache.h"
#include "pipeline/contract/image.h"
#include "pipeline/contract/stage_args.h"

namespace thixo {

namespace fs = std::filesystem;

namespace {

FrameReport one_problem(const std::string& name, const std::string& problem, bool damaged = false) {
    FrameReport report;
    report.name = name;
    report.problems.push_back(problem);
    report.damaged = damaged;
    return report;
}

// The report of a file that only one side has. The file is read all the same, so that damage is reported as damage.
FrameReport unpaired(const std::string& name, bool in_a, const std::function<void()>& read) {
    try {
        read();
    } catch (const CacheError& e) {
        return one_problem(name, e.what(), true);
    }
    return one_problem(name, in_a ? "is not in the reference" : "is missing");
}

/// A sequence of pictures that is compared in order.
struct PictureCheck {
    const CheckArgs& args;
    double false_alarms = kFalseAlarms;  // of one picture
    Sequence sequence{};

    FrameReport compare(const std::string& name, const Image& a, const Image& b) {
        if (args.tier == "passes") return compare_pictures(name, without_noise(a), without_noise(b), args.max_rel_mse);
        const bool noise = args.tier == "noise";
        FrameReport report = compare_pictures(name, a, b, noise ? kRelMse.most : args.max_rel_mse);
        if (noise && report.has_picture) report.noise = compare_noisy(a, b, false_alarms, report.problems);
        return report;
    }
    void measure(const Image& a, const Image& b, FrameReport& report) {
        if (!report.has_picture) return sequence.interrupt();
        report.measures = sequence.next(a, b);
        if (!report.measures) return;
        const PictureMeasures& m = *report.measures;
        if (args.max_flip > 0 && !(m.flip <= args.max_flip))
            report.problems.push_back(fmt::format("FLIP {:.4g} is above {:.4g}", m.flip, args.max_flip));
        if (args.max_flicker > 0 && m.flicker >= 0 && !(m.flicker <= args.max_flicker))
            report.problems.push_back(fmt::format("flicker {:.4g} is above {:.4g}", m.flicker, args.max_flicker));
    }
};

void write_difference(const fs::path& file, const Image& a, const Image& b) {
    make_folder(file.parent_path());
    write_png(file, difference_picture(a, b));
}

FrameReport compare_files(const std::string& name, const fs::path& a, const fs::path& b, PictureCheck& check) {
    try {
        const Image image_a = read_exr(a), image_b = read_exr(b);
        FrameReport report = check.compare(name, image_a, image_b);
        check.measure(image_a, image_b, report);
        if (report.same() || !report.has_picture) return report;
        const fs::path file = fs::path(name).parent_path() / (fs::path(name).stem().string() + ".diff.png");
        if (!check.args.diff.empty()) write_difference(fs::path(check.args.diff) / file, image_a, image_b);
        if (!check.args.html.empty()) {
            report.sheet_picture = file.string();
            write_difference(fs::path(check.args.html) / file, image_a, image_b);
        }
        return report;
    } catch (const CacheError& e) {
        check.sequence.interrupt();
        return one_problem(name, e.what(), true);
    }
}

/// Compares the pictures of two folders; reports call them by `prefix` and their name. Returns how many there are.
std::size_t compare_folders(const fs::path& a, const fs::path& b, const std::string& prefix, const CheckArgs& args,
                            const std::vector<int>* frames, CheckReport& report) {
    const auto pairs = pair_names(picture_names(a, frames), picture_names(b, frames));
    PictureCheck check{args, kFalseAlarms / static_cast<double>(std::max<std::size_t>(1, pairs.size()))};
    for (const auto& [name, in_a, in_b] : pairs) {
        if (in_a && in_b) {
            report.frames.push_back(compare_files(prefix + name, a / name, b / name, check));
            continue;
        }
        check.sequence.interrupt();
        report.frames.push_back(
            unpaired(prefix + name, in_a, [&, &file = name, &left = in_a] { read_exr((left ? a : b) / file); }));
    }
    return pairs.size();
}

void check_pictures(const CheckArgs& args, const std::vector<int>* frames, CheckReport& report) {
    if (compare_folders(args.path, args.against, "", args, frames, report) == 0)
        throw CacheError("'{}' and '{}' hold no picture of frames {}; render them first", args.path, args.against,
                         args.frames);
}

/// The pictures beside two caches. What only one side has rendered is told, and is no difference.
void check_pictures_of_outputs(const CheckArgs& args, const std::vector<int>* frames, CheckReport& report) {
    for (const auto& [name, in_a, in_b] : pair_names(picture_folders(args.path), picture_folders(args.against)))
        if (in_a && in_b)
            compare_folders(fs::path(args.path) / name, fs::path(args.against) / name, name + "/", args, frames,
                            report);
        else
            report.notes.push_back(
                fmt::format("the pictures of {}/, which {} alone has", name, in_a ? args.path : args.against));
}

void check_caches(const CheckArgs& args, const std::vector<int>* frames, CheckReport& report) {
    const CacheReader a(args.path);
    std::optional<CacheReader> b;
    if (!args.update || CacheReader::exists(args.against)) b.emplace(args.against);
    const auto wanted = [&](const std::optional<CacheReader>& reader) {
        std::vector<int> numbers = reader ? reader->frames() : std::vector<int>();
        if (frames)
            std::erase_if(numbers, [&](int n) { return !std::binary_search(frames->begin(), frames->end(), n); });
        return numbers;
    };
    const auto pairs = pair_names(wanted(a), wanted(b));
    if (pairs.empty()) throw CacheError("neither cache holds a frame to compare; simulate first");
    for (const auto& [number, in_a, in_b] : pairs) {
        const std::string name = fmt::format("frame {}", number);
        if (!in_a || !in_b) {
            report.frames.push_back(
                unpaired(name, in_a, [&, n = number, left = in_a] { (left ? a : *b).load_frame(n); }));
            continue;
        }
        try {
            FrameReport frame = compare_frames(name, a.load_frame(number), b->load_frame(number));
            for (std::string& problem : compare_entries(*a.manifest().find(number), *b->manifest().find(number)))
                frame.problems.push_back(std::move(problem));
            report.frames.push_back(std::move(frame));
        } catch (const CacheError& e) {
            report.frames.push_back(one_problem(name, e.what(), true));
        }
    }
    if (b) report.notes = manifest_notes(a.manifest(), b->manifest());
    if (b) check_pictures_of_outputs(args, frames, report);
    const auto asset_names = [](const Manifest& m) {
        std::vector<std::string> names;
        for (const CacheFile& f : m.assets) names.push_back(f.name);
        return names;
    };
    // An asset's name is the checksum of its content. Once load_asset has verified both, equal names mean equal bytes.
    for (const auto& [name, in_a, in_b] :
         pair_names(asset_names(a.manifest()), b ? asset_names(b->manifest()) : std::vector<std::string>())) {
        const std::string hash = fs::path(name).stem().string();
        try {
            if (in_a) a.load_asset(hash);
            if (in_b) b->load_asset(hash);
            if (!in_a || !in_b)
                report.frames.push_back(one_problem(name, in_a ? "is not in the reference" : "is missing"));
        } catch (const CacheError& e) {
            report.frames.push_back(one_problem(name, e.what(), true));
        }
    }
}

void require_good(const CheckArgs& args, CheckKind kind, const std::vector<int>* frames) {
    const auto require_finite = [](const std::string& file) {
        const Image image = read_exr(file);
        const std::size_t bad = compare_pictures(file, image, image, 0).picture.not_finite_a;
        if (bad > 0)
            throw CacheError("'{}' holds {} values that are not finite and cannot be a reference; render it again",
                             file, bad);
    };
    if (kind == CheckKind::picture) require_finite(args.path);
    if (kind == CheckKind::folder)
        for (const std::string& name : picture_names(args.path, frames))
            require_finite((fs::path(args.path) / name).string());
    if (kind != CheckKind::cache) return;
    const CacheReader reader(args.path);
    for (const int number : reader.frames()) {
        const Frame frame = reader.load_frame(number);
        const FrameReport own = compare_frames(fmt::format("frame {}", number), frame, frame);
        if (!own.same())
            throw CacheError("'{}' {}: {}; it cannot be a reference", args.path, own.name, own.problems.front());
    }
    for (const CacheFile& f : reader.manifest().assets) reader.load_asset(fs::path(f.name).stem().string());
}

void append(const std::string& folder, const std::vector<std::string>& names, std::vector<std::string>& to) {
    for (const std::string& name : names) to.push_back(folder + "/" + name);
}

Update make_reference(const CheckArgs& args, CheckKind kind, const std::vector<int>* frames) {
    require_good(args, kind, frames);
    if (kind == CheckKind::cache) {
        Update update = update_cache(args.path, args.against);
        for (const std::string& name : picture_folders(args.path)) {
            const fs::path a = fs::path(args.path) / name, b = fs::path(args.against) / name;
            const Update pictures = update_pictures(a, picture_names(a, nullptr), b, picture_names(b, nullptr));
            append(name, pictures.added, update.added);
            append(name, pictures.replaced, update.replaced);
            append(name, pictures.removed, update.removed);
        }
        return update;
    }
    if (kind == CheckKind::picture) return update_picture(args.path, args.against);
    return update_pictures(args.path, picture_names(args.path, frames), args.against,
                           picture_names(args.against, frames));
}

void require_sense(const CheckArgs& args, CheckKind kind) {
    std::error_code ignored;
    if (args.max_rel_mse > 0 && kind == CheckKind::cache && picture_folders(args.path).empty())
        throw InputError("--max-rel-mse is for pictures; caches are compared bit for bit");
    if (kind == CheckKind::cache && (args.tier != kCheckTiers.front() || args.max_flip > 0 || args.max_flicker > 0))
        throw InputError("--tier, --max-flip and --max-flicker are for pictures; caches are compared bit for bit");
    if (args.tier == "noise" && args.max_rel_mse > 0)
        throw InputError("--max-rel-mse is a limit of its own; leave it out with --tier noise");
    if (args.update && kind == CheckKind::cache && !args.frames.empty())
        throw InputError("--update of a cache takes all its frames; leave out --frames");
    if (args.update && fs::exists(args.against, ignored) && fs::equivalent(args.path, args.against, ignored))
        throw InputError("--update: '{}' and '{}' are the same place", args.path, args.against);
}

}  // namespace

CheckReport check(const CheckArgs& args) {
    const CheckKind kind = check_kind(args.path);
    require_sense(args, kind);
    std::error_code ignored;
    const bool first_reference =
        args.update && (!fs::exists(args.against, ignored) || fs::is_empty(args.against, ignored));
    if (!first_reference)
        if (const CheckKind other = check_kind(args.against); other != kind)
            throw InputError("'{}' is {}, '{}' is {}: only like can be compared with like", args.path, name_of(kind),
                             args.against, name_of(other));
    std::vector<int> range;
    if (!args.frames.empty()) range = parse_frame_range(args.frames);
    const std::vector<int>* frames = args.frames.empty() ? nullptr : &range;

    CheckReport report;
    report.a = args.path;
    report.b = args.against;
    report.kind = kind == CheckKind::cache ? "cache" : "pictures";
    report.max_rel_mse = args.max_rel_mse;
    report.tier = args.tier == "exact" && args.max_rel_mse > 0 ? "rel_mse" : args.tier;
    if (!first_reference) {
        PictureCheck one{args};
        if (kind == CheckKind::picture)
            report.frames.push_back(
                compare_files(fs::path(args.path).filename().string(), args.path, args.against, one));
        else if (kind == CheckKind::folder)
            check_pictures(args, frames, report);
        else
            check_caches(args, frames, report);
    }
    if (args.update) {
        report.update = make_reference(args, kind, frames);
        report.updated = true;
    }
    return report;
}

ExitCode exit_code_of(const CheckReport& report) {
    if (report.updated) return kDone;
    return report.damaged() ? kBadCache : report.same() ? kDone : kDifferent;
}

}  // namespace thixo
