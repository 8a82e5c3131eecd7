#include "transports/codecs/dbc/statements.h"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "transports/codecs/dbc/message_reader.h"
#include "transports/codecs/dbc/tokens.h"

namespace tribus {
namespace {

constexpr std::uint64_t kAnyUnsigned64 = std::numeric_limits<std::uint64_t>::max();
constexpr std::array<std::string_view, kDbcAttributes> kAttributeNames{
    "GenMsgCycleTime",         "VFrameFormat",          "CANFD_BRS", "RcE2eDataId",
    "SystemMessageLongSymbol", "SystemSignalLongSymbol"};

std::optional<DbcAttribute> attribute_named(std::string_view name) {
    const auto* const found = std::find(kAttributeNames.begin(), kAttributeNames.end(), name);
    if (found == kAttributeNames.end()) {
        return std::nullopt;
    }
    return static_cast<DbcAttribute>(found - kAttributeNames.begin());
}

class DbcReader {
  public:
    explicit DbcReader(std::string_view text) : tokens_(text) {}

    tl::expected<DbcStatements, DbcMistake> read() {
        while (!tokens_.mistake() && !tokens_.at_end()) {
            section();
        }
        if (tokens_.mistake()) {
            return tl::unexpected(*tokens_.mistake());
        }
        return std::move(statements_);
    }

  private:
    bool section();
    bool skip_statement();
    bool skip_new_symbols();
    bool skip_nodes();
    /// Some files omit it after their last statement.
    bool end_statement() {
        return tokens_.at_end() || tokens_.take_mark(';', "at the end of the statement");
    }

    bool message() { return read_dbc_message(tokens_, statements_); }
    bool set_aside(std::string_view section);
    bool message_id(std::uint32_t& id);
    bool reference(DbcReference& reference);
    bool value_kind();
    bool selector();
    bool value_texts();
    bool attribute_definition();
    bool attribute_default();
    bool attribute();
    bool attribute_value(DbcAttributeValue& value);

    DbcTokens tokens_;
    DbcStatements statements_;
    /// The message that the statement is about, once that is known.
    std::optional<std::uint32_t> about_;
};

bool DbcReader::section() {
    if (tokens_.skip_mark(';')) {
        return true;
    }
    std::string_view word;
    if (!tokens_.take_word(word, "a section such as BO_ or VAL_")) {
        return false;
    }
    struct Section {
        std::string_view word;
        bool (DbcReader::*read)();
    };
    static constexpr std::array<Section, 9> kSections{{
        {"NS_", &DbcReader::skip_new_symbols},
        {"BU_", &DbcReader::skip_nodes},
        {"BO_", &DbcReader::message},
        {"VAL_", &DbcReader::value_texts},
        {"SIG_VALTYPE_", &DbcReader::value_kind},
        {"SG_MUL_VAL_", &DbcReader::selector},
        {"BA_DEF_", &DbcReader::attribute_definition},
        {"BA_DEF_DEF_", &DbcReader::attribute_default},
        {"BA_", &DbcReader::attribute},
    }};
    const auto* const found =
        std::find_if(kSections.begin(), kSections.end(),
                     [&](const Section& section) { return section.word == word; });
    if (found == kSections.end()) {
        return skip_statement();
    }
    about_.reset();
    return (this->*found->read)() || set_aside(word);
}

/// Goes on behind a mistake if it is known what it falsifies. Texts of values falsify nothing.
bool DbcReader::set_aside(std::string_view section) {
    const bool only_texts = section == "VAL_";
    if (!tokens_.can_go_on() || (!only_texts && !about_)) {
        return false;
    }
    if (only_texts) {
        statements_.warnings.push_back(tokens_.forgive());
    } else {
        statements_.faults.push_back({*about_, tokens_.forgive()});
    }
    return skip_statement();
}

/// Skips up to and including the ';', or up to the next section if there is none.
bool DbcReader::skip_statement() {
    while (!tokens_.at_end() && !tokens_.at_section()) {
        if (tokens_.token().kind == DbcTokenKind::unterminated) {
            return tokens_.fail_expected("a text");
        }
        if (tokens_.skip_mark(';')) {
            return true;
        }
        tokens_.advance();
    }
    return true;
}

/// Skips a list of section words without end mark: each is alone on its line, or follows NS_
/// itself.
bool DbcReader::skip_new_symbols() {
    tokens_.skip_mark(':');
    bool on_first_line = !tokens_.token().first_on_line;
    while (tokens_.token().kind == DbcTokenKind::word) {
        DbcTokens ahead = tokens_;
        ahead.advance();
        on_first_line = on_first_line && !tokens_.token().first_on_line;
        const bool alone = ahead.at_end() || ahead.token().first_on_line;
        const bool listed = on_first_line && ahead.token().kind == DbcTokenKind::word;
        if (!alone && !listed) {
            return true;
        }
        tokens_.advance();
    }
    return true;
}

/// Skips names without end mark, on any number of lines.
bool DbcReader::skip_nodes() {
    tokens_.skip_mark(':');
    while ((tokens_.token().kind == DbcTokenKind::word && !tokens_.at_section()) ||
           tokens_.token().is_mark(',')) {
        tokens_.advance();
    }
    return true;
}

bool DbcReader::message_id(std::uint32_t& id) {
    if (!tokens_.take_unsigned(id, std::numeric_limits<std::uint32_t>::max(),
                               "the id of a message")) {
        return false;
    }
    about_ = id;
    return true;
}

bool DbcReader::reference(DbcReference& reference) {
    return message_id(reference.message) &&
           tokens_.take_word(reference.signal, "the name of a signal");
}

bool DbcReader::value_kind() {
    DbcKindStatement statement;
    statement.place = tokens_.token().place;
    std::uint32_t kind = 0;
    if (!reference(statement.of)) {
        return false;
    }
    tokens_.skip_mark(':');
    if (!tokens_.take_unsigned(kind, 2, "the kind of value (0 integer, 1 float, 2 double)")) {
        return false;
    }
    statement.kind = static_cast<DbcValueKind>(kind);
    statements_.kinds.push_back(statement);
    return end_statement();
}

bool DbcReader::selector() {
    DbcSelectorStatement statement;
    if (!reference(statement.of)) {
        return false;
    }
    statement.selector_place = tokens_.token().place;
    if (!tokens_.take_word(statement.selector, "the name of the selecting signal")) {
        return false;
    }
    do {
        DbcSelectorRange range;
        const DbcPlace place = tokens_.token().place;
        if (!tokens_.take_unsigned(range.first, kAnyUnsigned64, "the first value of a range") ||
            !tokens_.take_mark('-', "between the values of a range") ||
            !tokens_.take_unsigned(range.last, kAnyUnsigned64, "the last value of a range")) {
            return false;
        }
        if (range.first > range.last) {
            return tokens_.fail(place, "the range ends before it begins");
        }
        statement.ranges.push_back(range);
        tokens_.skip_mark(',');
    } while (tokens_.token().kind == DbcTokenKind::number);
    statements_.selectors.push_back(std::move(statement));
    return end_statement();
}

/// Statements about environment variables have no id, and some files name a VAL_TABLE_ instead of
/// texts.
bool DbcReader::value_texts() {
    if (tokens_.token().kind == DbcTokenKind::word) {
        return skip_statement();
    }
    DbcValueTextStatement statement;
    if (!reference(statement.of)) {
        return false;
    }
    if (tokens_.token().kind == DbcTokenKind::word) {
        return skip_statement();
    }
    while (!tokens_.at_end() && !tokens_.skip_mark(';')) {
        DbcValueText text;
        if (!tokens_.take_raw(text.raw, "a raw value or ';'") ||
            !tokens_.take_string(text.text, "the meaning of the value in quotes")) {
            return false;
        }
        statement.texts.push_back(std::move(text));
    }
    statements_.value_texts.push_back(std::move(statement));
    return true;
}

bool DbcReader::attribute_definition() {
    if (tokens_.token().kind == DbcTokenKind::word) {
        tokens_.advance();
    }
    std::string name;
    if (!tokens_.take_string(name, "the name of an attribute in quotes")) {
        return false;
    }
    const std::optional<DbcAttribute> attribute = attribute_named(name);
    if (!attribute || !tokens_.token().is_word("ENUM")) {
        return skip_statement();
    }
    tokens_.advance();
    std::vector<std::string> choices;
    do {
        if (!tokens_.take_string(choices.emplace_back(), "a choice in quotes")) {
            return false;
        }
    } while (tokens_.skip_mark(','));
    statements_.definitions[static_cast<std::size_t>(*attribute)].choices = std::move(choices);
    return end_statement();
}

bool DbcReader::attribute_default() {
    std::string name;
    if (!tokens_.take_string(name, "the name of an attribute in quotes")) {
        return false;
    }
    const std::optional<DbcAttribute> attribute = attribute_named(name);
    if (!attribute) {
        return skip_statement();
    }
    DbcAttributeValue value;
    if (!attribute_value(value)) {
        return false;
    }
    statements_.definitions[static_cast<std::size_t>(*attribute)].by_default = std::move(value);
    return end_statement();
}

bool DbcReader::attribute() {
    std::string name;
    if (!tokens_.take_string(name, "the name of an attribute in quotes")) {
        return false;
    }
    const std::optional<DbcAttribute> attribute = attribute_named(name);
    const bool of_signal = tokens_.token().is_word("SG_");
    if (!attribute || (!of_signal && !tokens_.token().is_word("BO_"))) {
        return skip_statement();
    }
    tokens_.advance();
    DbcAttributeStatement statement;
    statement.attribute = *attribute;
    if (!message_id(statement.of.message) ||
        (of_signal && !tokens_.take_word(statement.of.signal, "the name of a signal")) ||
        !attribute_value(statement.value)) {
        return false;
    }
    statements_.attributes.push_back(std::move(statement));
    return end_statement();
}

bool DbcReader::attribute_value(DbcAttributeValue& value) {
    value.place = tokens_.token().place;
    value.quoted = tokens_.token().kind == DbcTokenKind::string;
    if (value.quoted) {
        return tokens_.take_string(value.text, "a text");
    }
    if (tokens_.take_sign()) {
        value.text.push_back('-');
    }
    if (tokens_.token().kind != DbcTokenKind::number) {
        return tokens_.fail_expected("the value of the attribute, a number or a text in quotes");
    }
    value.text += tokens_.token().text;
    tokens_.advance();
    return true;
}

}  // namespace

tl::expected<DbcStatements, DbcMistake> read_dbc_statements(std::string_view text) {
    return DbcReader(text).read();
}

}  // namespace tribus
