#pragma once

#include <pthread.h>

#include <atomic>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/recording_folder.h"
#include "app/ring_memory.h"

namespace tribus {

/// One recording on its way to the disk, on a thread of its own: a slow disk makes nobody wait.
/// Thread-bound to the main thread.
class RecordingJob {
  public:
    using Result = tl::expected<std::filesystem::path, std::string>;

    /// The rings of the order must outlive it, or are in `kept`.
    static std::unique_ptr<RecordingJob> start(RecordingOrder order,
                                               std::vector<RingMemory> kept = {},
                                               std::vector<CaptureRing> rings = {});
    RecordingJob(const RecordingJob&) = delete;
    RecordingJob& operator=(const RecordingJob&) = delete;
    /// Waits for its end.
    ~RecordingJob();

    bool done() const { return done_.load(std::memory_order_acquire); }
    /// Once it is done.
    const Result& result() const { return result_; }
    const RecordingOrder& order() const { return order_; }

  private:
    RecordingJob() = default;
    static void* main(void* self);

    RecordingOrder order_;
    std::vector<RingMemory> kept_;
    std::vector<CaptureRing> rings_;
    Result result_{};
    std::atomic<bool> done_{false};
    bool started_ = false;
    pthread_t thread_{};
};

}  // namespace tribus
