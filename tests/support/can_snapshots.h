#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/can_frame.h"
#include "core/channel_frame.h"
#include "core/time.h"
#include "transports/codecs/native_can/channels.h"

/// Snapshots of channels on their way over a CAN bus in the native format.
namespace tribus::test {

using std::chrono::microseconds;
using std::chrono::milliseconds;

using CanFrames = std::vector<CanFrame>;

inline constexpr Duration kCanPeriod = milliseconds(10);

/// Time that all tests count from one common start; zero means "never received".
constexpr Instant can_time(Duration since_start) {
    return Instant{} + std::chrono::seconds(1000) + since_start;
}

inline const std::array kCanFormats{
    CanChannelsFormat{},
    CanChannelsFormat{.crc = CanChannelsCrc::p01},
    CanChannelsFormat{.extended = true, .channels = 16},
    CanChannelsFormat{.fd = true},
};

/// 18 channels that differ from those of every other number below 1000. Every variant can transmit
/// the values exactly.
inline ChannelFrame numbered_snapshot(int number, Instant received = can_time({})) {
    ChannelFrame snapshot;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        snapshot.set(channel, Pulse::from_microseconds(1000 + number + static_cast<int>(channel)));
    }
    snapshot.set(16, number % 2 == 0 ? kSwitchOffPulse : kSwitchOnPulse);
    snapshot.set(17, number % 3 == 0 ? kSwitchOffPulse : kSwitchOnPulse);
    snapshot.frame_lost = snapshot.failsafe = false;
    snapshot.received = received;
    return snapshot;
}

inline CanFrames can_frames(CanChannelsEncoder& encoder, const ChannelFrame& snapshot,
                            Instant now = can_time({})) {
    std::array<CanFrame, kMostSnapshotFrames> frames{};
    const std::size_t count = encoder.write(snapshot, frames, now);
    return {frames.begin(), frames.begin() + static_cast<std::ptrdiff_t>(count)};
}

/// Returns what a decoder publishes when frames arrive together.
inline std::vector<ChannelFrame> feed(CanChannelsDecoder& decoder, const CanFrames& frames,
                                      Instant received) {
    std::vector<ChannelFrame> published;
    for (const CanFrame& frame : frames) {
        if (const auto snapshot = decoder.next(frame, received)) {
            published.push_back(*snapshot);
        }
    }
    return published;
}

inline std::uint64_t rejected(const CanChannelsDecoder& decoder, std::string_view cause) {
    for (const NamedCount& entry : decoder.rejected()) {
        if (entry.name == cause) {
            return entry.count;
        }
    }
    return ~std::uint64_t{0};
}

/// A sender and a receiver of one variant with a bus between them, and the current time.
class CanPair {
  public:
    explicit CanPair(const CanChannelsFormat& format = {}) : encoder(format), decoder(format) {}

    /// Advances time by one period and returns the frames of the next snapshot.
    CanFrames send(const ChannelFrame& snapshot) {
        now += kCanPeriod;
        return can_frames(encoder, snapshot, now);
    }
    std::vector<ChannelFrame> receive(const CanFrames& frames) {
        return feed(decoder, frames, now);
    }
    /// Sends snapshots until the decoder has enough proof and publishes.
    void get_started() {
        for (unsigned count = 0; count <= CanChannelsDecoder::kProof; ++count) {
            receive(send(numbered_snapshot(static_cast<int>(count), now + kCanPeriod)));
        }
    }

    CanChannelsEncoder encoder;
    CanChannelsDecoder decoder;
    Instant now = can_time({});
};

}  // namespace tribus::test
