#include "config/read_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <optional>
#include <string>
#include <utility>

#include "config/nearest.h"
#include "config/values.h"
#include "core/quotes.h"
#include "transports/codecs/dbc/value_reader.h"

namespace tribus {
namespace {

constexpr Duration kDefaultTimeout = std::chrono::seconds(1);
constexpr int kCyclesToStale = 3;
constexpr std::array<std::string_view, 5> kMessageKeys{"interface", "dbc", "message", "signals",
                                                       "timeout"};

/// The message that the table names, as the file describes it.
std::optional<DbcMessage> find_message(const TableContent& content, const SettingFile& dbc,
                                       const std::string& name, Mistakes& mistakes) {
    const auto file = parse_dbc(dbc.content);
    if (!file) {
        mistakes.add(content.where("dbc"), fmt::format("{}:{}:{}: {}", dbc.path, file.error().line,
                                                       file.error().column, file.error().text));
        return std::nullopt;
    }
    const auto reader = make_dbc_value_reader(*file, name);
    if (!reader) {
        mistakes.add(content.where("message"), fmt::format("{}: {}", dbc.path, reader.error()));
        return std::nullopt;
    }
    return *file->find(name);
}

std::vector<std::pair<std::string, std::string>> read_signal_names(const TableContent& content,
                                                                   const DbcMessage& message,
                                                                   Mistakes& mistakes) {
    std::vector<std::pair<std::string, std::string>> names;
    const Entry* signals = content.find("signals");
    if (signals == nullptr) {
        return names;
    }
    std::vector<std::string_view> known;
    for (const DbcSignal& signal : message.signals) {
        known.emplace_back(signal.name);
    }
    for (const NamedText& named : read_texts(*signals, "the name of a signal", mistakes)) {
        if (message.find(named.text) == nullptr) {
            mistakes.add(named.entry->value.where,
                         fmt::format("message {} has no signal {}; {}", message.name,
                                     in_quotes(named.text), suggestion(named.text, known)));
        } else if (std::ranges::find(known, named.entry->key) != known.end() &&
                   named.entry->key != named.text) {
            mistakes.add(
                named.entry->where,
                fmt::format("{} is itself a signal of {}; give {} another name",
                            in_quotes(named.entry->key), message.name, in_quotes(named.text)));
        } else {
            names.emplace_back(named.entry->key, named.text);
        }
    }
    return names;
}

std::optional<ValueMessageConfig> read_message(const TableContent& content, Mistakes& mistakes) {
    const SettingValues& values = content.values();
    const auto* dbc = values.find_as<SettingFile>("dbc");
    const auto* name = values.find_as<std::string>("message");
    const auto* interface = values.find_as<std::string>("interface");
    if (dbc == nullptr || name == nullptr || interface == nullptr) {
        return std::nullopt;
    }
    const auto message = find_message(content, *dbc, *name, mistakes);
    if (!message) {
        return std::nullopt;
    }
    ValueMessageConfig config;
    config.port.link = LinkKind::can;
    config.port.device = *interface;
    config.port.where = content.where("interface");
    config.dbc = *dbc;
    config.message = *name;
    config.names = read_signal_names(content, *message, mistakes);
    const Duration cycle = message->cycle_time.value_or(Duration::zero());
    config.timeout = values.get_or<Duration>(
        "timeout", cycle > Duration::zero() ? kCyclesToStale * cycle : kDefaultTimeout);
    config.described.messages = {*message};
    return config;
}

void check_kind(const TableContent& content, const std::string& title, Mistakes& mistakes) {
    for (const std::string_view key : kMessageKeys) {
        if (content.given("constant") && content.given(key)) {
            mistakes.add(content.find(key)->where,
                         fmt::format("{} has no effect beside \"constant\"; leave one of them out",
                                     in_quotes(key)));
        }
    }
    if (!content.given("constant") && content.given("unit")) {
        mistakes.add(content.find("unit")->where,
                     "\"unit\" is that of a constant; those of signals are in the DBC file; leave "
                     "it out");
    }
    for (const std::string_view key : {"interface", "dbc", "message"}) {
        if (!content.given("constant") && !content.given(key)) {
            mistakes.add(content.where(key),
                         fmt::format("{} lacks {}; required: \"interface\", \"dbc\" and "
                                     "\"message\", or else \"constant\"",
                                     title, in_quotes(key)));
        }
    }
}

}  // namespace

std::vector<NamedText> read_texts(const Entry& entry, std::string_view what, Mistakes& mistakes) {
    const auto* table = entry.value.as<Table>();
    if (table == nullptr) {
        mistakes.add(entry.value.where,
                     fmt::format("{} is {}; allowed: a table, {{ NAME = {} in quotes }}",
                                 in_quotes(entry.key), describe(entry.value), what));
        return {};
    }
    std::vector<NamedText> texts;
    for (const Entry& item : table->entries) {
        const auto* text = item.value.as<std::string>();
        if (text == nullptr || text->empty()) {
            mistakes.add(item.value.where,
                         fmt::format("{} is {}; allowed: {} in quotes", in_quotes(item.key),
                                     describe(item.value), what));
        } else {
            texts.push_back({&item, *text});
        }
    }
    return texts;
}

ValuesDraft read_values(const Entry& entry, const Table& table, Reading reading) {
    const std::string title = fmt::format("[values.{}]", entry.key);
    const TableContent content =
        read_table({table, entry.value.where, title}, values_keys(), reading);
    ValuesDraft draft;
    draft.config.name = entry.key;
    draft.where = entry.where;
    if (!reading.lost.hurts(entry.value.where)) {
        check_kind(content, title, reading.mistakes);
    }
    if (content.given("constant")) {
        draft.config.source = ConstantConfig{content.values().get_or("constant", 0.0),
                                             content.values().get_or<std::string>("unit", {})};
        return draft;
    }
    auto message = read_message(content, reading.mistakes);
    draft.sound = message.has_value();
    draft.config.source = std::move(message).value_or(ValueMessageConfig{});
    return draft;
}

}  // namespace tribus
