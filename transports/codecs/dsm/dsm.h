#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/channel_frame.h"
#include "core/time.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/dsm/layout.h"
#include "transports/codecs/protocol.h"

/// Spektrum DSM2 and DSMX, as satellite receivers send them (docs/protocols/dsm.md). A frame has 16
/// bytes: fades, system, seven words of a channel number and a value. There is no first byte, no
/// check and no mark for failsafe.
namespace tribus {

extern const Protocol kDsmProtocol;

/// The line between values and pulses; makers disagree (docs/protocols/dsm.md, "Scales").
enum class DsmScale : std::uint8_t { spektrum, betaflight };

/// The pulse of a value of 11 bits: four eighths a step, and a whole number of seventeenths of an
/// eighth, rounded. Every lane has the same value.
struct DsmLine {
    Lanes seventeenths{};
    Lanes rounding{};  ///< in seventeenths
    Lanes least_eighths{};
};

/// Finds frames by pauses, and without pauses by content.
///
/// A frame is plausible if its words have numbers of channels, each once. It agrees if its words
/// stand as in an earlier one. It counts from the second agreeing frame in a row on, if throttle,
/// aileron, elevator and rudder (numbers 0 to 3) were among them. A frame that is not plausible, or
/// has its words in other places, or was cut off by a pause, breaks the row. kSilence without a
/// frame also makes it forget the earlier ones.
///
/// If the pauses show that the line lost or added bytes there, the row goes on instead: the next
/// frame counts if it has a layout of the row, and pauses before and behind it. It comes with the
/// pause.
///
/// A pause says that the next byte begins a frame. Further frames may follow without a pause as
/// long as they agree. Else the decoder searches by content: 4 frames in a row must agree, with one
/// of the documented system bytes, at no more than one place of 16.
///
/// A value that was changed on the line is not noticed: nothing in the frame can tell. Channels
/// stay in the order of the wire, throttle first. Values of the frame before, which has the other
/// channels, count for kChannelLasts.
///
/// Thread-bound; no heap.
class DsmDecoder final : public ByteDecoder {
  public:
    explicit DsmDecoder(DsmScale scale = DsmScale::spektrum,
                        DsmResolution resolution = DsmResolution::either);

    void damaged_byte() override;
    bool silence(DecodedFrame& frame) override;
    void reset() override;
    std::optional<DecodedFrame> finish() override { return std::nullopt; }
    std::span<const NamedCount> rejected() const override { return rejected_; }
    std::uint64_t skipped_bytes() const override { return skipped_bytes_; }
    std::span<const FrameDetail> details() const override;

    /// Each channel comes each 44 ms or more often; one miss is allowed.
    static constexpr Duration kChannelLasts = std::chrono::milliseconds(100);
    /// The default timeout of an input.
    static constexpr Duration kSilence = std::chrono::milliseconds(100);
    static constexpr int kAgreeingFrames = 2;

  private:
    enum RejectCause : std::size_t { kUnproven, kImplausible, kCut, kDamaged };
    enum class Step : std::uint8_t { again, frame, wait };
    /// A layout that came lately.
    struct Known {
        DsmLayout layout;
        /// When it came last, and whether that was in the present row of agreeing frames.
        Instant latest{};
        bool counts = false;
        std::uint64_t order = 0;  ///< of its latest frame
        bool used = false;
    };
    /// A row of agreeing frames that a break ended.
    struct Row {
        std::uint32_t channels = 0;
        /// The known layouts that counted.
        std::uint32_t layouts = 0;
    };
    /// Room for two by turns, one of them with settings of a video transmitter, and a wrong one.
    static constexpr std::size_t kMostKnown = 4;
    static constexpr std::size_t kSearchFrames = 4;
    static constexpr std::size_t kSearchBytes = (kSearchFrames + 1) * kDsmFrameBytes - 1;
    static_assert(kSearchBytes <= LineBuffer::kCapacity);

    Taken decode(std::span<const std::uint8_t> bytes, Instant received,
                 DecodedFrame& frame) override;
    Taken decode_any(std::span<const std::uint8_t> bytes, Instant received, DecodedFrame& frame);
    Step step(Instant received, DecodedFrame& frame);
    Step search(Instant received, DecodedFrame& frame);
    bool proven_at(std::size_t start) const;
    bool take(const std::uint8_t* wire, Instant received);
    Known* recognise(const std::uint8_t* wire);
    Known* meet(const std::uint8_t* wire, Instant received);
    void give(const std::uint8_t* wire, Instant received, DecodedFrame& frame);
    void skip(std::size_t count);
    void break_row();
    void resume_row();
    bool waits_for_pause(Instant received);
    void forget();

    void keep(Known& known, const std::uint8_t* wire, Instant received);
    Lanes eighths_of(Lanes words, DsmResolution resolution) const;
    void mark_present(std::uint32_t channels);
    void remove_old(Instant received);

    DsmLine line_;
    DsmResolution resolution_;
    /// The next byte begins a frame.
    bool aligned_ = false;
    int agreeing_ = 0;
    /// The channels of the present row of agreeing frames.
    std::uint32_t channels_in_row_ = 0;
    std::array<Known, kMostKnown> known_{};
    /// Until the pause behind the break.
    std::optional<Row> broken_row_{};
    /// Position of the first byte behind the latest pause.
    std::uint64_t burst_begin_ = 0;
    /// The row goes on: the next frame counts if a pause shows its end.
    bool needs_pause_ = false;
    /// When the frame came that waits for that pause.
    Instant waits_since_{};
    std::uint64_t frames_ = 0;
    /// Of the latest plausible frame.
    Instant latest_frame_{};
    /// Before every arrival.
    static constexpr Instant kNever = Instant::min();
    /// A frame with a layout that counts also counts if it comes until then, and no channel is too
    /// old for it.
    Instant usual_until_ = kNever;
    /// The newest value of each channel.
    ChannelFrame values_;
    std::array<std::uint8_t, kDsmFrameBytes> latest_{};

    std::array<NamedCount, 4> rejected_{{{"unproven"}, {"implausible"}, {"cut"}, {"damaged"}}};
    std::uint64_t skipped_bytes_ = 0;
    mutable std::array<std::uint16_t, 2 + kDsmWords> detail_values_{};
    mutable std::array<FrameDetail, 3> details_{};
};

}  // namespace tribus
