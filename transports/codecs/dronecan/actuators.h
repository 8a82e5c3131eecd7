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
#include "transports/codecs/dronecan/node_identity.h"
#include "transports/codecs/dronecan/source.h"
#include "transports/codecs/dronecan/transfer.h"
#include "transports/codecs/dronecan/types_command.h"

/// Channels as commands for servos (uavcan.equipment.actuator.ArrayCommand) and motors
/// (uavcan.equipment.esc.RawCommand), both directions (docs/protocols/can.md, "DroneCAN:
/// commands").
namespace tribus::dronecan {

enum class CommandKind : std::uint8_t { servos, motors };

/// How an input treats a vehicle that reports that it is not safe to move: by SafetyState, and for
/// motors also by ArmingStatus.
enum class SafetyRule : std::uint8_t {
    heard,     ///< failsafe while it reports "unsafe"; a vehicle that reports nothing may move
    required,  ///< failsafe unless it reports "safe", repeatedly
    ignored,
};

struct CommandInputFormat {
    CommandKind kind = CommandKind::servos;
    SourceChoice source{};
    /// Number of the actuator, or index of the motor from 0, that is channel 1.
    std::uint8_t first = 1;
    std::size_t channels = kChannelCount;
    /// Motors: 1500 us is standstill. Otherwise 1000 us is standstill and motors only turn
    /// forwards.
    bool reversible = false;
    SafetyRule safety = SafetyRule::heard;
    bool fd = false;  ///< accepts FD frames too
};

/// Commands in, snapshots out. A vehicle may spread its commands over several messages. A snapshot
/// has the latest command of each actuator, and its age is that of the oldest: an actuator that is
/// no longer commanded is a loss, not a value that stays for ever. If the transfer id of the
/// commands goes back, or further ahead than the time allows, commands are refused until it has
/// gone through its whole range (`CounterWatch`). Thread-bound.
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
        Instant received = Instant::min();
    };

    /// Each returns whether the commands are accepted, and counts the cause if not.
    bool take_command(const ReceivedTransfer& transfer);
    bool take_servos(const ReceivedTransfer& transfer);
    bool take_motors(const ReceivedTransfer& transfer);
    bool refuse_layout();
    /// Whether a readable message is accepted.
    bool accepts(const ReceivedTransfer& transfer);
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
    /// When each channel was commanded last; `Instant::min()`: never.
    std::array<Instant, kChannelCount> commanded_;
    Instant latest_ = Instant::min();
    Permission safety_;
    Permission arming_;
    std::array<std::uint16_t, 1> detail_values_{};
    std::array<FrameDetail, 1> details_;
};

struct CommandOutputFormat {
    /// The node that it sends as, if no node sets another one: in a recording.
    NodeId node = kNobody;
    CommandKind kind = CommandKind::servos;
    bool fd = false;
    std::uint8_t first = 1;  ///< as for an input
    std::size_t channels = 4;
    bool pulses = false;      ///< servos: commands in microseconds, not in -1 to 1
    bool reversible = false;  ///< as for an input
    /// Permits the nodes to move: sends SafetyState, and for motors also ArmingStatus.
    bool arms = false;

    static constexpr std::uint8_t kServoPriority = 8;
    static constexpr std::uint8_t kMotorPriority = 7;
};

/// Snapshots in, commands out. Absent channels are not commanded; an absent motor within the range
/// is commanded to stand still. These messages cannot signal failsafe, so an actuator that must
/// stop needs silence, or values that stop it. Thread-bound.
class CommandEncoder final : public CanEncoder {
  public:
    explicit CommandEncoder(CommandOutputFormat format)
        : format_(format), own_identity_{format_.node} {}

    bool uses_fd() const override { return format_.fd; }
    std::span<const CanIdMatch> sent() const override { return {}; }
    void send_as(const NodeIdentity& identity) override { identity_ = &identity; }
    /// An actuator without a command is left out. A motor gets 0, which stops it.
    std::uint32_t needed_channels(const ChannelFrame& /*snapshot*/) const override { return 0; }
    bool marks_frame_lost() const override { return false; }
    void continue_from(const Encoder& before) override;
    std::size_t write(const ChannelFrame& snapshot, std::span<CanFrame, kMostSnapshotFrames> frames,
                      Instant now) override;

  private:
    std::size_t encode_servos(const ChannelFrame& snapshot, std::span<CanFrame> frames);
    std::size_t encode_motors(const ChannelFrame& snapshot, std::span<CanFrame> frames);
    std::size_t encode_permissions(const ChannelFrame& snapshot, Instant now,
                                   std::span<CanFrame> frames);
    template <class Message>
    std::size_t encode_message(const Message& message, std::uint8_t priority,
                               std::uint8_t& transfer_id, std::span<CanFrame> frames) const;

    CommandOutputFormat format_;
    NodeIdentity own_identity_;
    const NodeIdentity* identity_ = &own_identity_;
    std::uint8_t command_transfer_id_ = 0;
    std::uint8_t safety_transfer_id_ = 0;
    std::uint8_t arming_transfer_id_ = 0;
    bool ever_in_control_ = false;
    Instant permitted_ = Instant::min();
};

}  // namespace tribus::dronecan
