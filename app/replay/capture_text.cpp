#include "app/replay/capture_text.h"

#include <algorithm>
#include <utility>

#include "transports/recordings/writer.h"

namespace tribus {
namespace {

/// Far more than one read or write holds.
constexpr std::size_t kMostBurstBytes = 4096;

}  // namespace

CaptureText::CaptureText(CaptureFormat format) : format_(std::move(format)) {
    for (Text& text : texts_) {
        if (format_.can) {
            append_candump_zero(text.text, format_.zero_wall);
        } else {
            text.text = kTimedHeading;
        }
    }
}

void CaptureText::take(std::span<const CapturePiece> pieces) {
    for (const CapturePiece& piece : pieces) {
        if (!take(piece)) {
            ++damaged_count_;
            burst_.begun = false;
        }
    }
}

/// Returns false if the piece, or the burst that it ends, is damaged.
bool CaptureText::take(const CapturePiece& piece) {
    if (!can_be_recorded(piece, format_.can) || piece.at() > format_.end) {
        return false;
    }
    if (!piece.has(CaptureMarks::kContinued)) {
        end_burst();
        begin_burst(piece);
    } else if (!burst_.begun) {
        // The beginning of this burst was overwritten.
        return true;
    } else if (!go_on_with(piece)) {
        return false;
    }
    for (std::size_t i = 0; i < piece.count; ++i) {
        burst_.bytes.push_back(piece.bytes[i]);
        burst_.damaged.push_back((piece.damaged >> i & 1U) != 0);
    }
    return true;
}

bool CaptureText::go_on_with(const CapturePiece& piece) {
    const CapturePiece& first = burst_.first;
    if (piece.at_ns != first.at_ns || piece.can_id != first.can_id ||
        piece.marks != (first.marks | CaptureMarks::kContinued) ||
        burst_.bytes.size() + piece.count > kMostBurstBytes) {
        return false;
    }
    CanFrame& frame = burst_.frame;
    if (format_.can && frame.length + std::size_t{piece.count} > frame.data.size()) {
        return false;
    }
    if (format_.can) {
        std::ranges::copy(piece.data(), frame.data.begin() + frame.length);
        frame.length = static_cast<std::uint8_t>(frame.length + piece.count);
    }
    return true;
}

void CaptureText::begin_burst(const CapturePiece& piece) {
    burst_.begun = true;
    burst_.first = piece;
    burst_.frame = can_frame_of(piece);
    burst_.bytes.clear();
    burst_.damaged.clear();
}

void CaptureText::end_burst() {
    if (!burst_.begun) {
        return;
    }
    burst_.begun = false;
    Text& text = texts_[static_cast<std::size_t>(burst_.first.direction())];
    if (format_.can) {
        end_frame(text);
    } else {
        end_bytes(text);
    }
}

/// Bytes that were read at once had all arrived by then; the text has the start of the first byte.
void CaptureText::end_bytes(Text& text) {
    const Duration length = format_.byte_time * static_cast<Duration::rep>(burst_.bytes.size());
    Duration start = burst_.first.at() - format_.zero;
    if (burst_.first.direction() == Direction::read) {
        start -= length;
    }
    if (start < Duration::zero()) {
        return;
    }
    // A pty is faster than a real line.
    start = std::max(start, text.latest_end);
    text.latest_end = burst_.first.direction() == Direction::read ? start + length : start;
    append_timed_line(text.text, start, burst_.bytes, burst_.damaged);
    ++text.count;
}

void CaptureText::end_frame(Text& text) {
    if (!valid_can_length(burst_.frame.length, burst_.frame.fd)) {
        ++damaged_count_;
        return;
    }
    if (burst_.first.at() < format_.zero) {
        return;
    }
    text.latest_end = std::max(burst_.first.at() - format_.zero, text.latest_end);
    append_candump_line(text.text, format_.zero_wall + text.latest_end, format_.interface,
                        burst_.frame);
    ++text.count;
}

}  // namespace tribus
