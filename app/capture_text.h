#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/can_frame.h"
#include "core/time.h"
#include "pipelines/realtime/capture_ring.h"

/// What passed a port, in the forms that `decode` and `simulate` read.
namespace tribus {

struct CaptureFormat {
    bool can = false;
    std::string interface;  ///< CAN only
    Duration byte_time{};   ///< of the line; serial only
    Instant zero{};         ///< of the recording; what came before is left out
    Duration zero_wall{};   ///< the same since 1970
    Instant end = kNever;   ///< what claims to be later is damaged
};

/// Turns pieces into text: timed lines of bytes, or a log as of candump. What was read and what was
/// written are two texts with the same zero. Pure.
class CaptureText {
  public:
    explicit CaptureText(CaptureFormat format);

    /// In their order. Pieces that nobody can have recorded so are left out and counted.
    void take(std::span<const CapturePiece> pieces);
    /// No more of them come.
    void finish() { end_burst(); }

    /// To be taken from, whenever it is large.
    std::string& read() { return texts_[0].text; }
    std::string& written() { return texts_[1].text; }
    /// Reads or writes, or frames, so far.
    std::uint64_t read_count() const { return texts_[0].count; }
    std::uint64_t written_count() const { return texts_[1].count; }
    /// Pieces that were left out.
    std::uint64_t damaged_count() const { return damaged_count_; }

  private:
    struct Text {
        std::string text;
        std::uint64_t count = 0;
        Duration latest_end{};  ///< from the zero; times must not go back
    };
    /// One read, write or frame, as far as its pieces have come.
    struct Burst {
        bool begun = false;
        CapturePiece first{};
        CanFrame frame{};
        std::vector<std::uint8_t> bytes;
        std::vector<bool> damaged;
    };
    bool take(const CapturePiece& piece);
    bool go_on_with(const CapturePiece& piece);
    void begin_burst(const CapturePiece& piece);
    void end_burst();
    void end_bytes(Text& text);
    void end_frame(Text& text);

    CaptureFormat format_;
    std::array<Text, 2> texts_;
    Burst burst_;
    std::uint64_t damaged_count_ = 0;
};

}  // namespace tribus
