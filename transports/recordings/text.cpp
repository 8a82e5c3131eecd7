#include "transports/recordings/text.h"

#include <algorithm>
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

std::string_view without_byte_order_mark(std::string_view content) {
    if (content.starts_with(kByteOrderMark)) {
        content.remove_prefix(kByteOrderMark.size());
    }
    return content;
}

}  // namespace

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

bool Lines::next(Line& line) {
    if (rest_.empty()) {
        return false;
    }
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    const std::string_view whole = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    const std::size_t comment = std::min(whole.find('#'), whole.size());
    line = {++number_, whole.substr(0, comment), whole.substr(comment)};
    return true;
}

bool Tokens::next(Token& token) {
    const std::size_t start = line_.find_first_not_of(" \t\r", at_);
    if (start == std::string_view::npos) {
        return false;
    }
    at_ = std::min(line_.find_first_of(" \t\r", start), line_.size());
    token = {line_.substr(start, at_ - start), static_cast<unsigned>(start + 1)};
    return true;
}

Oddities find_oddities(std::string_view content) {
    content = without_byte_order_mark(content);
    Oddities found;
    unsigned line = 1;
    unsigned column = 0;
    bool comment = false;
    for (const char character : content) {
        ++column;
        const auto byte = static_cast<unsigned char>(character);
        const bool blank = byte == '\t' || byte == '\n' || byte == '\r';
        const bool odd = (byte < 0x20 && !blank) || byte == 0x7F || (byte >= 0x80 && !comment);
        if (odd && found.count++ == 0) {
            found.line = line;
            found.column = column;
        }
        comment = byte != '\n' && (comment || byte == '#');
        if (byte == '\n') {
            ++line;
            column = 0;
        }
    }
    return found;
}

}  // namespace tribus::recording_text
