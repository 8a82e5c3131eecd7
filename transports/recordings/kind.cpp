#include <cstddef>
#include <optional>

#include "transports/recordings/candump_words.h"
#include "transports/recordings/recording.h"
#include "transports/recordings/text.h"

namespace tribus {
namespace {

using recording_text::Line;
using recording_text::Lines;
using recording_text::mistake_at;
using recording_text::Oddities;
using recording_text::parse_microseconds;
using recording_text::Token;
using recording_text::Tokens;
using recording_text::trimmed;
using recording_text::without_byte_order_mark;

constexpr std::string_view kTimedHeadingStart = "t_us";
constexpr std::string_view kSaleaeStart = "Time [s]";
constexpr char kCandumpStart = '(';

/// Content is raw if at least one byte in this many does not occur in text. Frames of serial
/// protocols are far above: in i.Bus every second byte is a control character.
constexpr std::size_t kRawShare = 16;

/// Decides by the first words of the lines.
RecordingKind hex_or_timed(Pieces& content) {
    content.rewind();
    Lines lines(content);
    Line line;
    bool any = false;
    bool all_pairs = true;
    bool all_rising = true;
    bool first_is_time = false;
    std::optional<Duration> previous;
    while (lines.next(line)) {
        Token first;
        if (!Tokens(line.text).next(first)) {
            if (!any && trimmed(line.comment, "# \t").starts_with(kTimedHeadingStart)) {
                return RecordingKind::timed;
            }
            continue;
        }
        const auto time = parse_microseconds(first.text);
        first_is_time = any ? first_is_time : time && first.text.size() != 2;
        any = true;
        all_pairs = all_pairs && first.text.size() == 2;
        all_rising = all_rising && time && (!previous || *time > *previous);
        previous = time;
    }
    if (any && !all_pairs && (all_rising || first_is_time)) {
        return RecordingKind::timed;
    }
    return RecordingKind::hex;
}

bool only_raw(const Oddities& odd) {
    return odd.count() > 0 && odd.count() * kRawShare >= odd.size();
}

Oddities oddities_of(Pieces& content) {
    Oddities odd;
    std::string_view piece = without_byte_order_mark(content.next());
    for (; !piece.empty(); piece = content.next()) {
        odd.take(piece);
    }
    return odd;
}

RecordingKind kind_of_text(Pieces& content) {
    content.rewind();
    Lines lines(content);
    Line line;
    while (lines.next(line)) {
        const std::string_view text = trimmed(line.text);
        if (text.starts_with(kCandumpStart) || is_candump_screen_line(text)) {
            return RecordingKind::candump;
        }
        if (!text.empty() && text.starts_with(kSaleaeStart)) {
            return RecordingKind::saleae;
        }
        if (!text.empty()) {
            break;
        }
    }
    return hex_or_timed(content);
}

}  // namespace

bool looks_raw(std::string_view beginning) {
    OnePiece content(beginning);
    return only_raw(oddities_of(content));
}

tl::expected<RecordingKind, std::string> detect_recording_kind(Pieces& content,
                                                               std::string_view file_name) {
    const Oddities odd = oddities_of(content);
    if (!only_raw(odd) && odd.count() > 0) {
        return mistake_at(file_name, odd.line(), odd.column(),
                          "a byte that is not text in a file of text; correct it, or say that "
                          "the file holds raw bytes");
    }
    const RecordingKind kind = only_raw(odd) ? RecordingKind::raw : kind_of_text(content);
    content.rewind();
    return kind;
}

tl::expected<RecordingKind, std::string> detect_recording_kind(std::string_view content,
                                                               std::string_view file_name) {
    OnePiece piece(content);
    return detect_recording_kind(piece, file_name);
}

}  // namespace tribus
