#pragma once

#include <pthread.h>

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/recorder/recording_folder.h"
#include "app/recorder/ring_memory.h"

namespace tribus {

/// What is written, and what holds its rings, one for each port of the order.
struct PreparedRecording {
    RecordingOrder order;
    std::vector<RingMemory> kept;
    std::vector<CaptureRing> rings;
};

/// Writes one recording on a thread of its own, so that nobody waits for a slow disk. Thread-bound
/// to the main thread.
class RecordingJob {
  public:
    using Result = tl::expected<std::filesystem::path, std::string>;
    using Prepare = std::function<tl::expected<PreparedRecording, std::string>()>;

    /// The rings of the order must outlive the job.
    static std::unique_ptr<RecordingJob> start(RecordingOrder order);
    /// `prepare` runs on the thread of the job, and what it needs must outlive the job.
    static std::unique_ptr<RecordingJob> start(Prepare prepare);
    RecordingJob(const RecordingJob&) = delete;
    RecordingJob& operator=(const RecordingJob&) = delete;
    /// Waits for the end of the job.
    ~RecordingJob();

    /// True once the recording is written or has failed.
    bool done() const { return done_.load(std::memory_order_acquire); }
    /// Call it when `done` is true.
    const Result& result() const { return result_; }
    /// False: `result` says why there is nothing to write. Call it when `done` is true.
    bool prepared() const { return prepared_; }
    /// Call it when `done` is true.
    const RecordingOrder& order() const { return work_.order; }

  private:
    RecordingJob() = default;
    static void* main(void* self);
    void start_thread();
    Result write();

    Prepare prepare_;
    PreparedRecording work_;
    bool prepared_ = true;
    Result result_{};
    std::atomic<bool> done_{false};
    bool started_ = false;
    pthread_t thread_{};
};

}  // namespace tribus
