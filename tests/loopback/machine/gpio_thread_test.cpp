#include "pipelines/realtime/gpio_thread.h"

#include <sys/eventfd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "pipelines/realtime/clock.h"
#include "tests/support/seen_within.h"
#include "transports/links/gpio/gpio_library.h"
#include "transports/links/unique_fd.h"

namespace tribus::test::gpio_thread_test {
namespace {

using namespace std::chrono_literals;

/// A line as the kernel gives it. It must outlive the thread.
struct Wire {
    UniqueFd edges{::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)};
    std::atomic<bool> level = false;
    std::atomic<bool> noisy = false;
    std::atomic<int> reads = 0;
    std::atomic<int> changes = 0;

    void move(bool to) {
        level = to;
        ::eventfd_write(edges.get(), 1);
    }
    /// From now on there is always an edge to read, and each read finds another level.
    void make_noise() {
        noisy = true;
        ::eventfd_write(edges.get(), 1);
    }
};

class WiredLine final : public GpioHeldLine {
  public:
    explicit WiredLine(Wire& wire) : wire_(wire) {}
    bool set(bool active) override {
        wire_.changes += wire_.level.exchange(active) != active ? 1 : 0;
        return true;
    }
    std::optional<bool> get() const override {
        return wire_.noisy ? wire_.reads % 2 == 0 : wire_.level.load();
    }
    int descriptor() const override { return wire_.edges.get(); }
    std::optional<std::size_t> read_edges(std::span<GpioEdge> edges) override {
        ++wire_.reads;
        eventfd_t count = 0;
        if (!wire_.noisy && ::eventfd_read(descriptor(), &count) != 0) {
            return 0;
        }
        edges[0] = {static_cast<std::uint64_t>(awake_time_now().count()), false};
        return 1;
    }

  private:
    Wire& wire_;
};

/// The thread with one line that forces failsafe.
class Bench {
  public:
    Bench(Wire& wire, Duration debounce) {
        EXPECT_TRUE(exchange_.prepare());
        std::vector<std::unique_ptr<HeldLine>> lines;
        lines.push_back(std::make_unique<HeldLine>(
            HeldLine{std::make_unique<GpioInput>(std::make_unique<WiredLine>(wire)), nullptr}));
        const LineTask task{.role = LineRole::force_failsafe, .debounce = debounce};
        thread_ = std::make_unique<GpioThread>(exchange_, std::vector{task}, std::move(lines),
                                               GpioThreadSettings{});
        EXPECT_TRUE(thread_->start());
    }

    std::optional<bool> level() const { return exchange_.levels(monotonic_now()).of(0); }
    /// Returns how long it took until the line had that level; nothing after half a minute.
    std::optional<Duration> time_until(bool level) const {
        const Instant begin = monotonic_now();
        while (monotonic_now() - begin < 30s) {
            if (this->level() == level) {
                return monotonic_now() - begin;
            }
            std::this_thread::sleep_for(100us);
        }
        return std::nullopt;
    }

  private:
    LineExchange exchange_{1};
    std::unique_ptr<GpioThread> thread_;
};

/// Expects that a noisy line is read at most once in `period` and, besides, five times a second.
void expect_few_reads_of_noise(Duration debounce, Duration period) {
    Wire wire;
    const Instant begin = monotonic_now();
    const Bench bench(wire, debounce);
    wire.make_noise();
    std::this_thread::sleep_for(500ms);
    const int reads = wire.reads;
    const Duration took = monotonic_now() - begin;
    EXPECT_LE(reads, took / period + took / 200ms + 5) << took / 1ms << " ms";
}

TEST(GpioThread, ReadsANoisyLineOnceInTheTimeOfItsDebouncing) {
    expect_few_reads_of_noise(20ms, 20ms);
}

TEST(GpioThread, ReadsANoisyLineThatIsNotDebouncedOnceAMillisecond) {
    expect_few_reads_of_noise(0ms, 1ms);
}

TEST(GpioThread, StillTakesALevelThatStandsOnceItsDebouncingIsOver) {
    Wire wire;
    const Bench bench(wire, 50ms);
    ASSERT_TRUE(bench.time_until(false));
    wire.move(true);
    const auto took = bench.time_until(true);
    ASSERT_TRUE(took);
    EXPECT_GE(*took, 49ms);
}

TEST(GpioThread, TakesTheLevelAtWhichAnUndebouncedLineCameToRest) {
    Wire wire;
    const Bench bench(wire, 0ms);
    for (const bool level : {true, false, true, false, true}) {
        wire.move(level);
    }
    EXPECT_TRUE(bench.time_until(true));
    for (const bool level : {false, true, false}) {
        wire.move(level);
    }
    EXPECT_TRUE(bench.time_until(false));
}

/// Each role that is an output, while one output is under control, until the data thread stands:
/// then nobody tells the thread anything new.
class LinesOfAStandingDataThread : public testing::Test {
  protected:
    LinesOfAStandingDataThread() {
        EXPECT_TRUE(exchange_.prepare());
        std::vector<std::unique_ptr<HeldLine>> lines;
        for (Wire& wire : wires_) {
            lines.push_back(std::make_unique<HeldLine>(HeldLine{
                nullptr, std::make_unique<GpioOutput>(std::make_unique<WiredLine>(wire))}));
        }
        std::vector<LineTask> tasks;
        for (const LineRole role : kRoles) {
            tasks.push_back({.role = role, .outputs = {0}, .period = 10ms});
        }
        thread_ =
            std::make_unique<GpioThread>(exchange_, tasks, std::move(lines), GpioThreadSettings{});
        EXPECT_TRUE(thread_->start());
        exchange_.set_states({.on = line_bit(0) | line_bit(1) | line_bit(2) | line_bit(3)});
        EXPECT_TRUE(seen_within([this] {
            exchange_.set_fresh(0, monotonic_now());
            return of(LineRole::fresh).changes >= 4;
        })) << "it has a wave";
    }
    Wire& of(LineRole role) {
        return wires_[static_cast<std::size_t>(std::ranges::find(kRoles, role) - kRoles.begin())];
    }

    static constexpr std::array kRoles{LineRole::link, LineRole::failsafe, LineRole::channel_switch,
                                       LineRole::inverter, LineRole::fresh};
    std::array<Wire, kRoles.size()> wires_;
    LineExchange exchange_{1};
    std::unique_ptr<GpioThread> thread_;
};

TEST_F(LinesOfAStandingDataThread, KeepTheirLevelsButTheWaveEnds) {
    // On a busy machine the wave ends later.
    EXPECT_TRUE(seen_within([this] {
        for (Wire& wire : wires_) {
            wire.changes = 0;
        }
        std::this_thread::sleep_for(300ms);
        return std::ranges::all_of(wires_, [](const Wire& wire) { return wire.changes == 0; });
    }));
    EXPECT_TRUE(of(LineRole::link).level) << "a lamp still shows control";
    EXPECT_TRUE(of(LineRole::channel_switch).level);
}

TEST_F(LinesOfAStandingDataThread, AtTheEndLampsAndSwitchesAreOffAndAlarmsAndInvertersStay) {
    thread_->end();
    EXPECT_FALSE(of(LineRole::link).level);
    EXPECT_FALSE(of(LineRole::channel_switch).level);
    EXPECT_TRUE(of(LineRole::failsafe).level);
    EXPECT_TRUE(of(LineRole::inverter).level);
}

}  // namespace
}  // namespace tribus::test::gpio_thread_test
