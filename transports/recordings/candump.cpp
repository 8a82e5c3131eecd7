#include "transports/recordings/candump.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "transports/recordings/candump_words.h"
#include "transports/recordings/text.h"

namespace tribus {
namespace {

using recording_text::cut_line_text;
using recording_text::Line;
using recording_text::Lines;
using recording_text::Mistake;
using recording_text::mistake_at;
using recording_text::quoted;
using recording_text::Token;
using recording_text::Tokens;
using recording_text::too_long_line;
using recording_text::trimmed;

constexpr Duration kMostStepBack = std::chrono::milliseconds(100);

constexpr std::string_view kDifferences =
    "these times are differences from line to line, as candump -td writes them, so nobody knows "
    "when a frame came; record with candump -L or -ta";

/// Names of interfaces have at most 15 characters in Linux.
constexpr std::size_t kLongestInterface = 15;

}  // namespace

/// The time of a line, of which `first` is the first word. The error is a sentence for there.
tl::expected<Duration, std::string> CandumpReader::time_of(std::string_view line,
                                                           std::string_view first) {
    const auto logged = parse_candump_time(first);
    if (!logged && is_candump_screen_line(line)) {
        return times_ == LogTimes::optional
                   ? tl::expected<Duration, std::string>(latest_)
                   : tl::unexpected("a line without a time" + std::string(kWhatALineIs));
    }
    if (!logged) {
        return tl::unexpected(quoted(first) + " is not a time" + std::string(kWhatALineIs));
    }
    differences_.take(first.find('.') - 1, *logged);
    const bool steps_back = log_start_ && *logged < latest_ - kMostStepBack;
    if (differences_.certain() || (steps_back && differences_.possible())) {
        return tl::unexpected(std::string(kDifferences));
    }
    if (steps_back) {
        return tl::unexpected(
            "the time " + std::string(first) +
            " is more than 100 ms before that of the line above (sort -s -k1,1 puts a whole log in "
            "order)");
    }
    return log_start_ ? std::max(*logged, latest_) : *logged;
}

tl::expected<std::optional<RecordedCanFrame>, std::string> CandumpReader::next(
    std::string_view line) {
    ++line_;
    const auto mistake = [&](std::size_t column, std::string_view text) {
        return mistake_at(file_, line_, static_cast<unsigned>(column), text);
    };
    Tokens tokens(line);
    Token first;
    if (!tokens.next(first) || first.text.starts_with('#')) {
        if (!log_start_ && line.starts_with(recording_text::kCandumpZero)) {
            log_start_ =
                parse_candump_time(trimmed(line.substr(recording_text::kCandumpZero.size())));
            latest_ = log_start_.value_or(latest_);
        }
        return std::nullopt;
    }
    const auto logged = time_of(line, first.text);
    if (!logged) {
        return mistake(first.column, logged.error());
    }
    Token interface = first;
    Token word;
    if ((first.text.front() == '(' && !tokens.next(interface)) || !tokens.next(word)) {
        return mistake(first.column,
                       "a time without an interface and a frame" + std::string(kWhatALineIs));
    }
    if (interface.text.size() > kLongestInterface) {
        return mistake(
            interface.column,
            quoted(interface.text) + " is not an interface; names have at most 15 characters");
    }
    const auto frame = parse_candump_frame(tokens, word);
    if (!frame) {
        return mistake(frame.error().at, frame.error().text);
    }
    latest_ = *logged;
    log_start_ = log_start_.value_or(*logged);
    if (!*frame) {
        ++error_frames_;
        return std::nullopt;
    }
    return RecordedCanFrame{*logged - *log_start_, std::string(interface.text), **frame};
}

tl::expected<void, std::string> CandumpReader::finish() const {
    return differences_.probable() ? mistake_at(file_, line_, 1, kDifferences)
                                   : tl::expected<void, std::string>{};
}

tl::expected<std::optional<RecordedCanFrame>, std::string> CandumpFrames::next() {
    Line line;
    while (lines_.next(line)) {
        if (line.too_long) {
            return too_long_line(file_, line);
        }
        // In this format '#' starts the data, not a comment.
        auto frame = reader_.next({line.text.data(), line.text.size() + line.comment.size()});
        if (!frame && any_ && !line.has_end) {
            rest_ = cut_line_text(frame.error());
            break;
        }
        if (!frame || *frame) {
            any_ = true;
            line_ = line.number;
            return frame;
        }
    }
    if (lines_.ended_by_nul()) {
        rest_ = lines_.nul_text(file_);
    }
    if (auto finished = reader_.finish(); !finished) {
        return Mistake(std::move(finished.error()));
    }
    return std::nullopt;
}

tl::expected<Recording, std::string> parse_candump(std::string_view content,
                                                   std::string_view file_name) {
    Recording recording;
    recording.kind = RecordingKind::candump;
    recording.timed = true;
    OnePiece piece(content);
    CandumpFrames frames(piece, file_name);
    auto frame = frames.next();
    for (; frame && *frame; frame = frames.next()) {
        recording.can_frames.push_back(std::move(**frame));
    }
    if (!frame) {
        return Mistake(std::move(frame.error()));
    }
    recording.log = frames.facts();
    recording.rest = frames.rest();
    return recording;
}

}  // namespace tribus
