// The one parallel idiom: gather form over oneTBB. Iteration i writes only element i; sums run over fixed chunks in a
// fixed order. Both give the same bits at any thread count.
#pragma once

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace thixo {

/// Limits the threads of the whole process for its remaining life (0: all cores). Call once, before any Embree device
/// exists.
void set_thread_count(int threads);
int thread_count();

/// The arena of thread_count() slots in which every loop runs. TBB's default arena would be limited to the number of
/// cores.
oneapi::tbb::task_arena& thread_arena();

inline constexpr std::size_t kChunk = 1024;

/// One copy of the machine code of a chunk. Inlined into TBB's ways to run a task it would exist several times, each with
/// other sums fused and so rounded otherwise. Which of them runs depends on the threads.
template <class F>
__attribute__((noinline, noclone)) void run_chunk(F& f, std::size_t begin, std::size_t end, std::size_t chunk) {
    f(begin, end, chunk);
}

/// f(begin, end, chunk) for fixed chunks of [0, n): chunk c is always the same range, whatever the thread count.
template <class F>
void parallel_chunks(std::size_t n, F&& f, std::size_t chunk = kChunk) {
    const std::size_t chunks = (n + chunk - 1) / chunk;
    thread_arena().execute([&] {
        oneapi::tbb::parallel_for(std::size_t(0), chunks,
                                  [&](std::size_t c) { run_chunk(f, c * chunk, std::min(n, (c + 1) * chunk), c); });
    });
}

/// f(i) for i in [0, n), in parallel. f may write element i only, and reads nothing that another iteration writes. The
/// ranges are fixed: in a loop of lanes, the rest of a range may be rounded otherwise than the lanes.
template <class F>
void parallel_for(std::size_t n, F&& f, std::size_t grain = 256) {
    parallel_chunks(
        n,
        [&](std::size_t begin, std::size_t end, std::size_t) {
            for (std::size_t i = begin; i != end; ++i) f(i);
        },
        grain);
}

/// Reduction in a fixed order: combine(T, T) folds term(i) within fixed chunks, then the results of the chunks.
template <class T, class Term, class Combine>
T parallel_reduce(std::size_t n, T identity, Term&& term, Combine&& combine) {
    std::vector<T> partial((n + kChunk - 1) / kChunk, identity);
    parallel_chunks(n, [&](std::size_t begin, std::size_t end, std::size_t c) {
        T sum = identity;
        for (std::size_t i = begin; i < end; ++i) sum = combine(sum, term(i));
        partial[c] = sum;
    });
    T total = identity;
    for (const T& p : partial) total = combine(total, p);
    return total;
}

/// Sum of term(i) over [0, n), in double (or any type T with +).
template <class T = double, class Term>
T parallel_sum(std::size_t n, Term&& term, T zero = T(0)) {
    return parallel_reduce(n, zero, term, [](const T& a, const T& b) -> T { return a + b; });
}

}  // namespace thixo
