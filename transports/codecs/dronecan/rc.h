#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/can_frame.h"
#include "core/channel_frame.h"
#include "core/time.h"
#include "core/value_board.h"
#include "transports/codecs/can_codec.h"
#include "transports/codecs/dronecan/node_identity.h"
#include "transports/codecs/dronecan/source.h"
#include "transports/codecs/dronecan/transfer.h"
#include "transports/codecs/dronecan/types_command.h"
#include "transports/codecs/sent_number.h"

/// RC channels as dronecan.sensors.rc.RCInput (docs/protocols/can.md, "DroneCAN: RCInput").
namespace tribus::dronecan {

/// Meaning of a sender's channel values.
enum class RcScale : std::uint8_t {
    microseconds,  ///< as the message defines
    sbus,          ///< raw SBUS values of 0.625 us (sent by a node of ENAC)
    full_range,    ///< 0 to 4095 for 1000 to 2000 us (expected by a fork of PX4)
};

/// The unit of a kind of link quality, RcInput::kQualityType...
std::string_view unit_of_quality(std::uint16_t type);

struct RcInputFormat {
    SourceChoice source{};
    RcScale scale = RcScale::microseconds;
    /// Only messages of this receiver; nothing: of any receiver.
    std::optional<std::uint8_t> receiver{};
    bool fd = false;  ///< accepts FD frames too
};

/// RCInput messages in, snapshots out. A message with link quality 0 is marked frame lost, because
/// RCInput has no flag for it. If the transfer id goes back, or further ahead than the time allows,
/// messages are refused until it has gone through its whole range: 0.64 s at 50 Hz
/// (`CounterWatch`). Thread-bound.
class RcDecoder final : public CanDecoder {
  public:
    explicit RcDecoder(RcInputFormat format);

    std::span<const CanIdMatch> wanted() const override { return {&wanted_, 1}; }
    bool uses_fd() const override { return format_.fd; }
    std::optional<ChannelFrame> next(const CanFrame& frame, Instant received) override;
    std::span<const NamedCount> rejected() const override { return rejected_.counts(); }
    std::span<const FrameDetail> details() const override { return details_; }

  private:
    bool accepts(const RcInput& message, const ReceivedTransfer& transfer);
    ChannelFrame channels_of(const RcInput& message, Instant at);
    Pulse pulse_of(std::uint16_t raw) const;
    void note_quality(const RcInput& message, Instant at);

    RcInputFormat format_;
    CanIdMatch wanted_;
    SourceWatch source_;
    TransferReceiver receiver_;
    CounterWatch order_{kTransferOrder};
    TransferRejects rejected_;
    /// The latest quality in percent. Some senders send several kinds of quality in turn.
    std::uint8_t link_quality_ = kNoLinkQuality;
    Instant link_quality_at_{};
    std::array<std::uint16_t, 3> detail_values_{};
    std::array<FrameDetail, 3> details_;
};

enum class RcQuality : std::uint8_t {
    none,
    link,   ///< the link quality of the input, else the percentage of its good frames
    value,  ///< a named value
};

struct RcOutputFormat {
    /// The node that it sends as, if no node sets another one: in a recording.
    NodeId node = kNobody;
    bool fd = false;
    std::uint8_t receiver = 0;  ///< number of the receiver if a node has several: 0 to 15
    std::size_t channels = kChannelCount;
    RcQuality quality = RcQuality::link;
    std::uint16_t quality_type = RcInput::kQualityTypeLinkQuality;
    std::string quality_value{};  ///< name of the value

    static constexpr std::uint8_t kPriority = 8;
};

/// Snapshots in, RCInput messages out. Values that are held after a loss are sent with a valid link
/// quality of 0 %: RCInput has no other mark for old values, and nothing else is sent with 0 %.
/// Failsafe is sent as the flag of RCInput. Thread-bound.
class RcEncoder final : public CanEncoder {
  public:
    explicit RcEncoder(RcOutputFormat format)
        : format_(std::move(format)), own_identity_{format_.node} {}

    bool uses_fd() const override { return format_.fd; }
    std::span<const CanIdMatch> sent() const override { return {}; }
    void use(const ValueBoard& board) override;
    void send_as(const NodeIdentity& identity) override { identity_ = &identity; }
    /// The channels before the last present one: the message has no gaps.
    std::uint32_t needed_channels(const ChannelFrame& snapshot) const override;
    /// As a link quality of 0.
    bool marks_frame_lost() const override { return true; }
    void continue_from(const Encoder& before) override;
    std::size_t write(const ChannelFrame& snapshot, std::span<CanFrame, kMostSnapshotFrames> frames,
                      Instant now) override;

  private:
    void write_quality(const ChannelFrame& snapshot, Instant now, RcInput& message);
    std::optional<double> quality_of(const ChannelFrame& snapshot, Instant now);
    double share_of_good(const ChannelFrame& snapshot);

    RcOutputFormat format_;
    NodeIdentity own_identity_;
    const NodeIdentity* identity_ = &own_identity_;
    SentNumber value_;
    std::uint8_t transfer_id_ = 0;
    /// One bit for each of the latest new snapshots, and the sequence of the newest.
    static constexpr unsigned kJudgedFrames = 64;
    std::uint64_t good_ones_ = ~std::uint64_t{0};
    std::uint32_t latest_sequence_ = 0;
};

}  // namespace tribus::dronecan
