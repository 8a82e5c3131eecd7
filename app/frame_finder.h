#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "app/frame_judge.h"
#include "app/protocol_use.h"
#include "core/time.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/line_pauses.h"
#include "transports/links/recording.h"

namespace tribus {

/// Where a frame starts in a recording.
struct FramePlace {
    std::size_t burst = 0;
    std::size_t byte = 0;
    auto operator<=>(const FramePlace&) const = default;
};

struct FoundFrame {
    const Protocol* protocol = nullptr;
    DecodedFrame frame;
    FramePlace place;
    /// Of its first byte; absent where the recording has no times.
    std::optional<Duration> start;
    /// Valid during the call only.
    std::span<const FrameDetail> details;
    /// By the detectors of an input, where the frames are read as that input reads them.
    std::optional<JudgedFrame> judged{};
};
using FrameHandler = std::function<void(const FoundFrame&)>;

/// What a decoder made of the bytes that it was given.
struct Tally {
    std::uint64_t bytes = 0;
    std::uint64_t frames = 0;
    std::vector<NamedCount> rejected;
    std::uint64_t skipped_bytes = 0;
};

/// Runs the decoder of one protocol over bursts and tells where and when each frame starts. Where
/// the bursts have times, pauses between them count as those of a line that is read.
class FrameFinder {
  public:
    FrameFinder(const ProtocolUse& use, FrameHandler handler);

    /// Bursts come in the order of the recording; `index` may leave some out. Frames may start in
    /// one burst and end in a later one.
    void feed(std::size_t index, const Burst& burst);
    /// No burst follows.
    void finish();
    Tally tally() const;

  private:
    struct BurstStart {
        std::uint64_t position = 0;  ///< of its first byte among all bytes fed
        std::size_t burst = 0;
        std::optional<Duration> start;
    };
    void look_for_pause(const Burst& burst);
    void feed_run(std::span<const std::uint8_t> bytes, Instant received);
    void report(const DecodedFrame& frame);

    const Protocol* protocol_;
    LineSettings line_;
    FrameHandler handler_;
    std::unique_ptr<Decoder> decoder_;
    LinePauses pauses_;
    FrameJudge judge_;
    /// Of the bursts in which the next frame may start.
    std::deque<BurstStart> starts_;
    std::uint64_t bytes_ = 0;
    std::uint64_t frames_ = 0;
};

}  // namespace tribus
