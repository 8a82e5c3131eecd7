#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "app/cli/protocol_use.h"
#include "app/wire/decoding.h"
#include "app/wire/frames/frame_finder.h"
#include "transports/recordings/recording_source.h"

/// `decode` for protocols of channels, on serial lines and on CAN.
namespace tribus {

/// Channel frames of one protocol.
class FrameDecoding final : public Decoding {
  public:
    FrameDecoding(const ProtocolUse& use, const DecodeOutput& output);

    void heading() override;
    void feed_burst(std::size_t index, const Burst& burst) override {
        finder_->feed_burst(index, burst);
    }
    void feed_frame(const RecordedCanFrame& frame) override { finder_->feed_frame(frame); }
    void finish(const LogFacts& log) override;
    DecodedAmount amount() const override;
    std::string_view protocol() const override { return protocol_; }

  private:
    std::string_view protocol_;
    DecodeOutput output_;
    std::unique_ptr<FrameFinder> finder_;
};

/// The largest number of frames that one of the protocols finds.
std::uint64_t most_frames(std::span<const ProtocolUse> uses, RecordingSource& recording);

/// Decodes a whole recording by the one of the protocols that finds the most frames. All must have
/// the recording's shape. Returns the exit status.
///
/// With several protocols, a burst that none of its frames touches and that is exactly one frame
/// of another protocol is decoded as that frame; so a file that lists frames of several protocols,
/// one a line, is decoded completely.
int decode_frames(RecordingSource& recording, std::span<const ProtocolUse> uses,
                  const DecodeOutput& output);

}  // namespace tribus
