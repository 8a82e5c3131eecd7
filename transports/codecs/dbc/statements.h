#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "transports/codecs/dbc/file.h"
#include "transports/codecs/dbc/lexer.h"

/// Statements of a DBC text, each checked by itself. They are not combined yet, because a statement
/// may come before the one that it refers to. Names point into the text.
namespace tribus {

/// Bit 31 of an id in the file marks 29-bit ids (docs/protocols/can.md, "DBC files").
inline constexpr std::uint32_t kDbcExtendedFlag = 0x80000000U;

/// The object of a statement: a message by its id as in the file, or one of its signals.
struct DbcReference {
    std::uint32_t message = 0;
    std::string_view signal;
};

struct DbcMessageStatement {
    /// The signals still lack selector, kind and value texts. `selected_by` has the value of mN.
    DbcMessage message;
    /// Nothing if the id cannot be read.
    std::optional<std::uint32_t> file_id;
    std::string_view name;
    DbcPlace name_place;
    DbcPlace length_place;
    std::vector<std::string_view> signal_names;
    std::vector<DbcPlace> signal_places;
    /// What makes each signal unusable, if anything does.
    std::vector<std::optional<DbcMistake>> signal_faults;
    /// What makes the whole message unusable. It may lack what stands behind the mistake, even its
    /// id and its name.
    std::optional<DbcMistake> fault;
};

/// A mistake in a statement about a message, which makes that unusable.
struct DbcFaultStatement {
    std::uint32_t message = 0;
    DbcMistake mistake;
};

struct DbcKindStatement {
    DbcReference of;
    DbcPlace place;
    DbcValueKind kind = DbcValueKind::integer;
};

struct DbcSelectorStatement {
    DbcReference of;
    std::string_view selector;
    DbcPlace selector_place;
    std::vector<DbcSelectorRange> ranges;
};

struct DbcValueTextStatement {
    DbcReference of;
    std::vector<DbcValueText> texts;
};

/// The attributes that are read. All others are skipped.
enum class DbcAttribute : std::uint8_t {
    cycle_time,
    frame_format,
    bit_rate_switch,
    e2e_data_id,
    message_long_name,
    signal_long_name,
};
inline constexpr std::size_t kDbcAttributes = 6;

struct DbcAttributeValue {
    /// A number with its sign, or the text between the quotes.
    std::string text;
    bool quoted = false;
    DbcPlace place;
};

struct DbcAttributeStatement {
    DbcAttribute attribute = DbcAttribute::cycle_time;
    DbcReference of;
    DbcAttributeValue value;
};

struct DbcAttributeDefinition {
    /// Values of an ENUM; empty for every other type.
    std::vector<std::string> choices;
    std::optional<DbcAttributeValue> by_default;
};

struct DbcStatements {
    std::vector<DbcMessageStatement> messages;
    std::vector<DbcKindStatement> kinds;
    std::vector<DbcSelectorStatement> selectors;
    std::vector<DbcValueTextStatement> value_texts;
    std::vector<DbcAttributeStatement> attributes;
    std::vector<DbcFaultStatement> faults;
    /// Mistakes that falsify nothing.
    std::vector<DbcMistake> warnings;
    /// The ids of placeholders for signals that belong to no message.
    std::vector<std::uint32_t> placeholders;
    std::vector<DbcAttributeDefinition> definitions =
        std::vector<DbcAttributeDefinition>(kDbcAttributes);
};

/// Returns all statements that are read, or the first syntax error behind which it cannot go on.
/// Pure and reentrant.
tl::expected<DbcStatements, DbcMistake> read_dbc_statements(std::string_view text);

inline DbcMistake dbc_mistake_at(DbcPlace place, std::string text) {
    return {place.line, place.column, std::move(text)};
}
inline tl::unexpected<DbcMistake> dbc_mistake(DbcPlace place, std::string text) {
    return tl::unexpected(DbcMistake{place.line, place.column, std::move(text)});
}

}  // namespace tribus
