#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "transports/codecs/codec.h"
#include "transports/codecs/mavlink/messages.h"

namespace tribus {

/// A message that carries channels.
enum class MavlinkChannels : std::uint8_t {
    radio_rc_channels,
    rc_channels_override,
    rc_channels,
    manual_control,
};

/// Where the channels stand that an output sends, and to whom.
struct MavlinkSent {
    MavlinkChannels message = MavlinkChannels::radio_rc_channels;
    std::size_t channels = 0;
    std::uint8_t target = 1;

    bool operator==(const MavlinkSent&) const = default;
};

/// Looks in what comes back from an autopilot for what was sent to it: ArduPilot and PX4 show the
/// channels that they act on in RC_CHANNELS, whoever sent them (docs/protocols/mavlink.md,
/// "Sending"). Of MANUAL_CONTROL nothing is looked for, because what it moves has no fixed scale.
/// Signatures are not looked at, because nothing of this becomes control.
class MavlinkAnswers final : public MavlinkMessages {
  public:
    /// So many latest frames are looked for. Answers come late, and sticks move meanwhile.
    static constexpr std::size_t kKept = 32;

    explicit MavlinkAnswers(const MavlinkSent& sent) : MavlinkMessages(std::nullopt), sent_(sent) {}
    /// Keeps the payload of a message that is sent.
    void keep(std::span<const std::uint8_t> payload);
    void hear(std::span<const std::uint8_t> bytes, Instant now);
    /// Goes on from what `before` heard, if that looked for the same.
    void continue_from(const MavlinkAnswers& before);
    Answers answers() const { return answers_; }

  private:
    using Kept = std::array<std::uint8_t, mavlink_wire::kRadioChannelsAt + 2 * kChannelCount>;

    bool take(const MavlinkMessage& message, ChannelFrame& channels) override;
    bool takes_unsigned(std::uint32_t /*id*/) const override { return true; }
    void take_heartbeat(const MavlinkMessage& message);
    bool shows(const Kept& kept, const MavlinkMessage& message) const;

    MavlinkSent sent_;
    std::array<Kept, kKept> kept_{};
    std::size_t next_ = 0;
    std::size_t count_ = 0;
    Answers answers_;
};

}  // namespace tribus
