#include "transports/recordings/text.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "core/quotes.h"

namespace tribus::recording_text {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

/// 15 digits of microseconds are 31 years; in nanoseconds they fit.
constexpr std::size_t kMostTimeDigits = 15;

bool is_digit(char character) {
    return character >= '0' && character <= '9';
}

bool is_blank(char character) {
    return character == ' ' || character == '\t' || character == '\r';
}

enum class Kind : std::uint8_t { plain, line_end, comment, control, high };

constexpr std::array<Kind, 256> kKinds = [] {
    std::array<Kind, 256> kinds{};
    for (std::size_t byte = 0; byte < kinds.size(); ++byte) {
        const bool blank = byte == '\t' || byte == '\r';
        kinds[byte] = byte == '\n'                              ? Kind::line_end
                      : byte == '#'                             ? Kind::comment
                      : (byte < 0x20 && !blank) || byte == 0x7F ? Kind::control
                      : byte >= 0x80                            ? Kind::high
                                                                : Kind::plain;
    }
    return kinds;
}();

}  // namespace

std::string_view without_byte_order_mark(std::string_view content) {
    if (content.starts_with(kByteOrderMark)) {
        content.remove_prefix(kByteOrderMark.size());
    }
    return content;
}

Mistake mistake_at(std::string_view file, unsigned line, unsigned column, std::string_view text) {
    std::string message(file);
    message.append(":").append(std::to_string(line));
    message.append(":").append(std::to_string(column));
    message.append(": ").append(text);
    return Mistake(std::move(message));
}

std::string quoted(std::string_view text) {
    constexpr std::size_t kLongest = 24;
    return in_quotes(text, kLongest);
}

std::string_view trimmed(std::string_view text, std::string_view blanks) {
    const std::size_t start = std::min(text.find_first_not_of(blanks), text.size());
    text.remove_prefix(start);
    return text.substr(0, text.find_last_not_of(blanks) + 1);
}

std::optional<Duration> parse_microseconds(std::string_view text) {
    const bool negative = text.starts_with('-');
    text.remove_prefix(negative ? 1 : 0);
    const std::size_t point = std::min(text.find('.'), text.size());
    const std::string_view whole = text.substr(0, point);
    const std::string_view fraction = text.substr(std::min(point + 1, text.size()));
    if (whole.empty() || whole.size() > kMostTimeDigits ||
        (point < text.size() && fraction.empty()) ||
        !std::all_of(whole.begin(), whole.end(), is_digit) ||
        !std::all_of(fraction.begin(), fraction.end(), is_digit)) {
        return std::nullopt;
    }
    std::int64_t nanoseconds = 0;
    for (const char digit : whole) {
        nanoseconds = nanoseconds * 10 + (digit - '0');
    }
    for (std::size_t place = 0; place < 3; ++place) {
        nanoseconds = nanoseconds * 10 + (place < fraction.size() ? fraction[place] - '0' : 0);
    }
    return Duration(negative ? -nanoseconds : nanoseconds);
}

Lines::Lines(std::string_view content) : rest_(without_byte_order_mark(content)) {}

Lines::Lines(Pieces& pieces) : pieces_(&pieces), rest_(without_byte_order_mark(pieces.next())) {}

void Lines::keep(std::string_view part) {
    too_long_ = too_long_ || part.size() > kLongestLine - begun_.size();
    begun_ += part.substr(0, kLongestLine - begun_.size());
}

/// Empty also at the end, which `ended_` tells.
std::string_view Lines::whole_line() {
    begun_.clear();
    too_long_ = false;
    std::size_t end = rest_.find('\n');
    while (end == std::string_view::npos) {
        // Bytes of a piece are gone with the next one.
        keep(rest_);
        rest_ = pieces_ != nullptr ? pieces_->next() : std::string_view{};
        if (rest_.empty()) {
            ended_ = true;
            return begun_;
        }
        end = rest_.find('\n');
    }
    const std::string_view in_piece = rest_.substr(0, end);
    rest_.remove_prefix(end + 1);
    if (begun_.empty() && in_piece.size() <= kLongestLine) {
        return in_piece;
    }
    keep(in_piece);
    return begun_;
}

bool Lines::next(Line& line) {
    if (ended_) {
        return false;
    }
    const std::string_view whole = whole_line();
    if (const std::size_t nul = whole.find('\0'); nul != std::string_view::npos) {
        ended_ = true;
        nul_column_ = static_cast<unsigned>(nul + 1);
        return false;
    }
    if (ended_ && whole.empty()) {
        return false;
    }
    const std::size_t comment = std::min(whole.find('#'), whole.size());
    line = {.number = ++number_,
            .text = whole.substr(0, comment),
            .comment = whole.substr(comment),
            .has_end = !ended_,
            .too_long = too_long_};
    return true;
}

std::string nul_text(std::string_view file, unsigned line, unsigned column) {
    return mistake_at(file, line, column,
                      "NUL bytes from here on, as a loss of power leaves them; the lines above are "
                      "read")
        .value();
}

Mistake too_long_line(std::string_view file, const Line& line) {
    return mistake_at(file, line.number, 1,
                      "a line of more than " + std::to_string(kLongestLine) +
                          " characters; write one burst a line");
}

std::string cut_line_text(std::string_view mistake) {
    return std::string(mistake) +
           "; the file ends in this line, as a loss of power leaves it; the lines above are read";
}

bool Tokens::next(Token& token) {
    std::size_t start = at_;
    while (start < line_.size() && is_blank(line_[start])) {
        ++start;
    }
    if (start == line_.size()) {
        return false;
    }
    at_ = start;
    while (at_ < line_.size() && !is_blank(line_[at_])) {
        ++at_;
    }
    token = {line_.substr(start, at_ - start), static_cast<unsigned>(start + 1)};
    return true;
}

void Oddities::found(std::size_t column) {
    if (count_ == 0) {
        line_ = lines_before_ + 1;
        column_ = static_cast<unsigned>(column);
    }
}

/// More follows on the NUL bytes, so they are not the end of a text.
void Oddities::take_nuls() {
    count_ += std::exchange(nuls_, 0);
}

void Oddities::take(std::string_view piece) {
    std::size_t line_start = 0;
    for (std::size_t at = 0; at < piece.size(); ++at) {
        if (piece[at] == '\0') {
            found(begun_ + at - line_start + 1);
            ++nuls_;
            continue;
        }
        take_nuls();
        const Kind kind = kKinds[static_cast<unsigned char>(piece[at])];
        if (kind == Kind::plain) {
            continue;
        }
        if (kind == Kind::line_end) {
            ++lines_before_;
            line_start = at + 1;
            begun_ = 0;
            comment_ = false;
        } else if (kind == Kind::comment) {
            comment_ = true;
        } else if (kind == Kind::control || !comment_) {
            found(begun_ + at - line_start + 1);
            ++count_;
        }
    }
    begun_ += piece.size() - line_start;
    size_ += piece.size();
}

}  // namespace tribus::recording_text
