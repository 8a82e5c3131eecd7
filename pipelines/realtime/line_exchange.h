#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>

#include <string>
#include <tl/expected.hpp>

#include "core/time.h"
#include "pipelines/line_words.h"
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

    /// Sets the levels of the input lines. GPIO thread; before it runs, main thread.
    void tell_levels(LineLevels levels) { tell(levels, levels_, data_bell_); }
    LineLevels levels() const { return levels_.load(std::memory_order_acquire); }
    /// Readable after the levels have changed, until `hush_data`.
    int data_bell() const { return data_bell_.get(); }
    void hush_data() const { hush(data_bell_); }

    /// Sets what the output lines show. Data thread.
    void tell_states(LineStates states) { tell(states, states_, lines_bell_); }
    LineStates states() const { return states_.load(std::memory_order_acquire); }
    /// Readable after the states have changed or `ring_lines` was called, until `hush_lines`.
    int lines_bell() const { return lines_bell_.get(); }
    void hush_lines() const { hush(lines_bell_); }
    void ring_lines() const { ring(lines_bell_); }

    /// An output has handed over fresh data at `now`. Data thread.
    void tell_fresh(std::size_t output, Instant now) {
        fresh_ns_[output].store(now.time_since_epoch().count(), std::memory_order_release);
    }
    /// The oldest of the times at which these outputs last handed over fresh data. `Instant{}` if
    /// one of them never did.
    Instant fresh_at(std::span<const std::size_t> outputs) const;

  private:
    template <class Word>
    static void tell(Word word, std::atomic<Word>& told, const UniqueFd& bell) {
        static_assert(std::atomic<Word>::is_always_lock_free);
        if (told.load(std::memory_order_relaxed) != word) {
            told.store(word, std::memory_order_release);
            ring(bell);
        }
    }
    static void ring(const UniqueFd& bell);
    static void hush(const UniqueFd& bell);

    std::atomic<LineLevels> levels_{kNoLineActive};
    std::atomic<LineStates> states_{LineStates{}};
    std::deque<std::atomic<std::int64_t>> fresh_ns_;
    UniqueFd data_bell_;
    UniqueFd lines_bell_;
};

}  // namespace tribus
