#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "app/learn/loss_rules.h"
#include "config/schema/schema.h"
#include "core/can_frame.h"
#include "transports/codecs/can_codec.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/line_pauses.h"

namespace tribus {

/// Decodes what one input receives and keeps its frames. Thread-bound.
class FrameCollector {
  public:
    /// Some ten minutes of a usual receiver.
    static constexpr std::size_t kMostFrames = 100'000;

    explicit FrameCollector(const InputConfig& input);

    template <class DamagedMarks>
    void receive(std::span<const std::uint8_t> bytes, const DamagedMarks& damaged, Instant at) {
        look_for_pause(bytes.size(), at);
        for (std::size_t i = 0; i < bytes.size(); ++i) {
            if (damaged[i]) {
                byte_decoder().damaged_byte();
            }
            decode(bytes.subspan(i, damaged[i] ? 0 : 1), at);
        }
    }
    /// Decodes one CAN frame that arrived `at`.
    void receive(const CanFrame& frame, Instant at);

    const std::vector<StudiedFrame>& frames() const { return frames_; }
    std::vector<StudiedFrame> take_frames() { return std::move(frames_); }
    /// Whether more frames came than it keeps.
    bool overflowed() const { return overflowed_; }

  private:
    void look_for_pause(std::size_t count, Instant at);
    void decode(std::span<const std::uint8_t> bytes, Instant at);
    void keep(const DecodedFrame& found, Instant at);
    void keep(const ChannelFrame& frame, Instant at);

    ByteDecoder& byte_decoder() { return *std::get<std::unique_ptr<ByteDecoder>>(decoder_); }

    AnyDecoder decoder_;
    LinePauses pauses_;
    Instant latest_read_{};
    std::vector<StudiedFrame> frames_;
    bool overflowed_ = false;
};

}  // namespace tribus
