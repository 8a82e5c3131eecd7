#pragma once

#include <poll.h>
#include <pthread.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "core/time.h"
#include "pipelines/realtime/line_exchange.h"
#include "pipelines/rules/debouncer.h"
#include "pipelines/rules/line_wave.h"
#include "pipelines/rules/line_words.h"
#include "pipelines/rules/settings.h"
#include "transports/links/gpio/gpio_line.h"

namespace tribus {

/// An open line: exactly one of the two.
struct HeldLine {
    std::unique_ptr<GpioInput> input{};
    std::unique_ptr<GpioOutput> output{};
};

struct GpioThreadSettings {
    /// SCHED_FIFO priority, used where it is permitted. Absent: normal scheduling.
    std::optional<int> priority{};
};

/// The thread of the GPIO lines: reads and debounces inputs, blinks lamps and generates waves.
///
/// It is a thread of its own because the data thread must not wait for a line on a slow bus, and
/// because a forced failsafe must not wait for the main thread, which may be blocked by its log or
/// by opening a device. It exists only if lines are configured. Thread-bound to the main thread,
/// except where a comment says otherwise.
class GpioThread {
  public:
    /// `lines` has one line for each task, null if it is missing and will be given later. Reads the
    /// inputs, so that a failsafe forced at the start applies from the first frame.
    GpioThread(LineExchange& exchange, const std::vector<LineTask>& tasks,
               std::vector<std::unique_ptr<HeldLine>> lines, GpioThreadSettings settings);
    GpioThread(const GpioThread&) = delete;
    GpioThread& operator=(const GpioThread&) = delete;
    /// Ends the thread and releases the lines, those of inverters last.
    ~GpioThread();

    /// Starts the thread. The error is a sentence.
    tl::expected<void, std::string> start();
    /// Ends the thread. Waves stop, lamps and switches go off, failsafe outputs keep their level.
    void end();

    /// Whether the thread waits for the kernel in a call about a line, as on a chip whose bus
    /// hangs. Thread-safe.
    bool kept_by_kernel() const { return kept_by_kernel_.load(std::memory_order_acquire); }

    /// The line that was given up because its chip is gone. Null if there is none, or it was taken
    /// before.
    std::unique_ptr<HeldLine> take_lost(std::size_t line);
    /// Gives a new line in place of one that was taken by `take_lost`.
    void give(std::size_t line, std::unique_ptr<HeldLine> held);

  private:
    struct Line {
        explicit Line(const LineTask& its_task, Instant now)
            : task(its_task), contact(its_task.debounce), wave(its_task.period, now) {}

        LineTask task;
        std::unique_ptr<HeldLine> held;
        Debouncer contact;
        FreshWave wave;
        std::optional<bool> last_set;
        bool wants_look = false;
        std::atomic<HeldLine*> lost{nullptr};
        std::atomic<HeldLine*> given{nullptr};
    };

    static void* main(void* self);
    void run();
    /// Returns after an edge of a line that does not rest, after the event of `exchange_`, or at
    /// `until`.
    void wait(Instant until);
    void accept_given_lines();
    void read_inputs(Instant now, bool all);
    void read_input(Line& line, Instant now);
    void show_outputs(Instant now, bool all);
    bool wanted(std::size_t index, Instant now);
    void set_line(Line& line, bool active);
    void lose(Line& line);
    Instant next_deadline(Instant now) const;

    LineExchange& exchange_;
    GpioThreadSettings settings_;
    std::deque<Line> lines_;
    LineLevels levels_;
    std::array<pollfd, kMostLines + 1> polled_{};
    Instant next_look_{};
    std::atomic<bool> end_requested_{false};
    std::atomic<bool> kept_by_kernel_{false};
    bool started_ = false;
    pthread_t thread_{};
};

}  // namespace tribus
