// The program thixo-check, which compares two results.
#include <cstdio>
#include <filesystem>

#include "pipeline/base/log.h"
#include "pipeline/base/parallel.h"
#include "pipeline/check/check.h"
#include "pipeline/check/report_files.h"
#include "pipeline/contract/atomic_file.h"

namespace {

int run(int argc, char** argv) {
    const thixo::CheckArgs args = thixo::CheckArgs::parse({argv + 1, argv + argc});
    if (!args.help.empty()) {
        std::fputs(args.help.c_str(), stdout);
        return thixo::kDone;
    }
    thixo::set_quiet(args.quiet);
    thixo::set_thread_count(args.threads);
    const thixo::CheckReport report = thixo::check(args);
    if (!args.junit.empty()) thixo::write_whole(args.junit, thixo::print_junit(report));
    if (!args.html.empty()) {
        thixo::make_folder(args.html);
        thixo::write_whole(std::filesystem::path(args.html) / "index.html", thixo::print_html(report));
    }
    if (args.json)
        std::fputs(thixo::print_json(report).c_str(), stdout);
    else if (!args.quiet)
        std::fputs(thixo::print_text(report).c_str(), stdout);
    return thixo::exit_code_of(report);
}

}  // namespace

int main(int argc, char** argv) { return thixo::run_guarded("thixo-check", run, argc, argv); }
