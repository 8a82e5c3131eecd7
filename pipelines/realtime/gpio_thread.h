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
#include "pipelines/debouncer.h"
#include "pipelines/line_wave.h"
#include "pipelines/line_words.h"
#include "pipelines/realtime/line_exchange.h"
#include "pipelines/settings.h"
#include "transports/links/gpio_line.h"

namespace tribus {

/// A line that is open, one of the two.
struct HeldLine {
    std::unique_ptr<GpioInput> input{};
    std::unique_ptr<GpioOutput> output{};
};

struct GpioThreadSettings {
    /// SCHED_FIFO at this priority where that is permitted; nothing: as any other thread.
    std::optional<int> priority{};
};

/// Keeps the GPIO lines: reads and debounces the inputs, makes lamps blink and waves go.
///
/// A thread of its own beside the data thread, which must not wait for a line on a slow bus, and
/// the main thread, which may be stuck in its log or in a device that it opens: a forced failsafe
/// must not wait for that. It exists only where lines are configured. Thread-bound to the main
/// thread; what says otherwise is inside.
class GpioThread {
  public:
    /// A line for each task; null where it is missing and will be given. Reads the inputs and tells
    /// their levels, so that a failsafe that is forced at the start is so from the first frame.
    GpioThread(LineExchange& exchange, const std::vector<LineTask>& tasks,
               std::vector<std::unique_ptr<HeldLine>> lines, GpioThreadSettings settings);
    GpioThread(const GpioThread&) = delete;
    GpioThread& operator=(const GpioThread&) = delete;
    /// Ends the thread and gives the lines back, those of inverters last.
    ~GpioThread();

    /// The error is a sentence.
    tl::expected<void, std::string> start();
    /// Waves stop where they are, lamps and switches go off, alarms stay.
    void end();

    /// The line that was given up because its chip is gone, if it has not been taken yet.
    std::unique_ptr<HeldLine> take_lost(std::size_t line);
    /// A fresh one for a line whose lost one was taken.
    void give(std::size_t line, std::unique_ptr<HeldLine> held);

  private:
    struct Line {
        explicit Line(const LineTask& its_task, Instant now)
            : task(its_task), contact(its_task.debounce), wave(its_task.period, now) {}

        LineTask task;
        std::unique_ptr<HeldLine> held;
        Debouncer contact;
        FreshWave wave;
        std::optional<bool> said;
        bool moved = false;
        std::atomic<HeldLine*> lost{nullptr};
        std::atomic<HeldLine*> given{nullptr};
    };

    static void* main(void* self);
    void run();
    /// Returns after an edge, a ring of the bell, or at `until`.
    void wait(Instant until);
    void accept_given_lines();
    void read_inputs(Instant now, bool all);
    void show_outputs(Instant now, bool all);
    bool wanted(std::size_t index, Instant now);
    void say(Line& line, bool active);
    void lose(Line& line);
    Instant next_deadline(Instant now) const;

    LineExchange& exchange_;
    GpioThreadSettings settings_;
    std::deque<Line> lines_;
    LineLevels levels_;
    std::array<pollfd, kMostLines + 1> polled_{};
    Instant next_look_{};
    std::atomic<bool> end_requested_{false};
    bool started_ = false;
    pthread_t thread_{};
};

}  // namespace tribus
