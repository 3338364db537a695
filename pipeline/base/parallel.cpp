#include "pipeline/base/parallel.h"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>

#include <memory>

namespace thixo {
namespace {

struct Threads {
    std::unique_ptr<oneapi::tbb::global_control> limit;
    oneapi::tbb::task_arena arena;
    int count = oneapi::tbb::info::default_concurrency();
};
// The process has one. It is never destroyed, because TBB's own static objects may be destroyed before it at exit.
Threads& threads() {
    static Threads& all = *new Threads;
    return all;
}

}  // namespace

void set_thread_count(int count) {
    Threads& t = threads();
    t.count = count > 0 ? count : oneapi::tbb::info::default_concurrency();
    t.limit =
        std::make_unique<oneapi::tbb::global_control>(oneapi::tbb::global_control::max_allowed_parallelism, t.count);
    t.arena.terminate();
    t.arena.initialize(t.count);
}
int thread_count() { return threads().count; }
oneapi::tbb::task_arena& thread_arena() { return threads().arena; }

}  // namespace thixo
