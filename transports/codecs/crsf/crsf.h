#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/channel_frame.h"
#include "core/time.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/crsf/frames.h"
#include "transports/codecs/protocol.h"
#include "transports/codecs/sbus/packed_channels.h"
#include "transports/codecs/sbus/scale.h"

/// TBS CRSF, as receivers of ExpressLRS, Crossfire, Tracer and mLRS speak it, both directions
/// (docs/protocols/crsf.md). A frame: address, length of the rest, type, payload, CRC-8 of type and
/// payload.
namespace tribus {

extern const Protocol kCrsfProtocol;

/// Reads channels (types 16 and 17, longer frames than usual too) and link statistics (14, 1C);
/// passes over all other types. The receiver falls silent on loss, or says it in its statistics:
///   - statistics of quality 0, and no channels since the ones before: a frame marked failsafe;
///   - other statistics, and no channels for kNoChannelsAfter: a frame without channels.
/// Channels carry the link quality of the latest statistics, for kStatisticsLast.
class CrsfDecoder final : public CrsfFrames {
  public:
    std::span<const FrameDetail> details() const override;

    /// Three frames of the slowest rate, 25 Hz, and some more.
    static constexpr Duration kNoChannelsAfter = std::chrono::milliseconds(250);
    /// Receivers send statistics each 100 ms.
    static constexpr Duration kStatisticsLast = std::chrono::seconds(1);
    /// The newest value of a channel counts so long for frames of type 17 that lack it.
    static constexpr Duration kSubsetLasts = std::chrono::milliseconds(100);

    const RadioStatistics* radio_statistics() const override {
        return statistics_ ? &*statistics_ : nullptr;
    }

  private:
    Taken decode(std::span<const std::uint8_t> bytes, Instant received,
                 DecodedFrame& frame) override;
    bool read(std::span<const std::uint8_t> frame, ChannelFrame& channels) override;

    void read_channels(std::span<const std::uint8_t, kPackedChannelBytes> packed,
                       ChannelFrame& channels);
    bool read_subset(std::span<const std::uint8_t> payload, ChannelFrame& channels);
    void fill_subset(ChannelFrame& channels) const;
    bool judge(const RadioStatistics& statistics, ChannelFrame& channels);
    void channels_came(ChannelFrame& channels);

    std::optional<RadioStatistics> statistics_;
    /// The latest channels, or the first statistics if there were no channels yet.
    std::optional<Instant> channels_at_;
    bool channels_since_statistics_ = false;
    /// The latest value of each channel in frames of type 17, and its arrival. Unknown once a later
    /// frame of type 16 has the channel.
    struct SubsetChannel {
        Pulse pulse{};
        Instant received{};
        bool known = false;
    };
    std::array<SubsetChannel, kChannelCount> subset_{};

    /// 992 is 1500 us, a step is 5/8 us.
    SbusScale scale_ = *SbusScale::named("betaflight");
    /// Raw values of the latest frame of type 16, and its arrival.
    SbusRaw raw_{};
    Instant raw_received_ = Instant::min();
    /// The latest frame was one of type 16.
    bool raw_is_latest_ = false;
    /// A frame of type 16 came after the latest one of type 17.
    bool raw_since_subset_ = false;
    mutable std::array<std::uint16_t, 2> detail_values_{};
    mutable std::array<FrameDetail, 3> details_{};
};

/// Writes channels as type 16 with address C8, which every reader takes, and each 100 ms the link
/// statistics of type 14 behind them, if the link quality is known; with values that are held or
/// preset it is 0. 16 channels; an absent one is sent as 1500 us. Nothing in CRSF says failsafe: on
/// loss the channels stop, and the statistics go on with link quality 0.
class CrsfEncoder final : public ByteEncoder {
  public:
    bool marks_frame_lost() const override { return false; }
    std::uint32_t needed_channels(const ChannelFrame& frame) const override;
    std::size_t write(const ChannelFrame& frame, std::span<std::uint8_t, kLongestSerialFrame> wire,
                      Instant now) override;
    std::size_t write_silence(std::span<std::uint8_t, kLongestSerialFrame> wire,
                              Instant now) override;

    static constexpr Duration kStatisticsPeriod = std::chrono::milliseconds(100);

  private:
    bool statistics_due(Instant now);

    SbusScale scale_ = *SbusScale::named("betaflight");
    std::optional<Instant> statistics_at_;
};

}  // namespace tribus
