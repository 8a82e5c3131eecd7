#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "core/can_frame.h"
#include "core/channel_frame.h"
#include "core/time.h"
#include "core/value_board.h"
#include "transports/codecs/can_codec.h"
#include "transports/codecs/dronecan/source.h"
#include "transports/codecs/dronecan/transfer.h"
#include "transports/codecs/dronecan/types_command.h"
#include "transports/codecs/dronecan/voice.h"

/// RC channels as dronecan.sensors.rc.RCInput (docs/protocols/can.md, "DroneCAN: RCInput").
namespace tribus::dronecan {

/// What the numbers of a sender mean.
enum class RcScale : std::uint8_t {
    microseconds,  ///< as the type says
    sbus,          ///< raw SBUS numbers, 0.625 us each (a node of ENAC sends them)
    full_range,    ///< 0 to 4095 for 1000 to 2000 us (a fork of PX4 expects that)
};

struct RcInputFormat {
    SourceChoice source{};
    RcScale scale = RcScale::microseconds;
    /// Only messages of this receiver; absent: of any.
    std::optional<std::uint8_t> receiver{};
    bool fd = false;  ///< takes FD frames too
};

/// RCInput messages in, snapshots out. A message that says that its link quality is 0 is marked
/// frame-lost, for the type has no flag for that. Once the transfer id has gone back, or further on
/// than time allows, messages are refused until it has gone through its whole range: 0.64 s at
/// 50 Hz (`CounterWatch`).
class RcDecoder final : public CanDecoder {
  public:
    explicit RcDecoder(RcInputFormat format);

    std::span<const CanIdMatch> wanted() const override { return {&wanted_, 1}; }
    bool uses_fd() const override { return format_.fd; }
    std::optional<ChannelFrame> next(const CanFrame& frame, Instant received) override;
    std::span<const NamedCount> rejected() const override { return rejected_.counts(); }
    std::span<const FrameDetail> details() const override { return details_; }

  private:
    bool believes(const RcInput& message, const ReceivedTransfer& transfer);
    ChannelFrame channels_of(const RcInput& message, Instant at);
    Pulse pulse_of(std::uint16_t raw) const;
    void note_quality(const RcInput& message, Instant at);

    RcInputFormat format_;
    CanIdMatch wanted_;
    SourceWatch source_;
    TransferReceiver receiver_;
    CounterWatch order_{kTransferOrder};
    TransferRejects rejected_;
    /// The latest in percent: some senders tell several kinds of quality in turn.
    std::uint8_t link_quality_ = kNoLinkQuality;
    Instant link_quality_at_{};
    std::array<std::uint16_t, 3> told_{};
    std::array<FrameDetail, 3> details_;
};

enum class RcQuality : std::uint8_t {
    none,
    link,   ///< the input's own link quality, or else the share of its frames that were good
    value,  ///< a named value
};

struct RcOutputFormat {
    /// Whose name it sends in where no node says so: in a recording.
    NodeId node = kNobody;
    bool fd = false;
    std::uint8_t receiver = 0;  ///< which one this is, where a node has several: 0 to 15
    std::size_t channels = kChannelCount;
    RcQuality quality = RcQuality::link;
    std::uint16_t quality_type = RcInput::kQualityTypeLinkQuality;
    std::string quality_value{};  ///< its name

    static constexpr std::uint8_t kPriority = 8;
};

/// Snapshots in, RCInput messages out. Values that are held after a loss are sent with a link
/// quality of 0 %, valid: that is the only mark that the type has for old values, and nothing else
/// is ever sent so. In failsafe the flag of the type says so.
class RcEncoder final : public CanEncoder {
  public:
    explicit RcEncoder(RcOutputFormat format)
        : format_(std::move(format)), own_voice_{format_.node} {}

    bool uses_fd() const override { return format_.fd; }
    std::span<const CanIdMatch> sent() const override { return {}; }
    void use(const ValueBoard& board) override;
    void speak_as(const Voice& voice) override { voice_ = &voice; }
    /// Those before the last one that is present: the message has no gaps.
    std::uint32_t needed_channels(const ChannelFrame& snapshot) const override;
    /// As a link quality of 0.
    bool marks_frame_lost() const override { return true; }
    void continue_from(const CanEncoder& before) override;
    std::size_t encode(const ChannelFrame& snapshot, Instant now,
                       std::span<CanFrame, kMostSnapshotFrames> frames) override;

  private:
    void tell_quality(const ChannelFrame& snapshot, Instant now, RcInput& message);
    std::optional<double> quality_of(const ChannelFrame& snapshot, Instant now);
    double share_of_good(const ChannelFrame& snapshot);

    RcOutputFormat format_;
    Voice own_voice_;
    const Voice* voice_ = &own_voice_;
    const ValueBoard* board_ = nullptr;
    std::optional<std::size_t> value_;
    std::uint8_t transfer_id_ = 0;
    /// Of the latest snapshots that were new, and the sequence of the newest.
    static constexpr unsigned kJudgedFrames = 64;
    std::uint64_t good_ones_ = ~std::uint64_t{0};
    std::uint32_t latest_sequence_ = 0;
};

}  // namespace tribus::dronecan
