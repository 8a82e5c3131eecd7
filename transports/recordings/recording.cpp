#include "transports/recordings/recording.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <utility>

#include "transports/recordings/candump.h"
#include "transports/recordings/text.h"

namespace tribus {
namespace {

using recording_text::Line;
using recording_text::Lines;
using recording_text::Mistake;
using recording_text::mistake_at;
using recording_text::parse_microseconds;
using recording_text::quoted;
using recording_text::Token;
using recording_text::Tokens;
using recording_text::trimmed;

constexpr std::string_view kSaleaeHeading = "Time [s],Value,Parity Error,Framing Error";

/// Bytes that start less than this apart are one burst. Longer than two bytes of any supported line
/// (120 us at 100000 baud 8E2), shorter than the distance of SBUS2 slots (docs/protocols/sbus.md,
/// "Footer and SBUS2").
constexpr Duration kBurstGap = std::chrono::microseconds(300);

/// Above any recording; in nanoseconds it fits.
constexpr double kMostSeconds = 1e9;

std::optional<std::uint8_t> parse_byte(std::string_view text, int base) {
    std::uint8_t byte = 0;
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, byte, base);
    return error == std::errc{} && stop == end ? std::optional(byte) : std::nullopt;
}

std::optional<std::uint8_t> parse_hex_byte(std::string_view text) {
    return text.size() == 2 ? parse_byte(text, 16) : std::nullopt;
}

/// The analyser writes seconds, small values also as 5E-05.
std::optional<Duration> parse_seconds(std::string_view text) {
    double seconds = 0;
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, seconds);
    if (error != std::errc{} || stop != end || !(std::abs(seconds) <= kMostSeconds)) {
        return std::nullopt;
    }
    return Duration(std::llround(seconds * 1e9));
}

Recording parse_raw(std::string_view content) {
    Recording recording;
    recording.kind = RecordingKind::raw;
    if (!content.empty()) {
        Burst& burst = recording.bursts.emplace_back();
        burst.bytes.assign(content.begin(), content.end());
        burst.damaged.assign(content.size(), false);
    }
    return recording;
}

tl::expected<Burst, std::string> parse_bytes(std::string_view file, const Line& line,
                                             Tokens tokens) {
    Burst burst;
    Token token;
    while (tokens.next(token)) {
        const bool damaged = token.text.ends_with(recording_text::kDamagedMark);
        const auto byte =
            parse_hex_byte(token.text.substr(0, token.text.size() - (damaged ? 1 : 0)));
        if (!byte) {
            return mistake_at(file, line.number, token.column,
                              quoted(token.text) +
                                  " is not a byte; a byte is two hex digits, with "
                                  "a space between bytes: 20 40 dc 05");
        }
        burst.bytes.push_back(*byte);
        burst.damaged.push_back(damaged);
    }
    return burst;
}

tl::expected<Recording, std::string> parse_hex(std::string_view content, std::string_view file) {
    Recording recording;
    recording.kind = RecordingKind::hex;
    Lines lines(content);
    Line line;
    while (lines.next(line)) {
        auto burst = parse_bytes(file, line, Tokens(line.text));
        if (!burst) {
            return Mistake(std::move(burst.error()));
        }
        if (!burst->bytes.empty()) {
            recording.bursts.push_back(std::move(*burst));
        }
    }
    return recording;
}

tl::expected<Recording, std::string> parse_timed(std::string_view content, std::string_view file) {
    Recording recording;
    recording.kind = RecordingKind::timed;
    recording.timed = true;
    Lines lines(content);
    Line line;
    while (lines.next(line)) {
        Tokens tokens(line.text);
        Token time;
        if (!tokens.next(time)) {
            continue;
        }
        const auto start = parse_microseconds(time.text);
        if (!start) {
            return mistake_at(file, line.number, time.column,
                              quoted(time.text) +
                                  " is not a time; a line of a timed recording starts "
                                  "with decimal microseconds: 1146 20 40 dc 05");
        }
        if (!recording.bursts.empty() && *start < *recording.bursts.back().start) {
            return mistake_at(file, line.number, time.column,
                              "the time " + std::string(time.text) +
                                  " is before that of the line above; times must not decrease");
        }
        auto burst = parse_bytes(file, line, tokens);
        if (!burst) {
            return Mistake(std::move(burst.error()));
        }
        if (burst->bytes.empty()) {
            return mistake_at(file, line.number, time.column,
                              "a time without bytes; the bytes of the burst follow it");
        }
        burst->start = start;
        recording.bursts.push_back(std::move(*burst));
    }
    return recording;
}

/// Columns of the analyser's export.
enum SaleaeColumn : std::size_t { kTime, kValue, kParityError, kFramingError, kSaleaeColumns };
using SaleaeRow = std::array<Token, kSaleaeColumns>;

std::optional<SaleaeRow> split_row(std::string_view text) {
    SaleaeRow row;
    std::size_t start = 0;
    for (std::size_t column = 0; column < kSaleaeColumns; ++column) {
        const std::size_t comma = text.find(',', start);
        const bool last = column + 1 == kSaleaeColumns;
        if ((comma == std::string_view::npos) != last) {
            return std::nullopt;
        }
        const std::size_t end = last ? text.size() : comma;
        row[column] = {trimmed(text.substr(start, end - start), " \t\r\""),
                       static_cast<unsigned>(start + 1)};
        start = end + 1;
    }
    return row;
}

std::optional<std::uint8_t> parse_saleae_value(std::string_view text) {
    const bool hex = text.starts_with("0x") || text.starts_with("0X");
    return hex ? parse_byte(text.substr(2), 16) : parse_byte(text, 10);
}

void add_saleae_byte(Recording& recording, Duration start, std::uint8_t byte, bool damaged,
                     Duration previous) {
    if (recording.bursts.empty() || start - previous >= kBurstGap) {
        recording.bursts.emplace_back().start = start;
    }
    Burst& burst = recording.bursts.back();
    burst.bytes.push_back(byte);
    burst.damaged.push_back(damaged);
}

tl::expected<Recording, std::string> parse_saleae(std::string_view content, std::string_view file) {
    Recording recording;
    recording.kind = RecordingKind::saleae;
    recording.timed = true;
    Lines lines(content);
    Line line;
    bool heading_seen = false;
    Duration previous{};
    while (lines.next(line)) {
        if (trimmed(line.text).empty()) {
            continue;
        }
        if (!heading_seen) {
            if (trimmed(line.text) != kSaleaeHeading) {
                return mistake_at(file, line.number, 1,
                                  "not the export of a serial decoder, whose first line is " +
                                      std::string(kSaleaeHeading));
            }
            heading_seen = true;
            continue;
        }
        const auto row = split_row(line.text);
        if (!row) {
            return mistake_at(file, line.number, 1,
                              "a row needs four columns: " + std::string(kSaleaeHeading));
        }
        const auto start = parse_seconds((*row)[kTime].text);
        if (!start || (!recording.bursts.empty() && *start < previous)) {
            return mistake_at(
                file, line.number, (*row)[kTime].column,
                quoted((*row)[kTime].text) +
                    (start ? " is before the time of the row above" : " is not a time") +
                    "; times are seconds and must not decrease");
        }
        const auto byte = parse_saleae_value((*row)[kValue].text);
        if (!byte) {
            return mistake_at(file, line.number, (*row)[kValue].column,
                              quoted((*row)[kValue].text) +
                                  " is not a byte; export with hexadecimal values: 0x0F");
        }
        const bool damaged =
            !(*row)[kParityError].text.empty() || !(*row)[kFramingError].text.empty();
        add_saleae_byte(recording, *start, *byte, damaged, previous);
        previous = *start;
    }
    return recording;
}

}  // namespace

tl::expected<Recording, std::string> parse_recording(std::string_view content,
                                                     std::string_view file_name,
                                                     RecordingKind kind) {
    switch (kind) {
        case RecordingKind::raw:
            break;
        case RecordingKind::hex:
            return parse_hex(content, file_name);
        case RecordingKind::timed:
            return parse_timed(content, file_name);
        case RecordingKind::saleae:
            return parse_saleae(content, file_name);
        case RecordingKind::candump:
            return parse_candump(content, file_name);
    }
    return parse_raw(content);
}

tl::expected<Recording, std::string> parse_recording(std::string_view content,
                                                     std::string_view file_name) {
    const auto kind = detect_recording_kind(content, file_name);
    if (!kind) {
        return Mistake(kind.error());
    }
    return parse_recording(content, file_name, *kind);
}

}  // namespace tribus
