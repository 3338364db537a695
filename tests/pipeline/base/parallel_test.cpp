#include "pipeline/base/parallel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <mutex>
#include <numeric>
#include <set>
#include <thread>
#include <vector>

#include "pipeline/base/random.h"

namespace thixo {
namespace {

/// Numbers of many magnitudes, so that another order of summation gives other bits.
std::vector<double> numbers(std::size_t n) {
    std::vector<double> values(n);
    for (std::size_t i = 0; i < n; ++i)
        values[i] = (random_unit(1, i, 0, 0) - 0.5) * std::pow(10.0, double(i % 17) - 8);
    return values;
}

TEST(Parallel, SumsHaveTheSameBitsAtAnyThreadCount) {
    for (std::size_t n : {std::size_t(0), std::size_t(1), kChunk - 1, kChunk, kChunk + 1, 50 * kChunk + 7}) {
        const std::vector<double> values = numbers(n);
        std::vector<double> sums;
        for (int threads : {1, 2, 3, 2, 1}) {
            set_thread_count(threads);
            sums.push_back(parallel_sum(n, [&](std::size_t i) { return values[i]; }));
        }
        for (double s : sums) EXPECT_EQ(0, std::memcmp(&s, &sums[0], sizeof s)) << n;
    }
}

TEST(Parallel, SumIsTheSumOverChunksInTheirOrder) {
    const std::size_t n = 3 * kChunk + 100;
    const std::vector<double> values = numbers(n);
    double expected = 0;
    for (std::size_t begin = 0; begin < n; begin += kChunk) {
        double part = 0;
        for (std::size_t i = begin; i < std::min(n, begin + kChunk); ++i) part += values[i];
        expected += part;
    }
    EXPECT_EQ(expected, parallel_sum(n, [&](std::size_t i) { return values[i]; }));
    EXPECT_NE(expected,
              std::accumulate(values.begin(), values.end(), 0.0));  // or the test could not tell the orders apart
}

TEST(Parallel, ReduceFindsTheLargest) {
    const std::size_t n = 10000;
    const double largest = parallel_reduce(
        n, -1.0, [](std::size_t i) { return random_unit(2, i, 0, 0); },
        [](double a, double b) { return std::max(a, b); });
    double expected = -1;
    for (std::size_t i = 0; i < n; ++i) expected = std::max(expected, random_unit(2, i, 0, 0));
    EXPECT_EQ(expected, largest);
}

TEST(Parallel, ForVisitsEveryElementOnce) {
    for (std::size_t n : {std::size_t(0), std::size_t(1), std::size_t(255), std::size_t(100003)}) {
        std::vector<int> visits(n, 0);
        parallel_for(
            n, [&](std::size_t i) { ++visits[i]; }, 64);
        EXPECT_EQ(std::vector<int>(n, 1), visits);
    }
}

TEST(Parallel, ChunksAreTheSameRangesAtAnyThreadCount) {
    const std::size_t n = 10 * 100 + 3;
    for (int threads : {1, 3}) {
        set_thread_count(threads);
        std::vector<std::pair<std::size_t, std::size_t>> ranges(11);
        parallel_chunks(
            n,
            [&](std::size_t begin, std::size_t end, std::size_t c) {
                ranges[c] = {begin, end};
            },
            100);
        for (std::size_t c = 0; c < ranges.size(); ++c) {
            EXPECT_EQ(c * 100, ranges[c].first);
            EXPECT_EQ(std::min(n, (c + 1) * 100), ranges[c].second);
        }
    }
}

TEST(Parallel, UsesNoMoreThreadsThanAsked) {
    for (std::size_t threads : {1u, 2u}) {
        set_thread_count(static_cast<int>(threads));
        EXPECT_EQ(static_cast<int>(threads), thread_count());
        std::mutex lock;
        std::set<std::thread::id> seen;
        parallel_for(
            64,
            [&](std::size_t) {
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
                const std::lock_guard<std::mutex> guard(lock);
                seen.insert(std::this_thread::get_id());
            },
            1);
        EXPECT_LE(seen.size(), threads);
    }
}

TEST(Parallel, UsesMoreThreadsThanCoresWhenAsked) {
    // Or a comparison of 1, 2 and 3 threads on a machine with two cores would compare 2 with 2.
    const int threads = static_cast<int>(std::thread::hardware_concurrency()) + 1;
    set_thread_count(threads);
    std::mutex lock;
    std::set<std::thread::id> seen;
    for (int attempt = 0; attempt < 20 && static_cast<int>(seen.size()) < threads; ++attempt)
        parallel_for(
            64 * static_cast<std::size_t>(threads),
            [&](std::size_t) {
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
                const std::lock_guard<std::mutex> guard(lock);
                seen.insert(std::this_thread::get_id());
            },
            1);
    EXPECT_EQ(static_cast<std::size_t>(threads), seen.size());
}

TEST(Parallel, PassesAnExceptionOn) {
    EXPECT_THROW(parallel_for(10000,
                              [](std::size_t i) {
                                  if (i == 7777) throw std::runtime_error("x");
                              }),
                 std::runtime_error);
}

}  // namespace
}  // namespace thixo
