#pragma once

#include <pthread.h>

#include <atomic>
#include <semaphore>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "pipelines/realtime/loop.h"
#include "pipelines/realtime/scheduling.h"

namespace tribus {

/// The thread that runs a loop and, after a hand-over, its successor. Thread-bound to the main
/// thread.
class DataThread {
  public:
    DataThread(Loop& loop, const SchedulingSettings& scheduling)
        : loop_(&loop), scheduling_(scheduling) {}
    DataThread(const DataThread&) = delete;
    DataThread& operator=(const DataThread&) = delete;
    /// Ends the loop if it still runs, and waits for it.
    ~DataThread();

    /// Creates the thread and its scheduling. The loop does not run yet. Returns the parts of
    /// real-time scheduling that were refused, as sentences. The error: no thread was created.
    tl::expected<std::vector<std::string>, std::string> prepare();
    /// Starts the loop. Call after `prepare`.
    void run();
    /// The loop hands over to `next`. Returns when `next` runs and the loop before is no longer
    /// used, also when the thread has ended by itself and `next` will never run.
    void hand_over_to(Loop& next, LoopCarry carry);
    /// Why the thread has ended by itself, as a sentence. Empty: it has not.
    std::string failure() const;
    bool failed() const { return failure_.load(std::memory_order_acquire) != 0; }
    /// Waits until the loop has ended, which `Loop::request_end` requests.
    void join();

  private:
    static void* main(void* self);

    Loop* loop_;
    SchedulingSettings scheduling_;
    Scheduling got_;
    std::binary_semaphore prepared_{0};
    std::binary_semaphore go_{0};
    std::counting_semaphore<2> handed_over_{0};
    std::atomic<int> failure_{0};  ///< a value of errno
    bool cancelled_ = false;
    bool started_ = false;
    bool released_ = false;
    pthread_t thread_{};
};

}  // namespace tribus
