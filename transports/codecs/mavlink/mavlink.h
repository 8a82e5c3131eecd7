#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "core/time.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/mavlink/answers.h"
#include "transports/codecs/mavlink/messages.h"
#include "transports/codecs/protocol.h"

/// Channels over MAVLink, to and from autopilots, ground stations and radio links
/// (docs/protocols/mavlink.md).
namespace tribus {

extern const Protocol kMavlinkProtocol;

/// What the throttle of MANUAL_CONTROL, its axis z, means.
enum class MavlinkThrottle : std::uint8_t {
    zero_based,  ///< 0 to 1000 is 1000 to 2000 us: vehicles that do not reverse, and all of PX4
    centred,     ///< -1000 to 1000 is 1000 to 2000 us: ArduPilot's rovers and boats
};

/// Reads channels from one sender. A word that is no pulse is a channel that is not present.
class MavlinkDecoder final : public MavlinkMessages {
  public:
    struct Settings {
        std::optional<MavlinkChannels> message{};  ///< absent: the first kind heard
        std::optional<std::uint8_t> system{};      ///< of the sender; absent: the first one heard
        std::uint8_t target = 1;                   ///< messages to another system are passed over
        std::size_t buttons = 0;                   ///< of MANUAL_CONTROL, as channels from 5 on
        MavlinkThrottle throttle = MavlinkThrottle::zero_based;
        std::optional<SecretKey> key{};  ///< only what is signed with it counts
    };
    explicit MavlinkDecoder(const Settings& settings)
        : MavlinkMessages(settings.key), settings_(settings), sender_(settings.system) {}
    void reset() override;
    std::span<const FrameDetail> details() const override { return details_; }

  private:
    bool take(const MavlinkMessage& message, ChannelFrame& channels) override;
    bool takes_unsigned(std::uint32_t /*id*/) const override { return false; }
    void take_status(const MavlinkMessage& message);
    bool is_wanted(const MavlinkMessage& message, Instant received);
    bool is_for_target(const MavlinkMessage& message) const;

    Settings settings_;
    MavlinkSender sender_;
    /// The systems whose autopilot says in SYS_STATUS that its receiver has no signal. RC_CHANNELS
    /// has no word for that and repeats the last values.
    std::bitset<256> without_signal_;
    std::uint16_t system_ = 0;
    std::array<FrameDetail, 1> details_{{{"system", {&system_, 1}}}};
};

/// Sends one message with channels a frame, and every second a HEARTBEAT behind it. On loss it
/// sends nothing, no HEARTBEAT either, so that every failsafe of the autopilot can act.
class MavlinkEncoder final : public ByteEncoder {
  public:
    struct Settings {
        MavlinkChannels message = MavlinkChannels::radio_rc_channels;
        bool version_1 = false;
        std::uint8_t system = 255;
        std::uint8_t component = 190;
        std::uint8_t target = 1;
        std::size_t channels = 16;
        std::size_t buttons = 0;  ///< channels from 5 on as buttons of MANUAL_CONTROL
        MavlinkThrottle throttle = MavlinkThrottle::zero_based;
        /// On loss, and after a reload that sends fewer channels: gives them back, with
        /// RC_CHANNELS_OVERRIDE.
        bool releases = false;
        std::optional<SecretKey> key{};  ///< signs with it, version 2 only
        std::uint8_t link_id = 0;        ///< in signatures
    };
    explicit MavlinkEncoder(const Settings& settings);
    bool marks_frame_lost() const override {
        return settings_.message == MavlinkChannels::radio_rc_channels;
    }
    std::uint32_t needed_channels(const ChannelFrame& frame) const override;
    std::size_t write(const ChannelFrame& frame, std::span<std::uint8_t, kLongestSerialFrame> wire,
                      Instant now) override;
    std::size_t write_silence(std::span<std::uint8_t, kLongestSerialFrame> wire,
                              Instant now) override;
    void use_clock(const WallClock& clock) override;
    /// What `before` has taken over and this one does not send is given back, if either `releases`:
    /// first, with kReleases messages as `before` sent, where the target, the sender or its key is
    /// another, or the message; else in the next kReleases messages with channels.
    void continue_from(const Encoder& before) override;
    int farewells() const override { return settings_.releases ? kReleases : 0; }
    std::optional<AskedTiming> hear(std::span<const std::uint8_t> bytes, Instant now) override;
    void forget_heard() override;
    Answers answers() const override;

    /// So often channels are given back, because a datagram can get lost.
    static constexpr int kReleases = 10;

    /// Longest frame with a HEARTBEAT, and both signed.
    static constexpr std::size_t kLongest =
        2 * (mavlink_wire::kHeader2Bytes + mavlink_wire::kCrcBytes) +
        mavlink_wire::kRadioChannelsAt + 2 * kChannelCount + mavlink_wire::kHeartbeat.length;
    static constexpr std::size_t kLongestSigned = kLongest + 2 * mavlink_wire::kSignatureBytes;
    static_assert(kLongestSigned <= kLongestSerialFrame);

  private:
    using Payload = std::array<std::uint8_t, mavlink_wire::kMostPayload>;
    /// As whom messages are sent.
    struct Sender {
        bool version_1 = false;
        std::uint8_t system = 0;
        std::uint8_t component = 0;
        std::optional<MavlinkSigner> signer{};
    };
    /// Channels that are given back, one bit each.
    struct Release {
        std::uint32_t channels = 0;
        int left = 0;  ///< messages
    };
    /// What an encoder before this one took over as another sender, of another target, or with a
    /// message that this one has not.
    struct Former {
        Sender sender;
        std::uint8_t target = 0;
        Release release;
    };
    const mavlink_wire::MessageKind& fill(const ChannelFrame& frame, Payload& payload) const;
    void fill_radio(const ChannelFrame& frame, Payload& payload) const;
    void fill_override(const ChannelFrame& frame, Payload& payload) const;
    void fill_manual(const ChannelFrame& frame, Payload& payload) const;
    std::size_t write_message(Sender& sender, const mavlink_wire::MessageKind& kind,
                              const Payload& payload, std::span<std::uint8_t> wire, Instant now);
    std::size_t write_release(Sender& sender, std::uint8_t target, Release& release,
                              std::span<std::uint8_t> wire, Instant now);
    std::uint32_t own_channels() const;
    void give_back_for(const MavlinkEncoder& before);

    Settings settings_;
    Sender sender_;
    MavlinkAnswers answers_;
    std::uint8_t sequence_ = 0;
    std::optional<Instant> heartbeat_at_;  ///< when the next one is due
    /// What it would give back now: its own channels once they were sent.
    Release own_;
    /// Channels of the same target that the encoder before has taken over and this one does not
    /// send.
    Release fewer_;
    std::optional<Former> former_;
};

/// What is wrong by the answers of an autopilot to an output with these settings; see
/// Protocol::advice_by_answers.
std::string mavlink_advice(const MavlinkEncoder::Settings& sent, const Answers& answers);

}  // namespace tribus
