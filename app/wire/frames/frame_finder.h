#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "app/cli/protocol_use.h"
#include "app/wire/frames/frame_judge.h"
#include "core/time.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/line_pauses.h"
#include "transports/recordings/recording.h"

namespace tribus {

/// Position of the first byte of a frame in a recording.
struct FramePlace {
    std::size_t burst = 0;
    std::size_t byte = 0;
    auto operator<=>(const FramePlace&) const = default;
};

struct FoundFrame {
    const Protocol* protocol = nullptr;
    DecodedFrame frame;
    FramePlace place;
    /// Start of its first byte; empty if the recording has no times.
    std::optional<Duration> start;
    /// Valid only during the call.
    std::span<const FrameDetail> details;
    /// Result of the input's loss detection, if the frames are decoded with an input's settings.
    std::optional<JudgedFrame> judged{};
};
using FrameHandler = std::function<void(const FoundFrame&)>;

/// Counters of a decoder.
struct Tally {
    std::uint64_t bytes = 0;
    std::uint64_t frames = 0;
    std::vector<NamedCount> rejected;
    std::uint64_t skipped_bytes = 0;
};

/// Runs the decoder of one protocol over bursts and reports each frame with its place and start. If
/// the bursts have times, pauses between them separate frames as on a live line.
class FrameFinder {
  public:
    FrameFinder(const ProtocolUse& use, FrameHandler handler);

    /// Feeds a burst, in the order of the recording; `index` may skip some. A frame may start in
    /// one burst and end in a later one.
    void feed(std::size_t index, const Burst& burst);
    /// Call it after the last burst.
    void finish();
    Tally tally() const;

  private:
    struct BurstStart {
        std::uint64_t position = 0;  ///< of its first byte, among all bytes fed
        std::size_t burst = 0;
        std::optional<Duration> start;
    };
    void look_for_pause(const Burst& burst);
    void feed_run(std::span<const std::uint8_t> bytes, Instant received);
    void report(const DecodedFrame& frame);

    const Protocol* protocol_;
    LineSettings line_;
    FrameHandler handler_;
    std::unique_ptr<ByteDecoder> decoder_;
    LinePauses pauses_;
    FrameJudge judge_;
    /// The bursts in which the next frame may start.
    std::deque<BurstStart> starts_;
    std::uint64_t bytes_ = 0;
    std::uint64_t frames_ = 0;
};

}  // namespace tribus
