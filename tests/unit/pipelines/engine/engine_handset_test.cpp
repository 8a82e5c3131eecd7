#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "pipelines/engine/engine.h"
#include "pipelines/virtual_time/virtual_loop.h"
#include "tests/reference/plain_crsf.h"
#include "tests/support/streams.h"
#include "transports/codecs/crsf/crsf.h"
#include "transports/codecs/crsf/handset.h"

/// From a receiver to a transmitter module that says when it wants the next frame, as modules of
/// ExpressLRS do (docs/protocols/crsf.md, "Towards a transmitter module").
namespace tribus::test::engine_handset_test {
namespace {

using namespace std::chrono_literals;
using reference::plain_crsf;

constexpr Station kReplies{StationKind::replies, 0};

Instant at(Duration since_start) {
    return Instant(1h) + since_start;
}

template <class Only>
std::vector<Only> list(Only only) {
    std::vector<Only> all;
    all.push_back(std::move(only));
    return all;
}

InputSettings radio() {
    InputSettings input;
    input.name = "radio";
    input.decoder = std::make_unique<CrsfDecoder>();
    input.supervision.timeout = CrsfDecoder::kNoChannelsAfter;
    return input;
}

OutputSettings module_output(Duration period) {
    OutputSettings output;
    output.name = "module";
    output.encoder = std::make_unique<CrsfHandsetEncoder>(std::nullopt);
    output.schedule.kind = ScheduleKind::grid;
    output.schedule.period = period;
    output.selection.inputs = {0};
    output.failsafe.action = FailsafeAction::silence;
    return output;
}

Duration scaled(Duration duration, double factor) {
    return Duration(static_cast<std::int64_t>(static_cast<double>(duration.count()) * factor));
}

/// The word of a module about its timing: numbers of 0.1 us, high byte first.
Bytes timing(std::int64_t period, std::int64_t later) {
    Bytes payload{0xEA, 0xEE, 0x10};
    for (const std::int64_t number : {period, later}) {
        for (int shift = 24; shift >= 0; shift -= 8) {
            payload.push_back(static_cast<std::uint8_t>(number >> shift));
        }
    }
    return plain_crsf(0xEA, 0x3A, payload);
}

/// Sends to the air at each point of a clock of its own, and wants each frame kMargin before. Each
/// 200 ms it says its period and how much too early the latest frame was. Times of its own clock
/// are `clock_error` longer than those of the program.
class Module {
  public:
    static constexpr Duration kMargin = 100us;
    static constexpr Duration kSays = 200ms;

    Module(Duration period, double clock_error, Duration first_point)
        : period_(period),
          real_ns_(static_cast<double>(period.count()) * (1 + clock_error)),
          first_(static_cast<double>(first_point.count())) {}

    /// From the arrival of a frame to the point of the air behind it.
    Duration ahead(Duration arrived) const {
        const double turns = (static_cast<double>(arrived.count()) - first_) / real_ns_;
        const double part = turns - std::floor(turns);
        return Duration(static_cast<std::int64_t>((1 - part) * real_ns_));
    }
    /// Its message after a frame that arrived then.
    Bytes says(Duration arrived) const {
        return timing(period_.count() / 100, (ahead(arrived) - kMargin).count() / 100);
    }

  private:
    Duration period_;
    double real_ns_;
    double first_;
};

class HandsetBench final : public StationObserver {
  public:
    /// 26 bytes at 400000 baud.
    static constexpr Duration kFrameTime = 650us;

    explicit HandsetBench(Duration period)
        : engine_(list(radio()), list(module_output(period))), loop_(engine_, *this, at(0s)) {}

    void wrote(Station /*station*/, Instant when, const Transmission& sent) override {
        EXPECT_EQ(sent.bytes()[0], 0xEE);
        sent_.push_back(when - at(0s));
    }
    /// Lets the receiver send at 150 Hz until then, and the module say its timing behind a frame.
    void fly(Duration until, const Module* module) {
        for (; now_ < until; now_ += 100us) {
            loop_.run_until(at(now_));
            if (now_ >= next_frame_) {
                next_frame_ += 6667us;
                const Bytes frame = plain_crsf(0xC8, 0x16, reference::plain_crsf_packed({}));
                loop_.receive(input_station(0), frame, at(now_));
            }
            if (module != nullptr && !sent_.empty() && now_ >= next_word_ &&
                now_ >= sent_.back() + kFrameTime + 200us) {
                next_word_ += Module::kSays;
                loop_.receive(kReplies, module->says(sent_.back() + kFrameTime), at(now_));
            }
        }
    }
    /// How far the frames since then are from where the module wants them, sorted.
    std::vector<Duration> misses(const Module& module, Duration since, Duration period) const {
        std::vector<Duration> misses;
        for (const Duration sent : sent_) {
            if (sent >= since) {
                const Duration off = module.ahead(sent + kFrameTime) - Module::kMargin;
                misses.push_back(std::min(std::chrono::abs(off), std::chrono::abs(off - period)));
            }
        }
        std::ranges::sort(misses);
        return misses;
    }

    const std::vector<Duration>& sent() const { return sent_; }
    /// The receiver falls silent, or comes back.
    void set_receiver(bool sends) { next_frame_ = sends ? now_ : Duration::max(); }
    /// The module's words arrive.
    void hear(const Bytes& bytes) { loop_.receive(kReplies, bytes, at(now_)); }

  private:
    Engine engine_;
    VirtualLoop loop_;
    Duration now_{};
    Duration next_frame_{};
    Duration next_word_ = 300ms;
    std::vector<Duration> sent_;
};

TEST(EngineHandset, HoldsThePhaseThatTheModuleAsksFor) {
    for (const Duration period : {Duration(2ms), Duration(4ms), Duration(6666667ns)}) {
        for (const double clock_error : {-100e-6, 0.0, 100e-6}) {
            for (const double begins : {0.0, 0.3, 0.6, 0.9}) {
                HandsetBench bench(4ms);
                const Module module(period, clock_error, scaled(period, begins));
                bench.fly(12s, &module);
                const auto off = bench.misses(module, 2s, period);
                ASSERT_GT(off.size(), static_cast<std::size_t>(9s / period));
                EXPECT_LE(off[off.size() * 99 / 100], 50us)
                    << period.count() << " " << clock_error << " " << begins;
            }
        }
    }
}

TEST(EngineHandset, KeepsItsOwnPeriodWithoutAModuleThatAsks) {
    HandsetBench bench(4ms);
    bench.fly(2s, nullptr);
    const auto& sent = bench.sent();
    ASSERT_GT(sent.size(), 300U);
    for (std::size_t i = 1; i < sent.size(); ++i) {
        ASSERT_EQ(sent[i] - sent[i - 1], 4ms);
    }
}

TEST(EngineHandset, IsSilentWithoutAnInputAndInPhaseWhenItReturns) {
    HandsetBench bench(4ms);
    const Module module(4ms, 50e-6, 1ms);
    bench.fly(3s, &module);
    bench.set_receiver(false);
    bench.fly(5s, &module);
    const std::size_t before = bench.sent().size();
    bench.fly(6s, &module);
    EXPECT_EQ(bench.sent().size(), before);
    bench.set_receiver(true);
    bench.fly(9s, &module);
    const auto off = bench.misses(module, 7500ms, 4ms);
    ASSERT_GT(off.size(), 300U);
    EXPECT_LE(off[off.size() * 99 / 100], 50us);
}

TEST(EngineHandset, WhatIsAskedTwiceInAPeriodIsDoneOnce) {
    for (const int times : {1, 2, 5}) {
        HandsetBench bench(4ms);
        bench.fly(2s, nullptr);
        const Duration latest = bench.sent().back();
        for (int time = 0; time < times; ++time) {
            bench.hear(timing(40000, 3000));
        }
        bench.fly(2020ms, nullptr);
        const auto next = std::ranges::upper_bound(bench.sent(), latest);
        EXPECT_EQ(*next - latest, 4300us) << times;
        EXPECT_EQ(*(next + 1) - *next, 4ms) << times;
    }
}

TEST(EngineHandset, LimitsWhatIsAskedFor) {
    const auto step_after = [](std::uint32_t period, std::int32_t later) {
        HandsetBench bench(4ms);
        bench.fly(2001ms, nullptr);
        const Duration latest = bench.sent().back();
        bench.hear(timing(period, later));
        bench.fly(2200ms, nullptr);
        return *std::ranges::upper_bound(bench.sent(), latest) - latest;
    };
    EXPECT_EQ(step_after(40000, 1'000'000), 8ms);
    EXPECT_EQ(step_after(40000, -1'000'000), 2ms);
    EXPECT_EQ(step_after(4'000'000, 0), OutputSettings::kMostAskedPeriod);
    EXPECT_EQ(step_after(10, 0), OutputSettings{}.least_asked_period);
}

}  // namespace
}  // namespace tribus::test::engine_handset_test
