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
#include "transports/codecs/can_codec.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/counter_watch.h"
#include "transports/codecs/native_can/channels_layout.h"
#include "transports/codecs/protocol.h"

/// The native CAN format (docs/protocols/can.md, "Native format"): a snapshot of the channels in
/// four or five classic frames or one FD frame. Each frame has status bits, counter and CRC.
/// Lossless for SBUS and i.Bus.
namespace tribus {

extern const Protocol kCanProtocol;

/// CRC profile of classic frames. FD frames always have profile 5.
enum class CanChannelsCrc : std::uint8_t { p22, p01 };

/// The settings on which both ends must agree.
struct CanChannelsFormat {
    std::uint32_t base_id = can_channels::kDefaultBaseId;
    bool extended = false;
    bool fd = false;
    CanChannelsCrc crc = CanChannelsCrc::p22;  ///< classic only
    std::size_t channels = kChannelCount;      ///< 16: classic snapshots omit the fifth frame

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

/// The status that every frame of a snapshot carries.
struct CanChannelsStatus {
    std::uint8_t counter = 0;
    bool failsafe = false;
    bool frame_lost = false;
    bool digital_17 = false;
    bool digital_18 = false;

    /// A status bit of one frame counts for the whole snapshot.
    void merge(const CanChannelsStatus& other) {
        failsafe |= other.failsafe;
        frame_lost |= other.frame_lost;
        digital_17 |= other.digital_17;
        digital_18 |= other.digital_18;
    }
    bool operator==(const CanChannelsStatus&) const = default;
};

/// What a snapshot carries once, in raw wire values.
struct CanChannelsOrigin {
    std::uint8_t link_quality = can_channels::kLinkQualityNotAvailable;
    std::uint8_t channel_count = 0;  ///< number of the highest present channel
    std::uint8_t source = can_channels::kSourceNotAvailable;  ///< see kSources
    std::uint16_t age = 0xFFFF;                               ///< steps of AgeScale

    bool operator==(const CanChannelsOrigin&) const = default;
};

/// The values of each kind of frame, without the CRC.
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

/// Reads a payload of the correct length. Does not check it.
CanChannelsQuad parse_can_quad(std::span<const std::uint8_t> payload);
CanChannelsTail parse_can_tail(std::span<const std::uint8_t> payload);
CanChannelsFd parse_can_fd(std::span<const std::uint8_t> payload);
/// Writes into a payload of zeros, without the CRC.
void emit_can(const CanChannelsQuad& quad, std::span<std::uint8_t> payload);
void emit_can(const CanChannelsTail& tail, std::span<std::uint8_t> payload);
void emit_can(const CanChannelsFd& frame, std::span<std::uint8_t> payload);

/// The correct CRC of a payload that has its counter. `index` is the distance of the frame's id
/// from the base id.
///
/// Profile 22 has a list of 16 ids, one for each counter value: 16 x index + counter. The index is
/// also the frame's 16-bit data id minus that of the first frame (RcE2eDataId in the DBC, 0x5243
/// and up), so no two of the 80 pairs of frame and counter share an id. Found by solving the
/// vectors with that CRC in dbc_vectors.json for the id.
std::uint16_t can_channels_crc(const CanChannelsFormat& format, std::size_t index,
                               std::span<const std::uint8_t> payload);
void write_can_channels_crc(const CanChannelsFormat& format, std::size_t index,
                            std::span<std::uint8_t> payload);

/// Raw value of a pulse; an absent channel becomes `not_available`. Saturates.
std::uint16_t to_wire(const can_channels::PulseScale& scale, std::optional<Pulse> pulse);
/// Pulse of a raw value; nothing for `not_available`.
std::optional<Pulse> from_wire(const can_channels::PulseScale& scale, std::uint16_t raw);
std::uint8_t source_to_wire(Origin origin);
Origin source_from_wire(std::uint8_t raw);

/// Encodes snapshots. All frames of a snapshot have the same counter and status. Pulses outside the
/// wire range saturate: 476 to 2523 us in classic frames, 0 to 4095.875 us in FD. Channels 17 and
/// 18 are also sent as two bits: on above 1500 us.
class CanChannelsEncoder final : public CanEncoder {
  public:
    explicit CanChannelsEncoder(const CanChannelsFormat& format = {});

    bool uses_fd() const override { return format_.fd; }
    std::span<const CanIdMatch> sent() const override {
        return std::span(ids_).first(format_.frame_count());
    }
    std::uint32_t needed_channels(const ChannelFrame& /*snapshot*/) const override { return 0; }
    bool marks_frame_lost() const override { return true; }
    void continue_from(const Encoder& before) override;
    std::size_t write(const ChannelFrame& snapshot, std::span<CanFrame, kMostSnapshotFrames> frames,
                      Instant now) override;

  private:
    CanFrame blank(std::size_t part) const;

    CanChannelsFormat format_;
    std::array<CanIdMatch, can_channels::kIds> ids_;
    unsigned counter_ = 0;
};

/// Decodes snapshots. Publishes a snapshot only if all of its frames arrived in sending order, with
/// one counter, within `kWindow`; and only after the counter advanced by 1 to `kMostAdvance` for
/// `kProof` snapshots in a row. That proof is required again after everything that makes the sender
/// doubtful: the start, a silence, more lost snapshots. After a counter step that came too soon,
/// and after two contents with one counter, the counter must first go through its whole range:
/// `CounterWatch` requires that to exclude replayed old snapshots and a second sender.
///
/// - Order: the ids ascend, so neither a sender's queue nor arbitration can change it. The last
///   frames that an interrupted sender left in its controller can therefore never complete a later
///   snapshot with the same counter. A receiver that swaps frames loses snapshots, counted as
///   "incomplete" and "stray".
/// - The first snapshots are not published: nothing yet distinguishes a live sender from one that
///   repeats itself for ever or from a queue that empties after an outage. AUTOSAR's profiles also
///   call the first one "initial" and not "ok". This costs two periods.
/// - Frames of two senders on one id are never mixed. With equal periods nothing is published,
///   whatever their counters and the order of their frames, and the input's timeout then ends in
///   failsafe. Two cases remain: a whole snapshot of a rarer sender passes if its counter fits at
///   that time; and if counter and earlier frames of both are equal, a frame of one may replace a
///   lost one of the other.
/// - No receiver can detect a sender that delays all of its snapshots equally, or a replay of as
///   many old snapshots as the counter has values.
class CanChannelsDecoder final : public CanDecoder {
  public:
    /// Upper limit of the time from the first frame of a snapshot to its last. Five frames with
    /// another frame before each take 12 ms at 125 kbit/s, and a counter of 15 values repeats after
    /// 30 ms at the least period.
    static constexpr Duration kWindow = std::chrono::milliseconds(20);
    /// After this time without a snapshot the counter proves nothing: it repeats every 150 ms at
    /// the usual period. Snapshots with a longer period than this are never published.
    static constexpr Duration kSilence = std::chrono::milliseconds(250);
    /// Two lost snapshots in a row still count as an advance (docs/protocols/can.md, "Native
    /// format").
    static constexpr unsigned kMostAdvance = 3;
    /// Two advances, so three snapshots. Two alternating senders never achieve that: of the steps
    /// from one to the other and back, k and 1 - k, only one can be 1 to 3. Nor does the usual
    /// transmit queue of 10 frames after an outage: it holds two snapshots.
    static constexpr unsigned kProof = CounterWatch::kProof;

    explicit CanChannelsDecoder(const CanChannelsFormat& format = {});

    bool uses_fd() const override { return format_.fd; }
    std::span<const CanIdMatch> wanted() const override {
        return std::span(ids_).first(format_.frame_count());
    }
    std::optional<ChannelFrame> next(const CanFrame& frame, Instant received) override;
    /// "length" counts every wrong kind of frame, "stray" the frames that continue no snapshot,
    /// "unconfirmed" the whole snapshots that came before the proof.
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
    enum class Collection : std::uint8_t { none, running, discarded };
    using Payload = std::array<std::uint8_t, can_channels::kFdLength>;
    using Payloads = std::array<Payload, can_channels::kIds - 1>;

    bool valid(const CanFrame& frame, std::size_t part);
    unsigned counter_of(const CanFrame& frame) const;
    /// Both take one valid frame and return whether it completes the snapshot.
    bool take_first(const CanFrame& frame, Instant received);
    bool take_further(const CanFrame& frame, std::size_t part);
    void add(const CanFrame& frame);
    bool same_as_taken(const CanFrame& frame, std::size_t part) const;
    void expire(Instant received);
    void discard(RejectCause cause);
    /// Compares the whole snapshot with the one before it.
    bool continues(Instant received);
    ChannelFrame publish(Instant received);
    void read_classic(ChannelFrame& channels, CanChannelsOrigin& origin) const;
    void read_fd(ChannelFrame& channels, CanChannelsOrigin& origin) const;
    void set_details(const CanChannelsOrigin& origin);
    void add_detail(std::string_view name, std::uint16_t value);

    CanChannelsFormat format_;
    std::array<CanIdMatch, can_channels::kIds> ids_;

    Collection collection_ = Collection::none;
    unsigned counter_ = 0;
    Instant begun_{};
    std::size_t taken_ = 0;
    /// Counter of the unfinished snapshot that this one replaced.
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

/// The exact ids of a snapshot's frames in sending order. Unused entries are default.
std::array<CanIdMatch, can_channels::kIds> can_channels_ids(const CanChannelsFormat& format);

}  // namespace tribus
