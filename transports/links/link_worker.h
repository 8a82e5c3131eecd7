#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <thread>

#include "core/time.h"
#include "core/write_status.h"
#include "transports/links/link.h"
#include "transports/links/unique_fd.h"

namespace tribus {

/// How the thread of a link runs.
struct WorkerSettings {
    /// The clock of all instants. Thread-safe. Never null where a link has a thread.
    Instant (*now)() = nullptr;
    /// Whether it asks for real-time scheduling.
    bool realtime = true;
    /// Tells the user a sentence. Thread-safe. Null: nobody is told.
    void (*warn)(std::string text) = nullptr;

    bool operator==(const WorkerSettings&) const = default;
};

/// The calling thread asks for real-time scheduling, if it is to: before everything that is not
/// real time. Without the right to it, it goes on as it is.
void ask_for_realtime(const WorkerSettings& settings);

/// A thread that hands what a link sends to a kernel interface that keeps its writers waiting, such
/// as that of a chip on I2C. It always hands over the newest, and nothing that is too old. A
/// request that the thread has not taken after twice its life counts as not written: nobody may
/// take for sent what waits behind a bus that hangs, or a thread that gets no processor time.
/// Thread-bound but for `part_done` and `still_valid`.
class LinkWorker {
  public:
    LinkWorker() = default;
    LinkWorker(const LinkWorker&) = delete;
    LinkWorker& operator=(const LinkWorker&) = delete;
    /// Waits until the work that goes on is done.
    ~LinkWorker();

    /// Starts the thread; call once. `work` hands over the newest, and returns what became of it.
    /// Returns an empty text, or why there is no thread.
    std::string start(const WorkerSettings& settings, std::function<WriteStatus()> work);

    /// Says that there is something new, which lives as `life` says. Returns what became of the
    /// work that was done last, but `unavailable` while the thread makes no progress: it has not
    /// taken a request for twice its life, or the kernel keeps it for more than 200 ms with one
    /// part of its work. Neither blocks nor uses the heap.
    WriteStatus wake(FrameLife life);

    /// For a caller that does not know how long its frame lives.
    FrameLife life_from_now() const;

    /// Whether the thread has stood for a second though the kernel does not keep it. The thread
    /// that calls `wake` may ask.
    bool stands(Instant now) const;

    /// For `work`: whether what was read after this call began may still be handed over. Ask before
    /// reading it, and again with the same `end` directly before handing it over.
    Instant valid_until() const { return Instant(Duration(valid_until_ns_.load())); }
    bool is_over(Instant valid_until) const { return settings_.now() > valid_until; }
    /// For `work`: a part of it is done. Another outcome than `written` is told at once.
    void part_done(WriteStatus outcome);

  private:
    void run();
    void note_progress();
    bool makes_no_progress(FrameLife life) const;
    Instant progress() const { return Instant(Duration(progress_ns_.load())); }

    WorkerSettings settings_;
    UniqueFd wake_up_;
    std::function<WriteStatus()> work_;
    std::atomic<bool> ends_ = false;
    std::atomic<bool> works_ = false;
    std::atomic<WriteStatus> status_ = WriteStatus::written;
    /// Requests have numbers.
    std::atomic<std::uint64_t> asked_ = 0;
    std::atomic<std::uint64_t> taken_ = 0;
    /// When the thread last took a request or finished a part.
    std::atomic<std::int64_t> progress_ns_ = 0;
    std::atomic<std::int64_t> valid_until_ns_ = 0;
    /// When the first request that is not taken was made.
    Instant waits_since_{};
    std::thread thread_;
};

}  // namespace tribus
