#include "transports/codecs/dbc/message_reader.h"

#include <charconv>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

namespace tribus {
namespace {

/// The placeholder message for signals that belong to no message (docs/protocols/can.md, "DBC
/// files").
constexpr std::string_view kPlaceholder = "VECTOR__INDEPENDENT_SIG_MSG";
constexpr std::uint32_t kPlaceholderId = 0xC0000000U;
constexpr std::uint32_t kLastStandardId = 0x7FF;
constexpr std::uint32_t kLastExtendedId = 0x1FFFFFFF;
/// Limit of J1939-21's transport protocol in bytes, the longest of all.
constexpr std::uint32_t kLongestMessage = 1785;
constexpr std::uint32_t kAnyUnsigned = std::numeric_limits<std::uint32_t>::max();

struct SignalPlaces {
    DbcPlace name;
    DbcPlace length;
    DbcPlace factor;
};

/// Number of bits up to the end of the signal, in wire order: a Motorola signal starts at its most
/// significant bit and goes down.
unsigned bits_needed(const DbcSignal& signal) {
    const unsigned before = signal.byte_order == DbcByteOrder::intel
                                ? signal.start_bit
                                : signal.start_bit / 8 * 8 + 7 - signal.start_bit % 8;
    return before + signal.bit_length;
}

std::optional<DbcMistake> wrong_id(const DbcMessage& message, DbcPlace place) {
    if (message.id <= (message.extended ? kLastExtendedId : kLastStandardId)) {
        return std::nullopt;
    }
    const std::string shown = "the id of message " + message.name + ", ";
    if (message.extended) {
        return dbc_mistake_at(place, shown + std::to_string(message.id | kDbcExtendedFlag) +
                                         ", has more than 29 bits besides bit 31");
    }
    return dbc_mistake_at(place, shown + std::to_string(message.id) +
                                     ", has more than 11 bits; a 29-bit id has bit 31 set in the "
                                     "file, so add 2147483648 to it");
}

std::optional<DbcMistake> wrong_signal(const DbcMessage& message, const DbcSignal& signal,
                                       const SignalPlaces& places) {
    if (signal.bit_length < 1 || signal.bit_length > kLongestDbcSignal) {
        return dbc_mistake_at(places.length, "signal " + signal.name + " is " +
                                                 std::to_string(signal.bit_length) +
                                                 " bits long; allowed are 1 to 64");
    }
    if (const unsigned needed = bits_needed(signal); needed > message.length * 8) {
        return dbc_mistake_at(places.name, "signal " + signal.name + " needs " +
                                               std::to_string((needed + 7) / 8) +
                                               " bytes, but message " + message.name + " has " +
                                               std::to_string(message.length));
    }
    if (signal.factor == 0) {
        return dbc_mistake_at(places.factor, "the factor of signal " + signal.name +
                                                 " is 0: all raw values would have one meaning");
    }
    return std::nullopt;
}

/// Accepts M, m<number>, m<number>M, m, or nothing before the colon.
bool read_multiplexing(DbcTokens& tokens, DbcSignal& signal) {
    if (tokens.token().kind != DbcTokenKind::word) {
        return tokens.take_mark(':', "after the name of the signal");
    }
    std::string_view text = tokens.token().text;
    signal.is_selector = text.ends_with('M');
    text.remove_suffix(signal.is_selector ? 1 : 0);
    bool understood = signal.is_selector && text.empty();
    if (text == "m" && !signal.is_selector) {
        understood = true;
        signal.page_unknown = true;
    } else if (text.starts_with('m')) {
        std::uint64_t page = 0;
        const char* const end = text.data() + text.size();
        const auto [stop, error] = std::from_chars(text.data() + 1, end, page);
        understood = error == std::errc{} && stop == end;
        signal.selected_by = {{page, page}};
    }
    if (!understood) {
        return tokens.fail_expected("':' or a multiplexing mark (M, m0 or m0M)");
    }
    tokens.advance();
    return tokens.take_mark(':', "after the multiplexing mark");
}

bool read_position(DbcTokens& tokens, DbcSignal& signal, SignalPlaces& places) {
    constexpr std::uint32_t kLastBit = kLongestMessage * 8 - 1;
    std::uint32_t order = 0;
    if (!tokens.take_unsigned(signal.start_bit, kLastBit, "the start bit") ||
        !tokens.take_mark('|', "after the start bit")) {
        return false;
    }
    places.length = tokens.token().place;
    if (!tokens.take_unsigned(signal.bit_length, kAnyUnsigned, "the length in bits") ||
        !tokens.take_mark('@', "after the length in bits") ||
        !tokens.take_unsigned(order, 1, "the byte order (0 Motorola, 1 Intel)")) {
        return false;
    }
    signal.byte_order = order == 0 ? DbcByteOrder::motorola : DbcByteOrder::intel;
    if (!tokens.token().is_mark('+') && !tokens.token().is_mark('-')) {
        return tokens.fail_expected("'+' (unsigned) or '-' (signed) after the byte order");
    }
    signal.is_signed = tokens.take_sign();
    return true;
}

bool read_scaling(DbcTokens& tokens, DbcSignal& signal, SignalPlaces& places) {
    if (!tokens.take_mark('(', "before the factor")) {
        return false;
    }
    places.factor = tokens.token().place;
    return tokens.take_double(signal.factor, "the factor") &&
           tokens.take_mark(',', "after the factor") &&
           tokens.take_double(signal.offset, "the offset") &&
           tokens.take_mark(')', "after the offset") &&
           tokens.take_mark('[', "before the minimum") &&
           tokens.take_limit(signal.minimum, "the minimum") &&
           tokens.take_mark('|', "after the minimum") &&
           tokens.take_limit(signal.maximum, "the maximum") &&
           tokens.take_mark(']', "after the maximum") &&
           tokens.take_string(signal.unit, "the unit in quotes");
}

/// Receivers are on the line of the signal, or follow a comma.
void skip_receivers(DbcTokens& tokens) {
    bool comma = false;
    while (tokens.token().is_mark(',') || (tokens.token().kind == DbcTokenKind::word &&
                                           (comma || !tokens.token().first_on_line))) {
        comma = tokens.token().is_mark(',');
        tokens.advance();
    }
}

bool read_signal(DbcTokens& tokens, DbcMessageStatement& statement, bool placeholder) {
    DbcSignal signal;
    SignalPlaces places;
    places.name = tokens.token().place;
    signal.line = places.name.line;
    std::string_view name;
    if (!tokens.take_word(name, "the name of the signal")) {
        return false;
    }
    signal.name = utf8_from_dbc(name);
    if (!read_multiplexing(tokens, signal) || !read_position(tokens, signal, places) ||
        !read_scaling(tokens, signal, places)) {
        return false;
    }
    skip_receivers(tokens);
    if (placeholder) {
        return true;
    }
    statement.signal_faults.push_back(wrong_signal(statement.message, signal, places));
    statement.message.signals.push_back(std::move(signal));
    statement.signal_names.push_back(name);
    statement.signal_places.push_back(places.name);
    return true;
}

bool read_heading(DbcTokens& tokens, DbcMessageStatement& statement) {
    DbcMessage& message = statement.message;
    message.line = tokens.token().place.line;
    std::uint32_t id = 0;
    if (!tokens.take_unsigned(id, kAnyUnsigned, "the id of the message")) {
        // The name behind it tells whether somebody uses the message.
        if (!tokens.at_section()) {
            tokens.advance();
        }
        if (tokens.token().kind == DbcTokenKind::word && !tokens.at_section()) {
            message.name = utf8_from_dbc(tokens.token().text);
        }
        return false;
    }
    statement.file_id = id;
    message.extended = (id & kDbcExtendedFlag) != 0;
    message.id = id & ~kDbcExtendedFlag;
    statement.name_place = tokens.token().place;
    if (!tokens.take_word(statement.name, "the name of the message") ||
        !tokens.take_mark(':', "after the name of the message")) {
        return false;
    }
    message.name = utf8_from_dbc(statement.name);
    statement.length_place = tokens.token().place;
    if (!tokens.take_unsigned(message.length, kLongestMessage,
                              "the length of the message in bytes")) {
        return false;
    }
    if (tokens.token().kind == DbcTokenKind::word && !tokens.token().first_on_line) {
        message.sender = utf8_from_dbc(tokens.token().text);
        tokens.advance();
    }
    return true;
}

bool is_placeholder(const DbcMessageStatement& statement) {
    return statement.file_id == kPlaceholderId || statement.name == kPlaceholder;
}

bool read_whole(DbcTokens& tokens, DbcMessageStatement& statement) {
    const DbcPlace place = tokens.token().place;
    if (!read_heading(tokens, statement)) {
        return false;
    }
    const bool placeholder = is_placeholder(statement);
    if (!placeholder) {
        statement.fault = wrong_id(statement.message, place);
    }
    while (tokens.token().is_word("SG_")) {
        tokens.advance();
        if (!read_signal(tokens, statement, placeholder)) {
            return false;
        }
    }
    return true;
}

/// Skips what is left of a message, so that its signals do not become those of another one.
void skip_message(DbcTokens& tokens) {
    while (tokens.can_go_on() && (!tokens.at_section() || tokens.token().is_word("SG_"))) {
        tokens.advance();
    }
}

}  // namespace

bool read_dbc_message(DbcTokens& tokens, DbcStatements& statements) {
    DbcMessageStatement statement;
    if (!read_whole(tokens, statement)) {
        if (!tokens.can_go_on()) {
            return false;
        }
        statement.fault = tokens.forgive();
        skip_message(tokens);
    }
    if (is_placeholder(statement)) {
        statements.placeholders.push_back(statement.file_id.value_or(kPlaceholderId));
    } else {
        statements.messages.push_back(std::move(statement));
    }
    return true;
}

}  // namespace tribus
