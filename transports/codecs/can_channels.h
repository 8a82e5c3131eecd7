#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "core/can_frame.h"
#include "core/channel_frame.h"
#include "core/time.h"
#include "transports/codecs/can_channels_layout.h"
#include "transports/codecs/can_codec.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/counter_watch.h"
#include "transports/codecs/protocol.h"

/// The native CAN format (docs/protocols/can.md, "Native format"): a snapshot of the channels in
/// four or five classic frames or in one FD frame, with states, counter and CRC in each. Lossless
/// for SBUS and i.Bus.
namespace tribus {

extern const Protocol kCanProtocol;

/// The protection of classic frames; FD frames always have profile 5.
enum class CanChannelsCrc : std::uint8_t { p22, p01 };

/// The variant of the format that both ends must agree on.
struct CanChannelsFormat {
    std::uint32_t base_id = can_channels::kDefaultBaseId;
    bool extended = false;
    bool fd = false;
    CanChannelsCrc crc = CanChannelsCrc::p22;  ///< classic only
    std::size_t channels = kChannelCount;      ///< classic: 16 goes without the fifth frame

    static CanChannelsFormat from_settings(const SettingValues& settings);

    /// Distance of the first frame's id from the base id.
    std::size_t first_index() const { return fd ? can_channels::kFdIndex : 0; }
    /// Frames of one snapshot.
    std::size_t frame_count() const {
        return fd ? 1 : can_channels::kQuads + (channels > can_channels::kQuadChannels ? 1 : 0);
    }
    std::size_t frame_length() const {
        return fd ? can_channels::kFdLength : can_channels::kClassicLength;
    }
    /// The counter goes from 0 to one less than this.
    unsigned counter_values() const { return fd ? 256 : crc == CanChannelsCrc::p22 ? 16 : 15; }
};

/// What every frame of a snapshot says besides its channels.
struct CanChannelsStatus {
    std::uint8_t counter = 0;
    bool failsafe = false;
    bool frame_lost = false;
    bool digital_17 = false;
    bool digital_18 = false;

    /// A state that any part of a snapshot tells is the state of the whole.
    void merge(const CanChannelsStatus& other) {
        failsafe |= other.failsafe;
        frame_lost |= other.frame_lost;
        digital_17 |= other.digital_17;
        digital_18 |= other.digital_18;
    }
    bool operator==(const CanChannelsStatus&) const = default;
};

/// What a snapshot says once, in raw numbers of the wire.
struct CanChannelsOrigin {
    std::uint8_t link_quality = can_channels::kLinkQualityNotAvailable;
    std::uint8_t channel_count = 0;  ///< number of the highest channel that is present
    std::uint8_t source = can_channels::kSourceNotAvailable;  ///< see kSources
    std::uint16_t age = 0xFFFF;                               ///< steps of AgeScale

    bool operator==(const CanChannelsOrigin&) const = default;
};

/// Each of the three frames in its own terms; the CRC is not part of them.
struct CanChannelsQuad {
    CanChannelsStatus status;
    std::array<std::uint16_t, can_channels::kChannelsPerQuad> raw{};
};
struct CanChannelsTail {
    CanChannelsStatus status;
    CanChannelsOrigin origin;
    std::array<std::uint16_t, can_channels::kTailChannels> raw{};
};
struct CanChannelsFd {
    CanChannelsStatus status;
    CanChannelsOrigin origin;
    std::array<std::uint16_t, kChannelCount> raw{};
};

/// Reads a payload of the right length without judging it.
CanChannelsQuad parse_can_quad(std::span<const std::uint8_t> payload);
CanChannelsTail parse_can_tail(std::span<const std::uint8_t> payload);
CanChannelsFd parse_can_fd(std::span<const std::uint8_t> payload);
/// Writes a payload that was all zeros, without the CRC.
void emit_can(const CanChannelsQuad& quad, std::span<std::uint8_t> payload);
void emit_can(const CanChannelsTail& tail, std::span<std::uint8_t> payload);
void emit_can(const CanChannelsFd& frame, std::span<std::uint8_t> payload);

/// The right CRC for a payload with its counter. `index` is the distance of its id from the base
/// id.
///
/// Profile 22 has a list of 16 ids, one for each counter value: 16 x index + counter, where the
/// index is also the frame's 16-bit data id less that of the first frame (RcE2eDataId in the DBC,
/// 0x5243 and up). So no two of the 80 pairs of frame and counter share an id. Found by solving the
/// vectors with that CRC in dbc_vectors.json for the id.
std::uint16_t can_channels_crc(const CanChannelsFormat& format, std::size_t index,
                               std::span<const std::uint8_t> payload);
void write_can_channels_crc(const CanChannelsFormat& format, std::size_t index,
                            std::span<std::uint8_t> payload);

std::uint16_t to_wire(const can_channels::PulseScale& scale, std::optional<Pulse> pulse);
std::optional<Pulse> from_wire(const can_channels::PulseScale& scale, std::uint16_t raw);
std::uint8_t source_to_wire(Origin origin);
Origin source_from_wire(std::uint8_t raw);

/// Every frame of a snapshot has the same counter and states. Pulses beyond the range of the wire
/// saturate: 476 to 2523 us in classic frames, 0 to 4095.875 us in FD. Channels 17 and 18 are also
/// told as two bits: on above 1500 us.
class CanChannelsEncoder final : public CanEncoder {
  public:
    explicit CanChannelsEncoder(const CanChannelsFormat& format = {});

    bool uses_fd() const override { return format_.fd; }
    std::span<const CanIdMatch> sent() const override {
        return std::span(ids_).first(format_.frame_count());
    }
    std::uint32_t needed_channels(const ChannelFrame& /*snapshot*/) const override { return 0; }
    bool marks_frame_lost() const override { return true; }
    void continue_from(const CanEncoder& before) override;
    std::size_t encode(const ChannelFrame& snapshot, Instant now,
                       std::span<CanFrame, kMostSnapshotFrames> frames) override;

  private:
    CanFrame blank(std::size_t part) const;

    CanChannelsFormat format_;
    std::array<CanIdMatch, can_channels::kIds> ids_;
    unsigned counter_ = 0;
};

/// Publishes a snapshot only if all of its frames came, in the order in which they are sent, with
/// one counter, within `kWindow`; and only if `kProof` times in a row the counter had advanced by 1
/// to `kMostAdvance` since the snapshot before. That proof is due again after whatever makes the
/// sender doubtful: the start, a silence, more lost snapshots. After a step of the counter for
/// which there was no time, and after two contents under one counter, the counter must first go
/// through its whole range: what `CounterWatch` asks of a ring of old snapshots or a second sender.
///
/// - Order: the ids ascend, so neither a sender's queue nor arbitration can change it, and what an
///   interrupted sender left in its controller, the rear of a snapshot, can never be completed by
///   the front of a later one with the same counter. A receiver that swaps frames loses snapshots,
///   counted under "incomplete" and "stray".
/// - The first snapshots are not published, because nothing yet tells a live sender from one that
///   repeats itself for ever or a queue that empties after an outage. AUTOSAR's profiles also call
///   the first one "initial" and not "ok". It costs two periods.
/// - Two senders on one id are never mixed, and with equal periods nothing is published, whatever
///   their counters and however their frames mingle; the input's timeout then ends in failsafe.
///   What remains: one whole snapshot of a rarer one passes, if its counter fits at that time. And
///   if both are equal, and the frames already there as well, a frame of one may stand in for a
///   lost one of the other.
/// - What else no receiver can see: a sender that delays all of its snapshots alike, and a ring of
///   as many old snapshots as the counter has values.
class CanChannelsDecoder final : public CanDecoder {
  public:
    /// From the first frame of a snapshot to its last. Five frames with a foreign one before each
    /// take 12 ms at 125 kbit/s; and a counter of 15 values comes round after 30 ms at the least
    /// period.
    static constexpr Duration kWindow = std::chrono::milliseconds(20);
    /// Without a snapshot for so long, the counter says nothing any more: it comes round each
    /// 150 ms at the usual period. Longer periods than this are never published.
    static constexpr Duration kSilence = std::chrono::milliseconds(250);
    /// Two lost snapshots in a row are still an advance (docs/protocols/can.md, "Native format").
    static constexpr unsigned kMostAdvance = 3;
    /// Three snapshots: two senders in turn never bring it about, since of the steps from one to
    /// the other and back, k and 1 - k, only one can be 1 to 3. Nor does what the usual transmit
    /// queue of 10 frames held over an outage: two snapshots.
    static constexpr unsigned kProof = CounterWatch::kProof;

    explicit CanChannelsDecoder(const CanChannelsFormat& format = {});

    bool uses_fd() const override { return format_.fd; }
    std::span<const CanIdMatch> wanted() const override {
        return std::span(ids_).first(format_.frame_count());
    }
    std::optional<ChannelFrame> next(const CanFrame& frame, Instant received) override;
    /// "length" counts all wrong kinds of frame, "stray" those that continue no snapshot, and
    /// "unconfirmed" the whole snapshots for which proof was still missing.
    std::span<const NamedCount> rejected() const override { return rejected_; }
    std::span<const FrameDetail> details() const override {
        return std::span(details_).first(detail_count_);
    }

  private:
    enum RejectCause : std::size_t {
        kLength,
        kChecksum,
        kIncomplete,
        kStray,
        kConflict,
        kRepeated,
        kCounterJump,
        kUnconfirmed,
        kCauses,
    };
    enum class Collection : std::uint8_t { none, running, spoilt };
    using Payload = std::array<std::uint8_t, can_channels::kFdLength>;
    using Payloads = std::array<Payload, can_channels::kIds - 1>;

    bool sound(const CanFrame& frame, std::size_t part);
    unsigned counter_of(const CanFrame& frame) const;
    /// Each takes one sound frame and says whether a snapshot is whole now.
    bool take_first(const CanFrame& frame, Instant received);
    bool take_further(const CanFrame& frame, std::size_t part);
    void add(const CanFrame& frame);
    bool same_as_taken(const CanFrame& frame, std::size_t part) const;
    void expire(Instant received);
    void spoil(RejectCause cause);
    /// The whole snapshot against the one before it.
    bool continues(Instant received);
    ChannelFrame publish(Instant received);
    void read_classic(ChannelFrame& channels, CanChannelsOrigin& origin) const;
    void read_fd(ChannelFrame& channels, CanChannelsOrigin& origin) const;
    void tell_details(const CanChannelsOrigin& origin);
    void add_detail(std::string_view name, std::uint16_t value);

    CanChannelsFormat format_;
    std::array<CanIdMatch, can_channels::kIds> ids_;

    Collection collection_ = Collection::none;
    unsigned counter_ = 0;
    Instant begun_{};
    std::size_t taken_ = 0;
    /// Counter of the unfinished snapshot that this one took the place of.
    std::optional<unsigned> interrupted_;
    Payloads parts_{};

    CounterWatch watch_;
    Payloads reference_{};
    /// When the values that were published last were fresh.
    Instant published_received_ = kNever;

    std::array<NamedCount, kCauses> rejected_{{{"length"},
                                               {"checksum"},
                                               {"incomplete"},
                                               {"stray"},
                                               {"conflict"},
                                               {"repeated"},
                                               {"counter_jump"},
                                               {"unconfirmed"}}};
    static constexpr std::size_t kDetails = 4;
    std::array<std::uint16_t, kDetails> detail_values_{};
    std::array<FrameDetail, kDetails> details_{};
    std::size_t detail_count_ = 0;
};

/// The exact ids of a snapshot's frames, in the order in which they go out; the rest is unused.
std::array<CanIdMatch, can_channels::kIds> can_channels_ids(const CanChannelsFormat& format);

}  // namespace tribus
