// An answer to SIGINT and SIGTERM within two seconds, however long the work takes between two looks at interrupted().
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace thixo {

/// While it lives, work that has not ended by itself a second after a signal is ended, by a thread of its own. The thread
/// calls `save`, prints what an InterruptedError says, and ends the process with its exit code. Files are written whole
/// (contract/atomic_file.h), so that the work may be cut off anywhere. Requires catch_interrupts.
class InterruptionWatch {
  public:
    /// `save` keeps what would be lost; it runs beside the work. An Error that it throws is printed in place of the
    /// interruption, and its exit code counts.
    InterruptionWatch(const char* program, std::function<void()> save);
    InterruptionWatch(const InterruptionWatch&) = delete;
    InterruptionWatch& operator=(const InterruptionWatch&) = delete;
    ~InterruptionWatch();

  private:
    void watch();
    bool over_within(int milliseconds);
    const char* program_;
    std::function<void()> save_;
    std::mutex mutex_;
    std::condition_variable ended_;
    bool over_ = false;
    std::thread thread_;
};

}  // namespace thixo
