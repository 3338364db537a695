#include "pipeline/driver/command.h"
#include "pipeline/driver/job.h"

namespace thixo {

int check_verb(const Command& command) {
    std::vector<std::string> words{"--against=" + command.against};
    if (!command.frames.empty()) words.push_back("--frames=" + command.frames);
    if (command.update) words.push_back("--update");
    if (command.json) words.push_back("--json");
    if (command.quiet) words.push_back("--quiet");
    words.insert(words.end(), {"--", command.path});
    const ProgramCall call = stage_call("thixo-check", std::move(words));
    return command.dry_run ? print_calls({call}) : run_to_end(call);
}

}  // namespace thixo
