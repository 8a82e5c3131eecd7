#include <cstddef>
#include <optional>

#include "transports/recordings/recording.h"
#include "transports/recordings/text.h"

namespace tribus {
namespace {

using recording_text::find_oddities;
using recording_text::Line;
using recording_text::Lines;
using recording_text::mistake_at;
using recording_text::Oddities;
using recording_text::parse_microseconds;
using recording_text::Token;
using recording_text::Tokens;
using recording_text::trimmed;

constexpr std::string_view kTimedHeadingStart = "t_us";
constexpr std::string_view kSaleaeStart = "Time [s]";
constexpr char kCandumpStart = '(';

/// Content is raw if at least one byte in this many does not occur in text. Frames of serial
/// protocols are far above: in i.Bus every second byte is a control character.
constexpr std::size_t kRawShare = 16;

/// Decides by the first words of the lines.
RecordingKind hex_or_timed(std::string_view content) {
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

bool only_raw(std::size_t odd, std::size_t size) {
    return odd > 0 && odd * kRawShare >= size;
}

}  // namespace

bool looks_raw(std::string_view beginning) {
    return only_raw(find_oddities(beginning).count, beginning.size());
}

tl::expected<RecordingKind, std::string> detect_recording_kind(std::string_view content,
                                                               std::string_view file_name) {
    const Oddities odd = find_oddities(content);
    if (only_raw(odd.count, content.size())) {
        return RecordingKind::raw;
    }
    if (odd.count > 0) {
        return mistake_at(file_name, odd.line, odd.column,
                          "a byte that is not text in a file of text; correct it, or say that "
                          "the file holds raw bytes");
    }
    Lines lines(content);
    Line line;
    while (lines.next(line)) {
        const std::string_view text = trimmed(line.text);
        if (text.starts_with(kCandumpStart)) {
            return RecordingKind::candump;
        }
        if (!text.empty()) {
            return text.starts_with(kSaleaeStart) ? RecordingKind::saleae : hex_or_timed(content);
        }
    }
    return hex_or_timed(content);
}

}  // namespace tribus
