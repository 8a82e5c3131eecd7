#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "app/learn/loss_study.h"
#include "config/build/build.h"
#include "pipelines/virtual_time/virtual_loop.h"
#include "tests/sim/simulation.h"
#include "tests/support/known_receivers.h"
#include "transports/codecs/sbus/sbus.h"

/// Receivers that lose their transmitter, run through `learn` and the whole engine.
namespace tribus::test {

inline std::string job_with(std::string_view protocol, const std::vector<std::string>& lines) {
    return fmt::format(R"([input.receiver]
protocol = "{}"
device   = "/dev/ttyA"
{}
[output.servos]
protocol = "sbus"
device   = "/dev/ttyB"
schedule = "grid"
period   = "10ms"
[pipeline.main]
from = "receiver"
to   = "servos"
)",
                       protocol, fmt::join(lines, "\n"));
}

inline std::vector<StudiedFrame> decoded(const InputConfig& input,
                                         const std::vector<WireFrame>& wire) {
    const auto decoder = make_byte_decoder(*input.protocol, input.settings);
    std::vector<StudiedFrame> frames;
    DecodedFrame found;
    for (const WireFrame& frame : wire) {
        std::span<const std::uint8_t> bytes = frame.bytes;
        while (decoder->next(bytes, frame.at, found)) {
            frames.push_back({frame.at, found.channels});
        }
    }
    return frames;
}

/// Records an output's frames while the receiver loses its link and finds it again.
class LossRun final : public StationObserver {
  public:
    LossRun(const Configuration& configuration, const std::vector<WireFrame>& wire)
        : engine_(build_engine(configuration)) {
        VirtualLoop loop(*engine_, *this, Instant{});
        for (const WireFrame& frame : wire) {
            loop.receive(input_station(0), frame.bytes, frame.at);
        }
        loop.run_until(study_end());
    }
    void wrote(Station /*station*/, Instant at, const Transmission& sent) override {
        if (at < study_times().back) {
            cause_while_lost_ = engine_->inputs()[0].state().cause;
        }
        const SbusFrame frame = parse_sbus(sent.bytes().first<kSbusFrameLength>());
        says_.push_back({at, frame.failsafe});
    }
    std::optional<Duration> to_failsafe() const { return first(study_times().off, true); }
    std::optional<Duration> to_control() const { return first(study_times().back, false); }
    /// Returns whether the output was in control from two seconds after the start until the loss.
    bool always_in_control_before() const {
        return std::ranges::none_of(says_, [](const Says& says) {
            return says.at > Instant(std::chrono::seconds(2)) && says.at < study_times().off &&
                   says.failsafe;
        });
    }
    bool in_failsafe_at(Instant when) const {
        const auto says = std::ranges::find_if(says_, [=](const Says& s) { return s.at >= when; });
        return says != says_.end() && says->failsafe;
    }
    LinkCause cause_while_lost() const { return cause_while_lost_; }

  private:
    struct Says {
        Instant at;
        bool failsafe = false;
    };
    std::optional<Duration> first(Instant from, bool failsafe) const {
        const auto says = std::ranges::find_if(
            says_, [=](const Says& s) { return s.at >= from && s.failsafe == failsafe; });
        return says == says_.end() ? std::nullopt : std::optional(says->at - from);
    }

    std::unique_ptr<Engine> engine_;
    std::vector<Says> says_;
    LinkCause cause_while_lost_ = LinkCause::never_seen;
};

/// Returns what `learn` finds out about the receiver while a pilot moves the sticks.
inline LossStudyResult study(const KnownReceiver& receiver) {
    const Configuration plain = configuration_of(job_with(receiver.protocol, {}));
    const auto wire =
        wire_of(receiver, [&](Duration since) { return pilot(since, receiver.trembling); });
    return study_loss(plain.inputs[0], decoded(plain.inputs[0], wire), study_times());
}

/// Runs the engine with the learned lines over what the receiver sends during `flight`.
inline LossRun run_with(const LossStudyResult& learned, const KnownReceiver& receiver,
                        const Flight& flight) {
    return LossRun(configuration_of(job_with(receiver.protocol, learned.lines)),
                   wire_of(receiver, flight));
}

}  // namespace tribus::test
