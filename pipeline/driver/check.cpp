#include "pipeline/contract/check_args.h"
#include "pipeline/driver/command.h"
#include "pipeline/driver/job.h"

namespace thixo {

int check_verb(const Command& command) {
    CheckArgs args;
    args.path = command.path;
    args.against = command.against;
    args.frames = command.frames;
    args.max_rel_mse = command.max_rel_mse;
    args.tier = command.tier;
    args.max_flip = command.max_flip;
    args.max_flicker = command.max_flicker;
    args.junit = command.junit;
    args.html = command.html;
    args.diff = command.diff;
    args.threads = command.threads;
    args.update = command.update;
    args.json = command.json;
    args.quiet = command.quiet;
    const ProgramCall call = stage_call("thixo-check", args.print());
    return command.dry_run ? print_calls({call}) : run_to_end(call);
}

}  // namespace thixo
