#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/learn/loss_study.h"
#include "core/channel_frame.h"
#include "core/time.h"

/// Behaviour of real receivers that lose their transmitter: docs/protocols/ibus.md, "Loss of
/// signal", and docs/protocols/sbus.md, "Flags".
namespace tribus::test {

/// What shows that the transmitter is lost.
enum class ToldBy : std::uint8_t { silence, flag, frame_lost, value, standing_still, nothing };

struct KnownReceiver {
    std::string_view name;
    std::string_view protocol;
    Duration period{};
    /// Returns what the receiver sends at this time after the loss, given the last live frame, or
    /// nothing if it is silent.
    std::function<std::optional<ChannelFrame>(Duration, const ChannelFrame& last)> lost;
    ToldBy told_by = ToldBy::nothing;
    /// Returns what the receiver sends at this time after the transmitter is back. If absent: the
    /// live frame.
    std::function<ChannelFrame(Duration, const ChannelFrame& live)> back{};
    /// The potentiometers of the transmitter tremble, as those of analogue sticks do.
    bool trembling = true;
};
const std::vector<KnownReceiver>& known_receivers();

/// Returns the frame that the pilot sends at this time after the start.
using Flight = std::function<ChannelFrame(Duration)>;

/// A pilot who moves every stick and switch to its ends for ten seconds and then lets go.
ChannelFrame pilot(Duration since_start, bool trembling);

/// Times of a study: transmitter off after 15 s, back after 25 s, end after 30 s.
LossStudyTimes study_times();
Instant study_end();

/// One frame on the wire with the time of its last byte.
struct WireFrame {
    Instant at;
    std::vector<std::uint8_t> bytes;
};
/// Returns all that the receiver sends from the start to `study_end`.
std::vector<WireFrame> wire_of(const KnownReceiver& receiver, const Flight& flight);

}  // namespace tribus::test
