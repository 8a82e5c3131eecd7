#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/can_frame.h"
#include "core/time.h"
#include "pipelines/realtime/capture_ring.h"

/// Captured pieces as text that `decode` and `simulate` read.
namespace tribus {

/// The port and the time range of a text.
struct CaptureFormat {
    bool can = false;
    std::string interface;  ///< CAN only
    Duration byte_time{};   ///< of the line; serial only
    Instant zero{};         ///< begin of the recording; earlier pieces are left out
    Duration zero_wall{};   ///< the same instant, since 1970
    Instant end = kNever;   ///< later pieces are damaged
};

/// Turns pieces into text: timed lines of bytes, or a candump log. What was read and what was
/// written are two texts with the same zero. Pure.
class CaptureText {
  public:
    explicit CaptureText(CaptureFormat format);

    /// Takes pieces in their order. Leaves out and counts those that cannot have been recorded.
    void take(std::span<const CapturePiece> pieces);
    /// Call it after the last piece.
    void finish() { end_burst(); }

    /// The caller may take the text out at any time.
    std::string& read() { return texts_[0].text; }
    std::string& written() { return texts_[1].text; }
    /// Number of reads or writes, or of CAN frames, so far.
    std::uint64_t read_count() const { return texts_[0].count; }
    std::uint64_t written_count() const { return texts_[1].count; }
    /// Number of pieces that were left out.
    std::uint64_t damaged_count() const { return damaged_count_; }

  private:
    struct Text {
        std::string text;
        std::uint64_t count = 0;
        Duration latest_end{};  ///< since the zero; times must not go back
    };
    /// One read, write or CAN frame, with the pieces so far.
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
