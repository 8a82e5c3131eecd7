#pragma once

#include <pthread.h>

#include <semaphore>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "pipelines/realtime/loop.h"
#include "pipelines/realtime/scheduling.h"

namespace tribus {

/// The thread that runs a loop, and those that take its place. Thread-bound to the main thread.
class DataThread {
  public:
    DataThread(Loop& loop, const SchedulingSettings& scheduling)
        : loop_(&loop), scheduling_(scheduling) {}
    DataThread(const DataThread&) = delete;
    DataThread& operator=(const DataThread&) = delete;
    /// Ends the loop and waits for it, if it still runs.
    ~DataThread();

    /// Makes the thread and its scheduling; it does not touch the loop yet. Returns what could not
    /// be had of real time; the error is that there is no thread.
    tl::expected<std::vector<std::string>, std::string> prepare();
    /// Lets it go. After `prepare`.
    void run();
    /// The loop that it runs hands over to `next`; returns when that runs and the one before is of
    /// no use any more.
    void hand_over_to(Loop& next, LoopCarry carry);
    /// Waits until the loop has ended, which `Loop::request_end` asks for.
    void join();

  private:
    static void* main(void* self);

    Loop* loop_;
    SchedulingSettings scheduling_;
    Scheduling got_;
    std::binary_semaphore prepared_{0};
    std::binary_semaphore go_{0};
    std::binary_semaphore handed_over_{0};
    bool cancelled_ = false;
    bool started_ = false;
    bool released_ = false;
    pthread_t thread_{};
};

}  // namespace tribus
