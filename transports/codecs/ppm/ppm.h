#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/channel_frame.h"
#include "core/edge_records.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/framed_decoder.h"
#include "transports/codecs/protocol.h"

/// PPM, the sum of pulses of trainer ports and old receivers (docs/protocols/ppm.md).
namespace tribus {

extern const Protocol kPpmProtocol;

namespace ppm {

/// The distance of two edges that is a channel.
inline constexpr std::uint32_t kShortestEighths = 700 * edge_records::kEighthsPerMicrosecond;
inline constexpr std::uint32_t kLongestEighths = 2300 * edge_records::kEighthsPerMicrosecond;
/// The least pause that is sent: longer than receivers need, whose clocks differ.
inline constexpr std::uint32_t kSentPauseEighths = 3000 * edge_records::kEighthsPerMicrosecond;
/// Transmitters send from four channels on.
inline constexpr std::size_t kLeastChannels = 4;
/// The link that makes pulses takes no longer frames.
inline constexpr std::size_t kMostSentChannels = 12;
inline constexpr std::size_t kMostMedian = 5;
/// A number of channels that so many frames running have is that of the sender.
inline constexpr std::size_t kFramesToBegin = 2;
inline constexpr std::size_t kFramesToChange = 5;
/// A middle is made of frames that came so soon one after another: more than two periods.
inline constexpr Duration kMostMedianPause = std::chrono::milliseconds(100);

}  // namespace ppm

/// Reads the records of core/edge_records.h. The distance of two edges is a channel, 700 to 2300
/// us; a pause of 2700 us or more ends a frame. A frame counts only whole: an edge that was lost,
/// one too many, or another number of channels than the frames before had refuses it, because its
/// channels may be those of others. The first frame only tells their number; another number counts
/// from the fifth frame running. No heap.
class PpmDecoder final : public FramedDecoder {
  public:
    /// `median`: each channel is the middle one of so many frames: 1, 3 or 5.
    explicit PpmDecoder(std::size_t median);
    void reset() override;

  private:
    std::size_t needed_bytes(std::span<const std::uint8_t> bytes) const override;
    bool check_holds(std::span<const std::uint8_t> frame) const override;
    bool read(std::span<const std::uint8_t> frame, ChannelFrame& channels) override;

    using Pulses = std::array<Pulse, kChannelCount>;
    void spoil(std::size_t cause);
    void add_channel(std::uint32_t eighths);
    bool end_frame(ChannelFrame& channels);
    bool has_usual_count();
    Pulse smoothed(std::size_t channel) const;

    std::size_t median_;
    /// Between a pause and the next one, while all edges were right.
    bool collects_ = false;
    Pulses pulses_{};
    std::size_t count_ = 0;
    std::size_t usual_count_ = 0;  ///< 0: not known yet
    std::size_t other_count_ = 0;  ///< of the latest frames running
    std::size_t others_ = 0;       ///< how many they are
    /// The latest good frames in a ring.
    std::array<Pulses, ppm::kMostMedian> kept_{};
    std::size_t kept_count_ = 0;
    std::size_t latest_kept_ = 0;
    Instant kept_at_{};
};

/// Writes the records of one frame: the first edge, one for each channel, and the pause behind it.
/// Pulses are limited to 700 to 2300 us. In silence it writes the pause alone.
class PpmEncoder final : public ByteEncoder {
  public:
    /// `channels`: 4 to 12, the first ones.
    explicit PpmEncoder(std::size_t channels) : channels_(channels) {}
    bool marks_frame_lost() const override { return false; }
    std::uint32_t needed_channels(const ChannelFrame& frame) const override;
    std::size_t write(const ChannelFrame& frame, std::span<std::uint8_t, kLongestSerialFrame> wire,
                      Instant now) override;
    std::size_t write_silence(std::span<std::uint8_t, kLongestSerialFrame> wire,
                              Instant now) override;

  private:
    std::size_t channels_;
};

/// The time that a frame of so many channels takes, with room for its longest pulses and a pause:
/// 22.5 ms, and 2.5 ms more for each channel beyond eight.
Duration ppm_period(std::size_t channels);

}  // namespace tribus
