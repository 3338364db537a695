// thixo: the command. Reads the words, starts the stages as processes, passes their exit codes on.
#include <algorithm>
#include <cstdio>

#include "pipeline/base/error.h"
#include "pipeline/base/log.h"
#include "pipeline/driver/command.h"

namespace thixo {
namespace {

int body(int argc, char** argv) {
    const Command command = parse_command(argc, argv);
    if (!command.text.empty()) {
        std::fputs(command.text.c_str(), stdout);
        return kDone;
    }
    set_quiet(command.quiet);
    // These end when their stages have. The others have nothing to finish.
    const auto conducts = {"run", "sim", "render", "relight", "film", "preview"};
    if (std::ranges::find(conducts, command.verb) != conducts.end() || command.repair) catch_interrupts();
    if (command.verb == "run") return run_verb(command);
    if (command.verb == "sim") return sim_verb(command);
    if (command.verb == "render") return render_verb(command);
    if (command.verb == "relight") return relight_verb(command);
    if (command.verb == "film") return film_verb(command);
    if (command.verb == "preview") return preview_verb(command);
    if (command.verb == "check") return check_verb(command);
    if (command.verb == "validate") return validate_verb(command);
    if (command.verb == "info") return info_verb(command);
    if (command.verb == "export") return export_verb(command);
    if (command.verb == "verify") return verify_verb(command);
    THIXO_ASSERT(false, "verb '{}' is parsed but not done", command.verb);
}

}  // namespace
}  // namespace thixo

int main(int argc, char** argv) { return thixo::run_guarded("thixo", thixo::body, argc, argv); }
