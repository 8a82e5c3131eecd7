#pragma once

#include <pthread.h>

#include <atomic>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/recorder/recording_folder.h"
#include "app/recorder/ring_memory.h"

namespace tribus {

/// Writes one recording on a thread of its own, so that nobody waits for a slow disk. Thread-bound
/// to the main thread.
class RecordingJob {
  public:
    using Result = tl::expected<std::filesystem::path, std::string>;

    /// The rings of the order must outlive the job, or lie in `kept`.
    static std::unique_ptr<RecordingJob> start(RecordingOrder order,
                                               std::vector<RingMemory> kept = {},
                                               std::vector<CaptureRing> rings = {});
    RecordingJob(const RecordingJob&) = delete;
    RecordingJob& operator=(const RecordingJob&) = delete;
    /// Waits for the end of the job.
    ~RecordingJob();

    /// True once the recording is written or has failed.
    bool done() const { return done_.load(std::memory_order_acquire); }
    /// Call it when `done` is true.
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
