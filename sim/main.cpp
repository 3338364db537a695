// thixo-sim: simulates a scene into a cache. Its arguments are in pipeline/contract/stage_args.h.
#include <fmt/core.h>

#include "pipeline/base/error.h"
#include "sim/stage/run.h"

namespace {

int body(int argc, char** argv) {
    const thixo::SimArgs args = thixo::SimArgs::parse({argv + 1, argv + argc});
    if (!args.help.empty()) {
        fmt::print("{}", args.help);
        return thixo::kDone;
    }
    return thixo::run_simulation(args);
}

}  // namespace

int main(int argc, char** argv) { return thixo::run_guarded("thixo-sim", body, argc, argv); }
