#pragma once

#include <array>
#include <bitset>
#include <chrono>
#include <cstdint>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "pipelines/engine/engine.h"
#include "pipelines/virtual_time/virtual_loop.h"
#include "transports/codecs/ibus/ibus.h"
#include "transports/codecs/sbus/sbus.h"

/// A bench for tests of the engine with serial inputs and an SBUS output every 10 ms.
namespace tribus::test::serial {

using namespace std::chrono_literals;

inline Pulse us(std::int64_t microseconds) {
    return Pulse::from_microseconds(microseconds);
}
inline Instant at(Duration since_start) {
    return Instant(since_start);
}

inline InputSettings sbus_input(std::vector<ValueRule> rules = {}) {
    return {.name = "in",
            .decoder = std::make_unique<SbusDecoder>(),
            .supervision = {.timeout = 100ms, .failsafe_when = std::move(rules)}};
}

inline InputSettings ibus_input(std::vector<ValueRule> rules = {}) {
    return {.name = "in",
            .decoder = std::make_unique<IbusDecoder>(),
            .supervision = {.timeout = 100ms, .failsafe_when = std::move(rules)}};
}

inline OutputSettings sbus_output(std::vector<std::size_t> inputs, FailsafeSettings failsafe = {}) {
    failsafe.presets.fill(us(1500));
    failsafe.presets[2] = us(988);
    return {.name = "out",
            .encoder = std::make_unique<SbusEncoder>(),
            .schedule = {.kind = ScheduleKind::grid, .period = 10ms},
            .selection = {.inputs = std::move(inputs)},
            .channels = {},
            .failsafe = failsafe};
}

struct Seen {
    Instant at;
    SbusFrame frame;
};

/// An engine under virtual time, and what its outputs wrote.
class Bench final : public StationObserver {
  public:
    Bench(std::vector<InputSettings> inputs, std::vector<OutputSettings> outputs,
          std::vector<LineTask> lines = {})
        : engine_(std::move(inputs), std::move(outputs), std::move(lines)),
          seen_(engine_.outputs().size()),
          loop_(engine_, *this, Instant{}) {}

    void wrote(Station station, Instant when, const Transmission& sent) override {
        const auto frame = sent.bytes();
        seen_[station.index].push_back({when, parse_sbus(frame.first<kSbusFrameLength>())});
    }

    /// Sends an i.Bus frame with `first` on channel 1.
    void ibus(std::size_t input, Instant when, Pulse first, Pulse third = us(1200)) {
        ChannelFrame frame;
        frame.set(0, first);
        frame.set(2, third);
        send(IbusEncoder(14), input, when, frame);
    }
    void sbus(std::size_t input, Instant when, Pulse first, bool frame_lost, bool failsafe) {
        ChannelFrame frame;
        frame.set(0, first);
        frame.frame_lost = frame_lost;
        frame.failsafe = failsafe;
        send(SbusEncoder(), input, when, frame);
    }
    void ibus_run(std::size_t input, Instant from, Instant until, Pulse first) {
        for (Instant when = from; when < until; when += 8ms) {
            ibus(input, when, first);
        }
    }
    /// Runs until `when` and returns what the output wrote last.
    SbusFrame said(Instant when, std::size_t output = 0) {
        loop_.run_until(when + 1ns);
        SbusFrame latest;
        for (const Seen& seen : seen_[output]) {
            latest = seen.at <= when ? seen.frame : latest;
        }
        return latest;
    }
    const std::vector<Seen>& seen(std::size_t output = 0) const { return seen_[output]; }
    Engine& engine() { return engine_; }
    VirtualLoop& loop() { return loop_; }

    void send(ByteEncoder&& encoder, std::size_t input, Instant when, const ChannelFrame& frame) {
        std::array<std::uint8_t, kLongestSerialFrame> wire{};
        const std::size_t length = encoder.write(frame, wire, Instant{});
        loop_.receive(input_station(input), std::span(wire).first(length), when);
    }

  private:
    Engine engine_;
    std::vector<std::vector<Seen>> seen_;
    VirtualLoop loop_;
};

template <class... Settings>
auto list(Settings... settings) {
    std::vector<std::common_type_t<Settings...>> all;
    (all.push_back(std::move(settings)), ...);
    return all;
}

inline constexpr std::uint16_t raw_of(int microseconds) {
    return static_cast<std::uint16_t>((microseconds - 880) * 8 / 5);
}

}  // namespace tribus::test::serial
