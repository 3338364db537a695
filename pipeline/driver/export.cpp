#include "pipeline/contract/export.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "pipeline/base/error.h"
#include "pipeline/base/log.h"
#include "pipeline/contract/stage_args.h"
#include "pipeline/driver/command.h"
#include "pipeline/driver/job.h"
#include "pipeline/driver/json_output.h"

namespace thixo {

int export_verb(const Command& command) {
    const Job job = cache_job(command);
    const CacheReader reader(job.out);
    const std::vector<int> frames = command.frames.empty() ? reader.frames() : parse_frame_range(command.frames);
    const ExportWhat what = parse_export_what(command.what.empty() ? "particles" : command.what);
    const std::filesystem::path folder = command.out.empty() ? job.out / "export" : std::filesystem::path(command.out);
    const std::vector<std::filesystem::path> files =
        export_cache(reader, frames, parse_export_format(command.to), what, folder);
    if (command.json) {
        nlohmann::ordered_json names = nlohmann::ordered_json::array();
        for (const std::filesystem::path& file : files) names.push_back(file.string());
        print_json(nlohmann::ordered_json{{"files", names}});
    } else if (!command.quiet) {
        log_info("{} files written", files.size());
        fmt::print("{}\n", folder.string());
    }
    return kDone;
}

}  // namespace thixo
