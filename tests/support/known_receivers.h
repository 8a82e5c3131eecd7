#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/loss_study.h"
#include "core/channel_frame.h"
#include "core/time.h"

/// What receivers in the field do when they lose their transmitter: docs/protocols/ibus.md, "Loss
/// of signal", and docs/protocols/sbus.md, "Flags".
namespace tribus::test {

/// By what a loss can be told.
enum class ToldBy : std::uint8_t { silence, flag, frame_lost, value, standing_still, nothing };

struct KnownReceiver {
    std::string_view name;
    std::string_view protocol;
    Duration period{};
    /// What it sends so long after the loss, from the last live frame; nothing: it is silent.
    std::function<std::optional<ChannelFrame>(Duration, const ChannelFrame& last)> lost;
    ToldBy told_by = ToldBy::nothing;
    /// What it sends so long after the transmitter is back; absent: what is flown.
    std::function<ChannelFrame(Duration, const ChannelFrame& live)> back{};
    /// The transmitter's potentiometers tremble, as they do on analogue sticks.
    bool trembling = true;
};
const std::vector<KnownReceiver>& known_receivers();

/// The frame that is flown so long after the start.
using Flight = std::function<ChannelFrame(Duration)>;

/// A pilot who moves every stick and switch to its ends for ten seconds, then keeps the hands off.
ChannelFrame pilot(Duration since_start, bool trembling);

/// The steps of a study: off after 15 s, back after 25 s, end after 30 s.
LossStudyTimes study_times();
Instant study_end();

/// One frame on the wire, at the instant of its last byte.
struct WireFrame {
    Instant at;
    std::vector<std::uint8_t> bytes;
};
/// All that the receiver sends from the start to `study_end`.
std::vector<WireFrame> wire_of(const KnownReceiver& receiver, const Flight& flight);

}  // namespace tribus::test
