#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/time.h"

namespace tribus {

/// What the watchdog must know of an output, at one publication of the data thread.
struct OutputProgress {
    Instant due{};  ///< its next turn
    Duration period{};
    std::uint64_t overruns = 0;
};

/// Whether the outputs are on time, and if not, who is late.
enum class Punctuality : std::uint8_t {
    on_time,
    data_thread_stands,
    output_late,
};

/// Decides whether a service manager may be told that all is well: only while the data thread goes
/// on and every output has its turns. A turn that says nothing, because the failsafe is silence, or
/// whose frame the port or bus does not take, is a turn: starting anew would not help there.
/// Pure; thread-bound.
class Watchdog {
  public:
    /// `limit`: without a word for so long, the service manager starts the program anew.
    explicit Watchdog(Duration limit) : limit_(limit) {}

    /// A data thread starts, with counts from zero.
    void restart();

    /// A few times a second: `published` is when the data thread told its figures last. True if
    /// the service manager is to be told now.
    bool look(Instant now, Instant published, std::span<const OutputProgress> outputs);

    /// As of the latest look.
    Punctuality punctuality() const { return punctuality_; }
    /// Where an output is late: which.
    std::size_t late_output() const { return late_output_; }

  private:
    Punctuality judge(Instant now, Instant published, std::span<const OutputProgress> outputs);

    Duration limit_;
    Instant next_word_{};
    std::optional<Instant> published_;
    std::vector<OutputProgress> outputs_;
    Punctuality punctuality_ = Punctuality::on_time;
    std::size_t late_output_ = 0;
};

}  // namespace tribus
