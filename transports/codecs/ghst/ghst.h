#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/channel_frame.h"
#include "core/time.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/framed_decoder.h"
#include "transports/codecs/protocol.h"

/// GHST of ImmersionRC Ghost receivers, both directions (docs/protocols/ghst.md). A frame of 14
/// bytes: address 82, length 0C, type, payload, CRC-8 of type and payload. Each has channels 1 to
/// 4, and by turns four of channels 5 to 16 or the statistics of the radio link.
namespace tribus {

extern const Protocol kGhstProtocol;

/// Reads the types 30 to 3F and, in their own scale, 10 to 1F; those above x3 give channels 1 to 4
/// only, as the maker promises for types of the future. Passes over all other types. Nothing in
/// GHST says failsafe: a receiver that has lost the transmitter is silent.
///
/// Channels 5 to 8, 9 to 12 and 13 to 16 are each absent before their first frame, and again once
/// the latest is older than kGroupLasts. Channels carry the link quality of the latest statistics,
/// for kStatisticsLast.
class GhstDecoder final : public FramedDecoder {
  public:
    std::span<const FrameDetail> details() const override;
    const RadioStatistics* radio_statistics() const override {
        return statistics_ ? &*statistics_ : nullptr;
    }

    /// Some frames of the slowest rate, 19 Hz.
    static constexpr Duration kNoChannelsAfter = std::chrono::milliseconds(250);
    /// At the slowest rate, three groups and the statistics by turns take 210 ms; so the loss of
    /// one frame costs no channel.
    static constexpr Duration kGroupLasts = std::chrono::milliseconds(500);
    static constexpr Duration kStatisticsLast = std::chrono::seconds(1);

  private:
    static ChannelFrame all_channels();
    Taken decode(std::span<const std::uint8_t> bytes, Instant received,
                 DecodedFrame& frame) override;
    std::size_t needed_bytes(std::span<const std::uint8_t> bytes) const override;
    bool check_holds(std::span<const std::uint8_t> frame) const override;
    bool read(std::span<const std::uint8_t> frame, ChannelFrame& channels) override;

    void keep_fine(const std::uint8_t* frame, std::uint8_t type);
    void keep_group(const std::uint8_t* frame, std::uint8_t type, Instant received);
    void take_statistics(const std::uint8_t* frame, Instant received);
    void give(Instant received, ChannelFrame& channels);
    void remove_old_groups(ChannelFrame& channels);

    /// The channels of the latest frames, also of groups that have become old or never came.
    ChannelFrame values_ = all_channels();
    /// Before every arrival.
    static constexpr Instant kNeverCame = Instant(-2 * kGroupLasts);
    /// When the latest frame of each group came.
    std::array<Instant, 3> group_received_{kNeverCame, kNeverCame, kNeverCame};
    /// No group is too old for a frame that came until then.
    Instant groups_last_until_ = kNeverCame;
    std::optional<RadioStatistics> statistics_;

    /// The latest frame from its type on, for the details.
    std::array<std::uint8_t, 12> latest_{};
    mutable std::array<std::uint16_t, 11> detail_values_{};
    mutable std::array<FrameDetail, 4> details_{};
};

/// Writes the types 30, 31 and 32 by turns, so that each frame has channels 1 to 4 and every third
/// one a group. Behind a turn it writes type 33 if the latest is kStatisticsPeriod old or there was
/// none: Betaflight takes no channels before the first. It has the link quality of the frame, 0 if
/// that is unknown or the values are held or preset, and the least RSSI that readers know, because
/// the true one is not known.
///
/// 16 channels; an absent one is sent as 1500 us, because readers keep the last values of a group
/// that does not come any more. Nothing in GHST says failsafe: on loss nothing is sent.
class GhstEncoder final : public ByteEncoder {
  public:
    bool marks_frame_lost() const override { return false; }
    std::uint32_t needed_channels(const ChannelFrame& frame) const override;
    std::size_t write(const ChannelFrame& frame, std::span<std::uint8_t, kLongestSerialFrame> wire,
                      Instant now) override;

    static constexpr Duration kStatisticsPeriod = std::chrono::milliseconds(100);

  private:
    std::size_t next_content(Instant now);

    /// Content of the next frame: a group, or the statistics behind the last one.
    std::size_t next_ = 0;
    std::optional<Instant> statistics_at_;
};

}  // namespace tribus
