#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <thread>

#include "core/write_status.h"
#include "transports/links/unique_fd.h"

namespace tribus {

/// A thread that hands what a link sends to a kernel interface that keeps its writers waiting, such
/// as that of a chip on I2C. It always hands over the newest. Thread-bound but for `part_done`.
class LinkWorker {
  public:
    LinkWorker() = default;
    LinkWorker(const LinkWorker&) = delete;
    LinkWorker& operator=(const LinkWorker&) = delete;
    /// Waits until the work that goes on is done.
    ~LinkWorker();

    /// Starts the thread; call once. `work` hands over the newest, and returns what became of it.
    /// Returns an empty text, or why there is no thread.
    std::string start(std::function<WriteStatus()> work);

    /// Says that there is something new. Returns what became of the work that was done last, but
    /// `unavailable` if the kernel keeps the thread for more than 200 ms: nobody may take for sent
    /// what waits behind a bus that hangs. Neither blocks nor uses the heap.
    WriteStatus wake();

    /// For `work`: a part of it is done. Another outcome than `written` is told at once.
    void part_done(WriteStatus outcome);

  private:
    void run();
    void watch_next_part();
    bool hangs() const;

    UniqueFd wake_up_;
    UniqueFd patience_;  ///< a timer that has run out when a part takes too long
    std::function<WriteStatus()> work_;
    std::atomic<bool> ends_ = false;
    std::atomic<bool> works_ = false;
    std::atomic<WriteStatus> status_ = WriteStatus::written;
    std::thread thread_;
};

}  // namespace tribus
