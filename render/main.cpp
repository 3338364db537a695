// thixo-render: cached frames to pictures. All it takes is in pipeline/contract/stage_args.h.
#include <fmt/core.h>

#include "pipeline/base/error.h"
#include "render/stage.h"

namespace {

int body(int argc, char** argv) {
    const thixo::RenderArgs args = thixo::RenderArgs::parse({argv + 1, argv + argc});
    if (!args.help.empty()) {
        fmt::print("{}", args.help);
        return thixo::kDone;
    }
    return thixo::render::run_stage(args);
}

}  // namespace

int main(int argc, char** argv) { return thixo::run_guarded("thixo-render", body, argc, argv); }
