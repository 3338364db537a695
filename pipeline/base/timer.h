// Wall-clock time. Its values go to logs and stats.jsonl only, never into a cache file or a frame.
#pragma once

#include <chrono>

namespace thixo {

inline double wall_seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Adds the seconds of its scope to a sum.
class ScopedTimer {
  public:
    explicit ScopedTimer(double& sum) : sum_(sum), start_(wall_seconds()) {}
    ~ScopedTimer() { sum_ += wall_seconds() - start_; }
    ScopedTimer(const ScopedTimer&) = delete;
    ScopedTimer& operator=(const ScopedTimer&) = delete;

  private:
    double& sum_;
    double start_;
};

}  // namespace thixo
