#include "config/read/values.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>

#include "config/language/nearest.h"
#include "config/schema/notation.h"
#include "config/schema/value_catalog.h"
#include "core/quotes.h"
#include "transports/codecs/dbc/map.h"
#include "transports/codecs/dbc/signal_map.h"
#include "transports/codecs/dbc/value_reader.h"
#include "transports/codecs/dronecan/value_reader.h"
#include "transports/links/can/can_medium.h"
#include "transports/registry/registry.h"

namespace tribus {
namespace {

constexpr Duration kDefaultTimeout = std::chrono::seconds(1);
constexpr int kCyclesToStale = 3;

/// A kind of [values.NAME]: the key that selects it, and its required and optional keys.
struct ValuesKind {
    std::string_view key;
    std::span<const std::string_view> required;
    std::span<const std::string_view> optional;
};
constexpr std::array<std::string_view, 1> kConstantNeeds{"constant"};
constexpr std::array<std::string_view, 1> kConstantTakes{"unit"};
constexpr std::array<std::string_view, 3> kDbcNeeds{"interface", "dbc", "message"};
constexpr std::array<std::string_view, 2> kDbcTakes{"signals", "timeout"};
constexpr std::array<std::string_view, 2> kDroneCanNeeds{"interface", "dronecan"};
constexpr std::array<std::string_view, 5> kDroneCanTakes{"node", "instance", "fd", "signals",
                                                         "timeout"};
constexpr std::array<std::string_view, 1> kBytesNeed{"protocol"};
constexpr std::array<std::string_view, 8> kBytesTake{"device", "address", "public",  "sender",
                                                     "baud",   "key",     "signals", "timeout"};
constexpr ValuesKind kConstant{"constant", kConstantNeeds, kConstantTakes};
constexpr ValuesKind kDbc{"dbc", kDbcNeeds, kDbcTakes};
constexpr ValuesKind kDroneCan{"dronecan", kDroneCanNeeds, kDroneCanTakes};
constexpr ValuesKind kBytes{"protocol", kBytesNeed, kBytesTake};

const ValuesKind& kind_of(const TableContent& content) {
    if (content.given(kConstant.key)) {
        return kConstant;
    }
    if (content.given(kBytes.key)) {
        return kBytes;
    }
    return content.given(kDroneCan.key) ? kDroneCan : kDbc;
}

/// The message that the table names, from the DBC file.
std::optional<DbcMessage> find_message(const TableContent& content, const SettingFile& dbc,
                                       const std::string& name, Reading reading) {
    Mistakes& mistakes = reading.mistakes;
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
    for (const SettingMistake& warning : warnings_about_dbc(*file, dbc.path)) {
        reading.warnings.add(content.where("dbc"), warning.text);
    }
    return *file->find(name);
}

std::optional<DbcValueSource> read_dbc(const TableContent& content, Reading reading) {
    DbcValueSource source;
    content.read_into(source);
    if (source.dbc.path.empty() || source.message.empty()) {
        return std::nullopt;
    }
    const auto message = find_message(content, source.dbc, source.message, reading);
    if (!message) {
        return std::nullopt;
    }
    source.described = {.messages = {*message}};
    return source;
}

std::optional<DroneCanValueSource> read_dronecan_source(const TableContent& content,
                                                        Mistakes& mistakes) {
    DroneCanValueSource source;
    content.read_into(source);
    if (source.message.empty()) {
        return std::nullopt;
    }
    if (source.from.instance && dronecan::instance_field(source.message).empty()) {
        mistakes.add(content.find("instance")->where,
                     fmt::format("a node has one {} only; leave \"instance\" out", source.message));
    }
    return source;
}

/// The medium whose place the table names. Exactly one place is needed.
const Medium* byte_medium(const TableContent& content, const Protocol& protocol,
                          Mistakes& mistakes) {
    const Medium* medium = nullptr;
    for (const Medium* candidate : media_for(protocol)) {
        const std::string_view key = candidate->place.key;
        if (!content.given(key)) {
            continue;
        }
        if (medium != nullptr) {
            mistakes.add(content.find(key)->where,
                         fmt::format("{} beside {}; leave one of them out", in_quotes(key),
                                     in_quotes(medium->place.key)));
            return nullptr;
        }
        medium = candidate;
    }
    if (medium == nullptr) {
        mistakes.add(content.where("protocol"),
                     "the place is missing; required with \"protocol\": \"device\", a serial "
                     "port, or \"address\" for UDP");
    }
    return medium;
}

/// Absent after a mistake.
std::optional<PortConfig> read_byte_port(const TableContent& content, const Protocol& protocol,
                                         Mistakes& mistakes) {
    PortConfig port;
    port.medium = byte_medium(content, protocol, mistakes);
    if (port.medium == nullptr) {
        return std::nullopt;
    }
    const std::string_view place = port.medium->place.key;
    content.read_into(port);
    port.where = content.where(place);
    port.line = protocol.line;
    port.line.baud =
        static_cast<std::uint32_t>(content.values().get_or("baud", std::int64_t{port.line.baud}));
    for (const std::string_view key : {"public", "sender", "baud"}) {
        const bool fits = (key == "baud") == port.medium->has_line;
        if (content.given(key) && !fits) {
            mistakes.add(content.find(key)->where,
                         fmt::format("{} has no effect together with {}; leave it out",
                                     in_quotes(key), in_quotes(place)));
        }
    }
    for (const Setting& setting : port.medium->settings) {
        if (const SettingValue* value = content.values().find(setting.key)) {
            port.settings.set(setting.key, *value);
        } else if (!setting.fallback.empty()) {
            port.settings.set(setting.key, default_of(setting));
        }
    }
    if (!content.sound(place) || !content.sound("baud") || !content.sound("public") ||
        !content.sound("sender")) {
        return std::nullopt;
    }
    const auto found = port.medium->check == nullptr
                           ? std::vector<SettingMistake>{}
                           : port.medium->check(port.device, port.settings, SettingScope::input,
                                                KeyUse::impossible);
    for (const SettingMistake& mistake : found) {
        mistakes.add(port.where, mistake.text);
    }
    return found.empty() ? std::optional(std::move(port)) : std::nullopt;
}

struct SourceName {
    std::string_view operator()(const ByteValueSource& source) const { return source.protocol; }
    template <class CanSource>
    std::string_view operator()(const CanSource& source) const {
        return source.message;
    }
};

std::string_view message_name(const ValueMessageConfig& config) {
    return std::visit(SourceName{}, config.layout);
}

/// Why a signal that the DBC file has cannot be read; else empty.
std::string why_unusable(const ValueMessageConfig& config, std::string_view signal) {
    const auto* source = std::get_if<DbcValueSource>(&config.layout);
    if (source == nullptr || source->described.messages.empty()) {
        return {};
    }
    const auto& unusable = source->described.messages.front().unusable;
    const auto found = std::ranges::find(unusable, signal, &DbcUnusable::name);
    return found == unusable.end() ? std::string() : unusable_in_dbc("signal", *found);
}

std::vector<std::pair<std::string, std::string>> read_own_names(const TableContent& content,
                                                                const ValueMessageConfig& config,
                                                                Mistakes& mistakes) {
    std::vector<std::pair<std::string, std::string>> names;
    const Entry* signals = content.find("signals");
    if (signals == nullptr) {
        return names;
    }
    const auto reader = make_reader(config);
    std::vector<std::string_view> known;
    for (const ValueReader::Value& value : common_part(*reader).values()) {
        known.emplace_back(value.name);
    }
    const std::string_view message = message_name(config);
    for (const NamedText& named : read_texts(*signals, "the name of a signal", mistakes)) {
        if (const auto why = why_unusable(config, named.text); !why.empty()) {
            mistakes.add(named.entry->value.where, why);
        } else if (std::ranges::find(known, named.text) == known.end()) {
            mistakes.add(named.entry->value.where,
                         fmt::format("message {} has no signal {}; {}", message,
                                     in_quotes(named.text), suggestion(named.text, known)));
        } else if (std::ranges::find(known, named.entry->key) != known.end() &&
                   named.entry->key != named.text) {
            mistakes.add(named.entry->where,
                         fmt::format("{} is itself a signal of {}; give {} another name",
                                     in_quotes(named.entry->key), message, in_quotes(named.text)));
        } else {
            names.emplace_back(named.entry->key, named.text);
        }
    }
    return names;
}

Duration default_timeout(const ValueMessageConfig& config) {
    const auto* dbc = std::get_if<DbcValueSource>(&config.layout);
    if (dbc == nullptr) {
        return dronecan::SourceWatch::kGone;
    }
    const Duration cycle = dbc->described.messages.front().cycle_time.value_or(Duration::zero());
    return cycle > Duration::zero() ? kCyclesToStale * cycle : kDefaultTimeout;
}

/// Own names and lifetime of the values.
void finish(ValueMessageConfig& config, const TableContent& content, Mistakes& mistakes) {
    config.names = read_own_names(content, config, mistakes);
    config.timeout = default_timeout(config);
    content.read_into(config);
}

std::optional<ValueMessageConfig> read_bytes(const TableContent& content, Mistakes& mistakes) {
    ByteValueSource source;
    content.read_into(source);
    if (source.protocol.empty()) {
        return std::nullopt;
    }
    const Protocol& protocol = *find_protocol(source.protocol);
    if (content.given("key") && std::ranges::count(protocol.settings, "key", &Setting::key) == 0) {
        mistakes.add(content.find("key")->where,
                     fmt::format("\"key\" has no effect with protocol {}, which has no signatures; "
                                 "leave it out",
                                 in_quotes(protocol.name)));
    }
    auto port = read_byte_port(content, protocol, mistakes);
    if (!port) {
        return std::nullopt;
    }
    ValueMessageConfig config{
        .port = std::move(*port), .layout = std::move(source), .timeout = {}, .names = {}};
    finish(config, content, mistakes);
    return config;
}

std::optional<ValueMessageConfig> read_message(const TableContent& content, Reading reading) {
    Mistakes& mistakes = reading.mistakes;
    if (&kind_of(content) == &kBytes) {
        return read_bytes(content, mistakes);
    }
    ValueMessageConfig config;
    const auto take = [&config](auto source) {
        const bool known = source.has_value();
        if (known) {
            config.layout = *std::move(source);
        }
        return known;
    };
    const bool sound = &kind_of(content) == &kDroneCan
                           ? take(read_dronecan_source(content, mistakes))
                           : take(read_dbc(content, reading));
    content.read_into(config.port);
    if (!sound || config.port.device.empty()) {
        return std::nullopt;
    }
    config.port.medium = &kCanMedium;
    config.port.where = content.where("interface");
    finish(config, content, mistakes);
    return config;
}

bool has(std::span<const std::string_view> keys, std::string_view key) {
    return std::ranges::find(keys, key) != keys.end();
}

void check_kind(const TableContent& content, const std::string& title, Mistakes& mistakes) {
    const ValuesKind& kind = kind_of(content);
    for (const std::string_view key : names_of(values_keys())) {
        if (content.given(key) && content.given(kind.key) && !has(kind.required, key) &&
            !has(kind.optional, key)) {
            mistakes.add(content.find(key)->where,
                         fmt::format("{} has no effect together with {}; leave one of them out",
                                     in_quotes(key), in_quotes(kind.key)));
        }
    }
    for (const std::string_view key : kind.required) {
        if (!content.given(key)) {
            mistakes.add(content.where(key),
                         fmt::format("{} lacks {}; required: \"constant\", or \"interface\" with "
                                     "either \"dbc\" and \"message\" or \"dronecan\", or "
                                     "\"protocol\" with \"device\"",
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
    if (!reading.lost.affects(entry.value.where)) {
        check_kind(content, title, reading.mistakes);
    }
    if (content.given("constant")) {
        content.read_into(draft.config.source.emplace<ConstantConfig>());
        return draft;
    }
    auto message = read_message(content, reading);
    draft.sound = message.has_value();
    draft.config.source = std::move(message).value_or(ValueMessageConfig{});
    return draft;
}

}  // namespace tribus
