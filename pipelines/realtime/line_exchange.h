#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <string>

#include <tl/expected.hpp>

#include "core/time.h"
#include "pipelines/rules/line_words.h"
#include "transports/links/unique_fd.h"

namespace tribus {

/// Exchanges data between the data thread and the GPIO thread: words of bits, times, and one event
/// descriptor for each direction, which wakes the other thread. Nothing waits, and nothing is
/// allocated after construction. Thread-safe, except where a comment names a thread.
class LineExchange {
  public:
    explicit LineExchange(std::size_t outputs) : fresh_ns_(outputs) {}

    /// Main thread, before the other threads start. The error is a sentence.
    tl::expected<void, std::string> prepare();

    /// Sets the levels of the input lines as they were at `now`. GPIO thread; before it runs, main
    /// thread. Called five times a second or more often.
    void set_levels(LineLevels levels, Instant now) {
        looked_at_ns_.store(now.time_since_epoch().count(), std::memory_order_release);
        set(levels, levels_, data_event_);
    }
    /// The latest levels. No line is known if the latest are more than a second old: a chip on a
    /// bus that hangs keeps the GPIO thread in the kernel.
    LineLevels levels(Instant now) const {
        return hangs(now) ? LineLevels{} : levels_.load(std::memory_order_acquire);
    }
    bool hangs(Instant now) const {
        const Duration looked_at{looked_at_ns_.load(std::memory_order_acquire)};
        return now - Instant(looked_at) > kMostAge;
    }
    /// Readable after the levels have changed, until `clear_data_event`.
    int data_event() const { return data_event_.get(); }
    void clear_data_event() const { clear_event(data_event_); }

    /// Sets what the output lines show. Data thread.
    void set_states(LineStates states) { set(states, states_, lines_event_); }
    LineStates states() const { return states_.load(std::memory_order_acquire); }
    /// Readable after the states have changed or `wake_lines` was called, until
    /// `clear_lines_event`.
    int lines_event() const { return lines_event_.get(); }
    void clear_lines_event() const { clear_event(lines_event_); }
    void wake_lines() const { set_event(lines_event_); }

    /// An output has handed over fresh data at `now`. Data thread.
    void set_fresh(std::size_t output, Instant now) {
        fresh_ns_[output].store(now.time_since_epoch().count(), std::memory_order_release);
    }
    /// The oldest of the times at which these outputs last handed over fresh data. `Instant{}` if
    /// one of them never did.
    Instant fresh_at(std::span<const std::size_t> outputs) const;

  private:
    template <class Word>
    static void set(Word word, std::atomic<Word>& shared, const UniqueFd& event) {
        static_assert(std::atomic<Word>::is_always_lock_free);
        if (shared.load(std::memory_order_relaxed) != word) {
            shared.store(word, std::memory_order_release);
            set_event(event);
        }
    }
    static void set_event(const UniqueFd& event);
    static void clear_event(const UniqueFd& event);

    static constexpr Duration kMostAge = std::chrono::seconds(1);

    std::atomic<LineLevels> levels_{kNoLineActive};
    std::atomic<std::int64_t> looked_at_ns_ = 0;
    std::atomic<LineStates> states_{LineStates{}};
    std::deque<std::atomic<std::int64_t>> fresh_ns_;
    UniqueFd data_event_;
    UniqueFd lines_event_;
};

}  // namespace tribus
