#include "pipeline/driver/verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "pipeline/base/error.h"
#include "pipeline/base/log.h"
#include "pipeline/contract/atomic_file.h"
#include "pipeline/contract/cache.h"
#include "pipeline/contract/hash.h"
#include "pipeline/contract/picture_files.h"
#include "pipeline/driver/command.h"
#include "pipeline/driver/film.h"
#include "pipeline/driver/json_output.h"
#include "pipeline/driver/repair.h"

namespace thixo {
namespace fs = std::filesystem;
namespace {

using Part = Damage::Part;

std::vector<fs::path> sorted_entries(const fs::path& folder) {
    std::vector<fs::path> entries;
    std::error_code missing;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, missing)) entries.push_back(entry.path());
    std::sort(entries.begin(), entries.end());
    return entries;
}

/// The number in <head>NNNN<tail>, where the name has that form.
std::optional<int> number_in(const std::string& name, std::string_view head, std::string_view tail) {
    if (!name.starts_with(head) || !name.ends_with(tail) || name.size() <= head.size() + tail.size()) return {};
    const char *first = name.data() + head.size(), *last = name.data() + name.size() - tail.size();
    int number = -1;
    const auto [end, failure] = std::from_chars(first, last, number);
    return failure == std::errc() && end == last && number >= 0 ? std::optional(number) : std::nullopt;
}

class Verifier {
  public:
    explicit Verifier(const fs::path& out) : out_(out) {}

    VerifyReport run() {
        verify_cache();
        verify_checkpoints();
        for (const fs::path& entry : sorted_entries(out_)) {
            const std::string name = entry.filename().string();
            std::error_code ignored;
            if (fs::is_directory(entry, ignored) && (name == "frames" || name.starts_with("frames.")))
                verify_pictures(entry);
            else if (name.ends_with(".mp4") || name.ends_with(".mov"))
                verify_film(entry);
        }
        return std::move(report_);
    }

  private:
    void add(Part part, const fs::path& file, const std::string& problem, const std::string& remedy, int frame = -1) {
        report_.damages.push_back({part, file, problem, remedy, frame});
    }

    void verify_cache() {
        std::optional<CacheReader> reader;
        ++report_.files;
        try {
            reader.emplace(out_ / "cache");
        } catch (const CacheError& e) {
            return add(Part::manifest, out_ / "cache" / kManifestName, e.what(), "simulate again with --restart");
        }
        const auto verify = [&](const CacheFile& file) {
            ++report_.files;
            try {
                read_listed(reader->folder(), file);
            } catch (const CacheError& e) {
                add(Part::cache, reader->folder() / file.name, e.what(), "thixo sim makes it again");
            }
        };
        for (const CacheFile& asset : reader->manifest().assets) verify(asset);
        for (const ManifestFrame& frame : reader->manifest().frames)
            for (const CacheFile* file : frame.files()) verify(*file);
    }

    void verify_checkpoints() {
        for (const fs::path& file : sorted_entries(out_ / "checkpoint")) {
            if (!number_in(file.filename().string(), "checkpoint.", ".bin")) continue;
            ++report_.files;
            try {
                if (ends_with_checksum(read_whole(file))) continue;
                add(Part::checkpoint, file, fmt::format("'{}' is damaged: its checksum differs", file.string()),
                    "a run that continues starts from an earlier state");
            } catch (const CacheError& e) {
                add(Part::checkpoint, file, e.what(), "a run that continues starts from an earlier state");
            }
        }
    }

    void verify_pictures(const fs::path& folder) {
        std::set<int> frames;
        for (const fs::path& file : sorted_entries(folder))
            for (const char* tail : {".exr", ".png"})
                if (const auto number = number_in(file.filename().string(), "beauty.", tail)) frames.insert(*number);
        const std::string name = folder.filename().string();
        const std::string remedy =
            name == "frames" ? "thixo render makes it again" : "thixo render with --look makes it again";
        for (const int number : frames) {
            report_.files += 2;
            const StoredPicture stored = read_picture(folder, number);
            if (stored.problem.empty()) continue;
            const fs::path file = stored.exr_there ? png_path(folder, number) : exr_path(folder, number);
            add(Part::pictures, file, stored.problem, remedy, number);
        }
    }

    void verify_film(const fs::path& film) {
        ++report_.files;
        if (!film_is_whole(film))
            add(Part::film, film, fmt::format("'{}' is damaged, or not of Thixo", film.string()),
                "thixo run or thixo film makes it again");
    }

    fs::path out_;
    VerifyReport report_;
};

nlohmann::ordered_json json_of(const VerifyReport& report) {
    nlohmann::ordered_json json{{"files", report.files}, {"damaged", nlohmann::ordered_json::array()}};
    for (const Damage& d : report.damages)
        json["damaged"].push_back({{"file", d.file.string()}, {"problem", d.problem}, {"remedy", d.remedy}});
    return json;
}

}  // namespace

VerifyReport verify_output(const fs::path& out) { return Verifier(out).run(); }

int report_damages(const fs::path& out, const VerifyReport& report, const Command& command) {
    if (command.json && command.verb == "verify") print_json(json_of(report));
    for (const Damage& d : report.damages) log_warning("{}; {}", d.problem, d.remedy);
    if (!command.json && !command.quiet)
        fmt::print("{}: {} files, {} damaged\n", out.string(), report.files, report.damages.size());
    return report.damages.empty() ? kDone : kBadCache;
}

int verify_verb(const Command& command) {
    const Job job = output_job(command);
    VerifyReport report = verify_output(job.out);
    if (command.repair && !report.damages.empty()) {
        for (const Damage& d : report.damages) log_info("{}", d.problem);
        repair_output(command, job, report);
        report = verify_output(job.out);
    }
    return report_damages(job.out, report, command);
}

}  // namespace thixo
