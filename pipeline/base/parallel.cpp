#include "pipeline/base/parallel.h"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>

#include <memory>

namespace thixo {
namespace {
std::unique_ptr<oneapi::tbb::global_control> control;
int threads_set = 0;
}  // namespace

void set_thread_count(int threads) {
    threads_set = threads > 0 ? threads : oneapi::tbb::info::default_concurrency();
    // Above the number of cores TBB needs to be told as well, or a run with 3 threads on 2 cores would test nothing.
    control = std::make_unique<oneapi::tbb::global_control>(oneapi::tbb::global_control::max_allowed_parallelism, threads_set);
}
int thread_count() { return threads_set > 0 ? threads_set : oneapi::tbb::info::default_concurrency(); }

}  // namespace thixo
