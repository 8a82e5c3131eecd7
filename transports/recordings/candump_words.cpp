#include "transports/recordings/candump_words.h"

#include <algorithm>
#include <charconv>

namespace tribus {
namespace {

using recording_text::quoted;
using recording_text::Token;
using recording_text::Tokens;

/// Set in the id of a line that is an error frame of the kernel (CAN_ERR_FLAG).
constexpr std::uint32_t kErrorFlag = 0x2000'0000;
constexpr std::size_t kStandardDigits = 3;
constexpr std::size_t kExtendedDigits = 8;

/// Flags after "##". 4 also marks FD, 8 has no meaning.
constexpr unsigned kBitRateSwitch = 1;
constexpr unsigned kErrorStateIndicator = 2;

/// 10 digits of seconds reach to the year 2286; in nanoseconds they fit.
constexpr std::size_t kMostSecondDigits = 10;
constexpr std::uint64_t kMostUnixSeconds = 9'000'000'000;
constexpr std::size_t kMostFractionDigits = 9;

using Flaw = CandumpFlaw;
using FlawFound = tl::unexpected<Flaw>;

template <class Number>
std::optional<Number> parse_number(std::string_view text, int base) {
    Number number = 0;
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, number, base);
    return error == std::errc{} && stop == end ? std::optional(number) : std::nullopt;
}

std::optional<std::uint32_t> parse_hex(std::string_view digits) {
    return parse_number<std::uint32_t>(digits, 16);
}

bool is_error_frame(std::string_view word) {
    const auto id = parse_hex(word.substr(0, kExtendedDigits));
    return word.size() > kExtendedDigits && word[kExtendedDigits] == '#' && id &&
           (*id & kErrorFlag) != 0;
}

tl::expected<void, Flaw> read_id(std::string_view digits, CanFrame& frame) {
    const auto id = parse_hex(digits);
    const bool right_size = digits.size() == kStandardDigits || digits.size() == kExtendedDigits;
    if (!id || !right_size) {
        return FlawFound(
            {0, quoted(digits) + " is not an id; an 11-bit id is 3 hex digits, a 29-bit id is 8"});
    }
    frame.extended = digits.size() == kExtendedDigits;
    frame.id = *id;
    if (*id > (frame.extended ? kMostExtendedId : kMostStandardId)) {
        return FlawFound({0, quoted(digits) + " is above the highest id, " +
                                 (frame.extended ? "1FFFFFFF" : "7FF")});
    }
    return {};
}

/// Removes bytes from the front of `text`; points may separate them.
tl::expected<void, Flaw> read_data(std::string_view& text, std::size_t offset, CanFrame& frame) {
    const std::size_t most = frame.fd ? kMostFdBytes : kMostClassicBytes;
    const std::size_t size = text.size();
    while (!text.empty() && text.front() != '_') {
        const std::size_t at = offset + size - text.size();
        if (frame.length > 0 && text.front() == '.') {
            text.remove_prefix(1);
        }
        const auto byte = parse_number<std::uint8_t>(text.substr(0, 2), 16);
        if (!byte || text.size() < 2) {
            return FlawFound(
                {at, quoted(text.substr(0, 2)) + " is not a byte; a byte is two hex digits"});
        }
        if (frame.length == most) {
            return FlawFound({at, "more than " + std::to_string(most) + " bytes in one frame" +
                                      (frame.fd ? "" : "; FD frames have ## after the id")});
        }
        frame.data[frame.length++] = *byte;
        text.remove_prefix(2);
    }
    return {};
}

tl::expected<void, Flaw> read_fd(std::string_view text, std::size_t offset, CanFrame& frame) {
    const auto flags = parse_hex(text.substr(0, 1));
    if (!flags) {
        return FlawFound({offset, "## is followed by one hex digit of flags, then the data"});
    }
    frame.fd = true;
    frame.bit_rate_switch = (*flags & kBitRateSwitch) != 0;
    frame.error_state_indicator = (*flags & kErrorStateIndicator) != 0;
    text.remove_prefix(1);
    if (auto read = read_data(text, offset + 1, frame); !read) {
        return read;
    }
    if (!text.empty() || !valid_can_length(frame.length, true)) {
        return FlawFound({offset,
                          "an FD frame has 0 to 8, 12, 16, 20, 24, 32, 48 or 64 bytes of "
                          "data, this one has " +
                              std::to_string(frame.length) + std::string(text)});
    }
    return {};
}

tl::expected<void, Flaw> read_classic(std::string_view text, std::size_t offset, CanFrame& frame) {
    const std::size_t size = text.size();
    frame.remote = text.starts_with('R') || text.starts_with('r');
    if (frame.remote) {
        text.remove_prefix(1);
        const auto length = parse_hex(text.substr(0, 1));
        frame.length = length && *length <= kMostClassicBytes ? static_cast<std::uint8_t>(*length)
                                                              : std::uint8_t{0};
        text.remove_prefix(length && *length <= kMostClassicBytes ? 1 : 0);
    } else if (auto read = read_data(text, offset, frame); !read) {
        return read;
    }
    // The length code as sent; 9 to F also mean 8 bytes.
    const auto code =
        text.size() == 2 && text.front() == '_' ? parse_hex(text.substr(1)) : std::nullopt;
    if (text.empty() || (code && *code > kMostClassicBytes && frame.length == kMostClassicBytes)) {
        return {};
    }
    return FlawFound({offset + size - text.size(),
                      quoted(text) + " is not allowed here; 8 bytes may be followed by _9 to _F"});
}

/// `123#1122`, `12345678#R5`, `123##1` followed by up to 64 bytes.
tl::expected<CanFrame, Flaw> parse_frame(std::string_view word) {
    const std::size_t mark = word.find('#');
    if (mark == std::string_view::npos) {
        return FlawFound({0, quoted(word) + " is not a frame" + std::string(kWhatALineIs)});
    }
    CanFrame frame;
    if (auto read = read_id(word.substr(0, mark), frame); !read) {
        return FlawFound(std::move(read.error()));
    }
    const bool fd = word.substr(mark).starts_with("##");
    const std::size_t offset = mark + (fd ? 2 : 1);
    const auto read = fd ? read_fd(word.substr(offset), offset, frame)
                         : read_classic(word.substr(offset), offset, frame);
    if (!read) {
        return FlawFound(read.error());
    }
    return frame;
}

/// The length on a screen: `[8]`, of FD frames two digits.
std::optional<std::size_t> shown_length(std::string_view word) {
    const bool bracketed = word.size() >= 3 && word.front() == '[' && word.back() == ']';
    return bracketed ? parse_number<std::size_t>(word.substr(1, word.size() - 2), 10)
                     : std::nullopt;
}

/// With -x, candump shows the direction and two flags before the id.
bool is_shown_direction(std::string_view word) {
    return word == "RX" || word == "TX";
}

/// The id and the length of a line of the screen, from `id` on.
std::optional<std::size_t> find_shown_length(Tokens& tokens, Token& id, Token& length) {
    Token flag;
    if (is_shown_direction(id.text) &&
        !(tokens.next(flag) && tokens.next(flag) && tokens.next(id))) {
        return std::nullopt;
    }
    return tokens.next(length) ? shown_length(length.text) : std::nullopt;
}

/// `123   [2]  11 22`: the bytes behind the length. What candump adds behind them is passed over.
tl::expected<CanFrame, Flaw> parse_shown(Tokens& tokens, const Token& id, const Token& length,
                                         std::size_t bytes) {
    constexpr std::size_t kFdLengthWord = 4;
    CanFrame frame;
    if (auto read = read_id(id.text, frame); !read) {
        return FlawFound({id.column + read.error().at, std::move(read.error().text)});
    }
    frame.fd = length.text.size() == kFdLengthWord;
    if (!valid_can_length(static_cast<std::uint8_t>(std::min(bytes, kMostFdBytes + 1)), frame.fd)) {
        return FlawFound({length.column, quoted(length.text) + " is not the length of a frame"});
    }
    Token word;
    bool more = tokens.next(word);
    frame.remote = more && word.text == "remote";
    if (frame.remote) {
        frame.length = static_cast<std::uint8_t>(bytes);
        return frame;
    }
    for (; frame.length < bytes; more = tokens.next(word)) {
        const auto byte =
            more ? parse_number<std::uint8_t>(word.text, 16) : std::optional<std::uint8_t>();
        if (!byte || word.text.size() != 2) {
            return FlawFound({more ? word.column : length.column,
                              "the frame has fewer bytes than " + std::string(length.text)});
        }
        frame.data[frame.length++] = *byte;
    }
    return frame;
}

/// Newer versions of candump append whether the frame was received or sent.
bool is_direction(std::string_view word) {
    return word == "R" || word == "T";
}

}  // namespace

std::optional<Duration> parse_candump_time(std::string_view word) {
    if (word.size() < 2 || word.front() != '(' || word.back() != ')') {
        return std::nullopt;
    }
    word = word.substr(1, word.size() - 2);
    const std::size_t point = std::min(word.find('.'), word.size());
    const std::string_view whole = word.substr(0, point);
    const std::string_view decimals = word.substr(std::min(point + 1, word.size()));
    if (whole.size() > kMostSecondDigits || decimals.size() > kMostFractionDigits) {
        return std::nullopt;
    }
    std::string padded(decimals);
    padded.resize(kMostFractionDigits, '0');
    const auto seconds = parse_number<std::uint64_t>(whole, 10);
    const auto nanoseconds = parse_number<std::uint64_t>(padded, 10);
    if (!seconds || !nanoseconds || *seconds > kMostUnixSeconds) {
        return std::nullopt;
    }
    return Duration(static_cast<std::int64_t>(*seconds * 1'000'000'000 + *nanoseconds));
}

bool is_candump_screen_line(std::string_view line) {
    Tokens tokens(line);
    Token interface;
    Token id;
    Token length;
    return tokens.next(interface) && tokens.next(id) && find_shown_length(tokens, id, length);
}

tl::expected<std::optional<CanFrame>, CandumpFlaw> parse_candump_frame(Tokens& tokens,
                                                                       const Token& word) {
    Token length;
    Token id = word;
    if (const auto bytes = word.text.find('#') == std::string_view::npos
                               ? find_shown_length(tokens, id, length)
                               : std::nullopt) {
        const auto number = parse_hex(id.text);
        if (number && (*number & kErrorFlag) != 0) {
            return std::nullopt;
        }
        return parse_shown(tokens, id, length, *bytes);
    }
    if (is_error_frame(word.text)) {
        return std::nullopt;
    }
    auto frame = parse_frame(word.text);
    if (!frame) {
        return FlawFound({word.column + frame.error().at, std::move(frame.error().text)});
    }
    Token further;
    if (tokens.next(further) && (!is_direction(further.text) || tokens.next(further))) {
        return FlawFound({further.column,
                          quoted(further.text) + " after the frame" + std::string(kWhatALineIs)});
    }
    return *frame;
}

}  // namespace tribus
