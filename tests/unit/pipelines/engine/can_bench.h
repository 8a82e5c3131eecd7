#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "pipelines/engine/engine.h"
#include "pipelines/virtual_time/virtual_loop.h"
#include "tests/support/can_snapshots.h"
#include "transports/codecs/native_can/channels.h"
#include "transports/codecs/sbus/sbus.h"

/// A bench for tests of the engine with CAN.
namespace tribus::test::on_can {

inline constexpr Duration kPeriod = milliseconds(10);
inline constexpr Duration kTimeout = milliseconds(100);

/// Time after the start of the engine.
inline Instant at(Duration since_start) {
    return can_time(since_start);
}

inline InputSettings can_input(const CanChannelsFormat& format = {}) {
    return {.name = "cockpit",
            .decoder = std::make_unique<CanChannelsDecoder>(format),
            .supervision = {.timeout = kTimeout}};
}

/// The output is due every 10 ms from the start on.
inline OutputSettings output_to(AnyEncoder encoder, FailsafeSettings failsafe) {
    failsafe.presets.fill(kCentrePulse);
    return {.name = "out",
            .encoder = std::move(encoder),
            .schedule = {.kind = ScheduleKind::grid, .period = kPeriod},
            .selection = {.inputs = {0}},
            .channels = {},
            .failsafe = failsafe};
}
inline OutputSettings sbus_output(const FailsafeSettings& failsafe = {}) {
    return output_to(std::make_unique<SbusEncoder>(), failsafe);
}
/// Uses other ids than the input.
inline constexpr CanChannelsFormat kOutputFormat{.base_id = 0x400};
inline OutputSettings can_output(const FailsafeSettings& failsafe = {}) {
    return output_to(std::make_unique<CanChannelsEncoder>(kOutputFormat), failsafe);
}

inline std::vector<OutputSettings> list(OutputSettings first) {
    std::vector<OutputSettings> settings;
    settings.push_back(std::move(first));
    return settings;
}
inline std::vector<OutputSettings> list(OutputSettings first, OutputSettings second) {
    std::vector<OutputSettings> settings = list(std::move(first));
    settings.push_back(std::move(second));
    return settings;
}
inline std::vector<InputSettings> list(InputSettings only) {
    std::vector<InputSettings> settings;
    settings.push_back(std::move(only));
    return settings;
}

/// What an output wrote at one time: bytes or frames.
struct Seen {
    Instant at;
    std::vector<std::uint8_t> bytes;
    CanFrames frames;

    bool failsafe() const {
        return frames.empty() ? sbus().failsafe : parse_can_quad(frames[0].bytes()).status.failsafe;
    }
    bool frame_lost() const {
        return frames.empty() ? sbus().frame_lost
                              : parse_can_quad(frames[0].bytes()).status.frame_lost;
    }
    SbusFrame sbus() const { return parse_sbus(std::span(bytes).first<kSbusFrameLength>()); }
};

/// An engine with one CAN input under virtual time, a sender on its bus, and what the outputs
/// wrote.
class Bench final : public StationObserver {
  public:
    explicit Bench(std::vector<OutputSettings> outputs, const CanChannelsFormat& format = {})
        : format_(format),
          sender_(format),
          engine_(list(can_input(format)), std::move(outputs)),
          seen_(engine_.outputs().size()),
          loop_(engine_, *this, at({})) {}

    void wrote(Station station, Instant when, const Transmission& sent) override {
        seen_[station.index].push_back({when,
                                        {sent.bytes().begin(), sent.bytes().end()},
                                        {sent.can_frames().begin(), sent.can_frames().end()}});
    }

    void arrive(const CanFrames& frames, Instant when) {
        for (const CanFrame& frame : frames) {
            loop_.receive(input_station(0), frame, when);
        }
    }
    /// Sends a snapshot that arrives at `when`. Its values were `age` old then.
    void snapshot(Instant when, int number, Duration age = {}) {
        arrive(can_frames(sender_, numbered_snapshot(number, when - age), when), when);
    }
    void marked_snapshot(Instant when, bool frame_lost, bool failsafe) {
        ChannelFrame marked = numbered_snapshot(900, when);
        marked.frame_lost = frame_lost;
        marked.failsafe = failsafe;
        arrive(can_frames(sender_, marked, when), when);
    }
    /// Sends one snapshot in the middle of each 10 ms.
    void snapshots(Instant from, Instant until) {
        for (Instant when = from + milliseconds(5); when < until; when += kPeriod) {
            snapshot(when, ++number_);
        }
    }
    void run_until(Instant when) { loop_.run_until(when + Duration(1)); }

    /// Runs until `when` and returns what the output wrote last.
    Seen said(Instant when, std::size_t output = 0) {
        run_until(when);
        Seen latest;
        for (const Seen& seen : seen_[output]) {
            latest = seen.at <= when ? seen : latest;
        }
        return latest;
    }
    const std::vector<Seen>& seen(std::size_t output = 0) const { return seen_[output]; }
    const Input& input() const { return engine_.inputs()[0]; }
    const OutputCounts& output_counts() const { return engine_.outputs()[0].counts(); }
    Engine& engine() { return engine_; }
    VirtualLoop& loop() { return loop_; }
    int number() const { return number_; }

  private:
    CanChannelsFormat format_;
    CanChannelsEncoder sender_;
    Engine engine_;
    std::vector<std::vector<Seen>> seen_;
    VirtualLoop loop_;
    int number_ = 0;
};

}  // namespace tribus::test::on_can
