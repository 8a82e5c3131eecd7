#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/can_frame.h"
#include "core/channel_frame.h"
#include "core/time.h"
#include "transports/codecs/can_codec.h"
#include "transports/codecs/dronecan/source.h"
#include "transports/codecs/dronecan/transfer.h"
#include "transports/codecs/dronecan/types_command.h"
#include "transports/codecs/dronecan/voice.h"

/// Commands for servos (uavcan.equipment.actuator.ArrayCommand) and for motors
/// (uavcan.equipment.esc.RawCommand) as channels, and channels as such (docs/protocols/can.md,
/// "DroneCAN: commands").
namespace tribus::dronecan {

enum class CommandKind : std::uint8_t { servos, motors };

/// What an input makes of a vehicle that says that it is not safe to move: SafetyState, and for
/// motors ArmingStatus too.
enum class SafetyRule : std::uint8_t {
    heard,     ///< failsafe while it says so; one that never says anything may move
    required,  ///< failsafe unless it says that it may move, and goes on saying so
    ignored,
};

struct CommandInputFormat {
    CommandKind kind = CommandKind::servos;
    SourceChoice source{};
    /// Number of the actuator, or place of the motor from 0, that is channel 1.
    std::uint8_t first = 1;
    std::size_t channels = kChannelCount;
    /// Motors: 1500 us is standstill. Else 1000 us is, and nothing turns backwards.
    bool reversible = false;
    SafetyRule safety = SafetyRule::heard;
    bool fd = false;  ///< takes FD frames too
};

/// Commands in, snapshots out. A vehicle may say its commands in several messages; a snapshot has
/// the latest of each, and counts as old as the oldest of them: an actuator that is commanded no
/// longer is a loss, not a value that stands for ever. Once the transfer id of the commands has
/// gone back, or further on than time allows, they are refused until it has gone through its whole
/// range
/// (`CounterWatch`).
class CommandDecoder final : public CanDecoder {
  public:
    explicit CommandDecoder(CommandInputFormat format);

    std::span<const CanIdMatch> wanted() const override { return wanted_; }
    bool uses_fd() const override { return format_.fd; }
    std::optional<ChannelFrame> next(const CanFrame& frame, Instant received) override;
    std::span<const NamedCount> rejected() const override { return rejected_.counts(); }
    std::span<const FrameDetail> details() const override { return details_; }

  private:
    struct Permission {
        bool granted = false;
        Instant heard = Instant::min();
    };

    /// Each says whether its commands count, and else counts why not.
    bool take_command(const ReceivedTransfer& transfer);
    bool take_servos(const ReceivedTransfer& transfer);
    bool take_motors(const ReceivedTransfer& transfer);
    bool refuse_layout();
    /// Of a message that can be read.
    bool believes(const ReceivedTransfer& transfer);
    void take_permission(const ReceivedTransfer& transfer);
    void set(std::size_t actuator, Pulse pulse, Instant at);
    bool may_move(const Permission& permission, Instant now) const;
    ChannelFrame snapshot(Instant now);

    CommandInputFormat format_;
    std::array<CanIdMatch, 3> wanted_;
    SourceWatch source_;
    TransferReceiver receiver_;
    CounterWatch order_{kTransferOrder};
    TransferRejects rejected_;
    std::array<Pulse, kChannelCount> pulses_{};
    /// When each was commanded last; `Instant::min()`: never.
    std::array<Instant, kChannelCount> commanded_;
    Instant latest_ = Instant::min();
    Permission safety_;
    Permission arming_;
    std::array<std::uint16_t, 1> told_{};
    std::array<FrameDetail, 1> details_;
};

struct CommandOutputFormat {
    /// Whose name it sends in where no node says so: in a recording.
    NodeId node = kNobody;
    CommandKind kind = CommandKind::servos;
    bool fd = false;
    std::uint8_t first = 1;  ///< as for an input
    std::size_t channels = 4;
    bool pulses = false;      ///< servos: commands in microseconds, not in -1 to 1
    bool reversible = false;  ///< as for an input
    /// Says to the others that they may move: SafetyState, and for motors ArmingStatus.
    bool arms = false;

    static constexpr std::uint8_t kServoPriority = 8;
    static constexpr std::uint8_t kMotorPriority = 7;
};

/// Snapshots in, commands out. Channels that are absent are not commanded; the place of an absent
/// motor commands standstill. The types have no way to say failsafe, so whoever is to stop must
/// be given silence, or values that stop it.
class CommandEncoder final : public CanEncoder {
  public:
    explicit CommandEncoder(CommandOutputFormat format)
        : format_(format), own_voice_{format_.node} {}

    bool uses_fd() const override { return format_.fd; }
    std::span<const CanIdMatch> sent() const override { return {}; }
    void speak_as(const Voice& voice) override { voice_ = &voice; }
    /// An actuator without a command is left out; a motor is told 0, which stops it.
    std::uint32_t needed_channels(const ChannelFrame& /*snapshot*/) const override { return 0; }
    bool marks_frame_lost() const override { return false; }
    void continue_from(const CanEncoder& before) override;
    std::size_t encode(const ChannelFrame& snapshot, Instant now,
                       std::span<CanFrame, kMostSnapshotFrames> frames) override;

  private:
    std::size_t encode_servos(const ChannelFrame& snapshot, std::span<CanFrame> frames);
    std::size_t encode_motors(const ChannelFrame& snapshot, std::span<CanFrame> frames);
    std::size_t encode_permissions(const ChannelFrame& snapshot, Instant now,
                                   std::span<CanFrame> frames);
    template <class Message>
    std::size_t encode_message(const Message& message, std::uint8_t priority,
                               std::uint8_t& transfer_id, std::span<CanFrame> frames) const;

    CommandOutputFormat format_;
    Voice own_voice_;
    const Voice* voice_ = &own_voice_;
    std::uint8_t command_transfer_id_ = 0;
    std::uint8_t safety_transfer_id_ = 0;
    std::uint8_t arming_transfer_id_ = 0;
    bool ever_in_control_ = false;
    Instant permitted_ = Instant::min();
};

}  // namespace tribus::dronecan
