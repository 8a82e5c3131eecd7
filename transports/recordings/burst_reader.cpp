#include "transports/recordings/burst_reader.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <utility>

#include "transports/recordings/text.h"

namespace tribus {
namespace {

using recording_text::cut_line_text;
using recording_text::Line;
using recording_text::Lines;
using recording_text::Mistake;
using recording_text::mistake_at;
using recording_text::parse_microseconds;
using recording_text::quoted;
using recording_text::Token;
using recording_text::Tokens;
using recording_text::too_long_line;
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

/// -1 for another character.
int hex_digit(char character) {
    if (character >= '0' && character <= '9') {
        return character - '0';
    }
    const int letter = character | 0x20;
    return letter >= 'a' && letter <= 'f' ? letter - 'a' + 10 : -1;
}

std::optional<std::uint8_t> parse_hex_byte(std::string_view text) {
    if (text.size() != 2) {
        return std::nullopt;
    }
    const int high = hex_digit(text[0]);
    const int low = hex_digit(text[1]);
    return high < 0 || low < 0 ? std::nullopt
                               : std::optional(static_cast<std::uint8_t>(high << 4 | low));
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

/// One byte as programs print it: `0x20`, `0xF`, perhaps with a comma behind it.
std::optional<std::uint8_t> parse_prefixed_byte(std::string_view text) {
    text = text.substr(0, text.size() - (text.ends_with(',') ? 1 : 0));
    const bool prefixed = text.starts_with("0x") || text.starts_with("0X");
    return prefixed && text.size() <= 4 ? parse_byte(text.substr(2), 16) : std::nullopt;
}

/// Adds the bytes of a word. Returns false if it is none.
bool add_word(std::string_view word, Burst& burst) {
    const auto add = [&burst](std::uint8_t byte, bool damaged) {
        burst.bytes.push_back(byte);
        burst.damaged.push_back(damaged);
    };
    const bool damaged = word.ends_with(recording_text::kDamagedMark);
    const std::string_view text = word.substr(0, word.size() - (damaged ? 1 : 0));
    if (const auto prefixed = parse_prefixed_byte(text)) {
        add(*prefixed, damaged);
        return true;
    }
    // A mark belongs to one byte.
    if (text.empty() || text.size() % 2 != 0 || (damaged && text.size() != 2)) {
        return false;
    }
    for (std::size_t at = 0; at < text.size(); at += 2) {
        const auto byte = parse_hex_byte(text.substr(at, 2));
        if (!byte) {
            return false;
        }
        add(*byte, damaged);
    }
    return true;
}

tl::expected<Burst, std::string> parse_bytes(std::string_view file, const Line& line,
                                             Tokens tokens) {
    Burst burst;
    Token token;
    while (tokens.next(token)) {
        if (!add_word(token.text, burst)) {
            return mistake_at(file, line.number, token.column,
                              quoted(token.text) +
                                  " is not a byte; a byte is two hex digits, with "
                                  "a space between bytes: 20 40 dc 05");
        }
    }
    return burst;
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

struct SaleaeByte {
    Duration start{};
    std::uint8_t value = 0;
    bool damaged = false;
};

tl::expected<SaleaeByte, std::string> parse_saleae_row(std::string_view file, const Line& line,
                                                       std::optional<Duration> previous) {
    const auto row = split_row(line.text);
    if (!row) {
        return mistake_at(file, line.number, 1,
                          "a row needs four columns: " + std::string(kSaleaeHeading));
    }
    const auto start = parse_seconds((*row)[kTime].text);
    if (!start || (previous && *start < *previous)) {
        return mistake_at(file, line.number, (*row)[kTime].column,
                          quoted((*row)[kTime].text) +
                              (start ? " is before the time of the row above" : " is not a time") +
                              "; times are seconds and must not decrease");
    }
    const auto byte = parse_saleae_value((*row)[kValue].text);
    if (!byte) {
        return mistake_at(
            file, line.number, (*row)[kValue].column,
            quoted((*row)[kValue].text) + " is not a byte; export with hexadecimal values: 0x0F");
    }
    return SaleaeByte{
        .start = *start,
        .value = *byte,
        .damaged = !(*row)[kParityError].text.empty() || !(*row)[kFramingError].text.empty()};
}

}  // namespace

BurstReader::BurstReader(Pieces& content, std::string_view file_name, RecordingKind kind)
    : content_(content), file_(file_name), kind_(kind) {
    if (kind != RecordingKind::raw) {
        lines_.emplace(content);
    }
}

BurstReader::Next BurstReader::next() {
    return kind_ == RecordingKind::raw ? next_raw() : judged(next_of_kind());
}

BurstReader::Next BurstReader::next_of_kind() {
    switch (kind_) {
        case RecordingKind::hex:
            return next_hex();
        case RecordingKind::timed:
            return next_timed();
        default:
            return next_saleae();
    }
}

bool BurstReader::next_line(Line& line) {
    if (!lines_->next(line)) {
        return false;
    }
    latest_ = line;
    return !line.too_long;
}

BurstReader::Next BurstReader::judged(Next read) {
    if (read && *read) {
        any_ = true;
        return read;
    }
    if (latest_.too_long) {
        return too_long_line(file_, latest_);
    }
    if (read && lines_->ended_by_nul()) {
        rest_ = lines_->nul_text(file_);
    }
    const bool cut = !read && any_ && !latest_.has_end;
    if (cut) {
        rest_ = cut_line_text(read.error());
    }
    return cut ? pending_burst() : read;
}

BurstReader::Next BurstReader::next_raw() {
    const std::string_view piece = content_.next();
    if (piece.empty()) {
        return std::nullopt;
    }
    return Burst{.start = std::nullopt,
                 .bytes = {piece.begin(), piece.end()},
                 .damaged = std::vector<bool>(piece.size())};
}

BurstReader::Next BurstReader::next_hex() {
    Line line;
    while (next_line(line)) {
        auto burst = parse_bytes(file_, line, Tokens(line.text));
        if (!burst) {
            return Mistake(std::move(burst.error()));
        }
        if (!burst->bytes.empty()) {
            line_ = line.number;
            return std::move(*burst);
        }
    }
    return std::nullopt;
}

BurstReader::Next BurstReader::next_timed() {
    Line line;
    Token time;
    std::optional<Tokens> tokens;
    do {
        if (!next_line(line)) {
            return std::nullopt;
        }
        tokens.emplace(line.text);
    } while (!tokens->next(time));
    const auto start = parse_microseconds(time.text);
    if (!start) {
        return mistake_at(file_, line.number, time.column,
                          quoted(time.text) +
                              " is not a time; a line of a timed recording starts "
                              "with decimal microseconds: 1146 20 40 dc 05");
    }
    if (previous_ && *start < *previous_) {
        return mistake_at(file_, line.number, time.column,
                          "the time " + std::string(time.text) +
                              " is before that of the line above; times must not decrease");
    }
    auto burst = parse_bytes(file_, line, *tokens);
    if (!burst) {
        return Mistake(std::move(burst.error()));
    }
    if (burst->bytes.empty()) {
        return mistake_at(file_, line.number, time.column,
                          "a time without bytes; the bytes of the burst follow it");
    }
    burst->start = start;
    previous_ = start;
    line_ = line.number;
    return std::move(*burst);
}

/// A burst ends with the byte that begins the next one.
BurstReader::Next BurstReader::next_saleae() {
    Line line;
    while (next_line(line)) {
        if (trimmed(line.text).empty()) {
            continue;
        }
        if (!std::exchange(heading_seen_, true)) {
            if (trimmed(line.text) != kSaleaeHeading) {
                return mistake_at(file_, line.number, 1,
                                  "not the export of a serial decoder, whose first line is " +
                                      std::string(kSaleaeHeading));
            }
            continue;
        }
        const auto byte = parse_saleae_row(file_, line, previous_);
        if (!byte) {
            return Mistake(byte.error());
        }
        any_ = true;
        const bool goes_on = previous_ && byte->start - *previous_ < kBurstGap;
        Burst ended =
            goes_on
                ? Burst{}
                : std::exchange(begun_, Burst{.start = byte->start, .bytes = {}, .damaged = {}});
        const unsigned ended_line = goes_on ? 0 : std::exchange(begun_line_, line.number);
        previous_ = byte->start;
        begun_.bytes.push_back(byte->value);
        begun_.damaged.push_back(byte->damaged);
        if (!ended.bytes.empty()) {
            line_ = ended_line;
            return ended;
        }
    }
    return pending_burst();
}

BurstReader::Next BurstReader::pending_burst() {
    line_ = begun_.bytes.empty() ? line_ : begun_line_;
    Burst last = std::exchange(begun_, {});
    return last.bytes.empty() ? Next(std::nullopt) : Next(std::move(last));
}

}  // namespace tribus
