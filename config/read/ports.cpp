#include "config/read/ports.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include "config/language/nearest.h"
#include "config/language/numbers.h"
#include "config/language/protocol_words.h"
#include "config/read/line.h"
#include "config/read/rules.h"
#include "config/read/supervision.h"
#include "config/schema/notation.h"
#include "core/quotes.h"
#include "transports/registry/registry.h"

namespace tribus {
namespace {

/// The protocol that a table names, or the nearest name. Null if it does not go that way, so that
/// its keys are not judged.
const Protocol* meant_protocol(const Table& table, std::span<const Key> keys, SettingScope way) {
    for (const Entry& entry : table.entries) {
        const Key* key = meant_key(entry.key, keys);
        const auto* name = entry.value.as<std::string>();
        if (key == nullptr || key->kind != KeyKind::protocol || name == nullptr) {
            continue;
        }
        if (const Protocol* protocol = find_protocol(*name)) {
            return protocol->goes(way) ? protocol : nullptr;
        }
        // A maker's name may mean another protocol, so its keys are not judged.
        const auto names = protocol_names(way);
        const std::string_view near = nearest(*name, names).value_or("");
        const auto meant = protocols_meant(*name, names);
        return meant.empty() || meant.front() == near ? find_protocol(near) : nullptr;
    }
    return nullptr;
}

/// The medium whose place the table names, or the usual one of the protocol.
const Medium* meant_medium(const Table& table, const Protocol& protocol) {
    const std::vector<const Medium*> media = media_for(protocol);
    const auto named = std::ranges::find_if(
        media, [&table](const Medium* medium) { return table.find(medium->place.key) != nullptr; });
    return named == media.end() ? media.front() : *named;
}

/// The keys of an input or output, which depend on its protocol and its medium.
struct PortKeys {
    const Protocol* protocol = nullptr;
    /// Null if the protocol is unknown.
    const Medium* medium = nullptr;
    std::vector<Key> keys;
    /// If the protocol is unknown: the keys of all protocols, which are not reported.
    std::vector<std::string_view> tolerated;
};

/// Order of the keys in messages: protocol, place, common keys, keys of the protocol.
PortKeys port_keys(const Table& table, std::span<const Key> common, SettingScope scope) {
    PortKeys port{
        meant_protocol(table, common, scope), nullptr, {common.begin(), common.end()}, {}};
    if (port.protocol != nullptr) {
        port.medium = meant_medium(table, *port.protocol);
        const auto own = protocol_keys(*port.protocol, *port.medium, scope);
        port.keys.insert(port.keys.begin() + 1, own.front());
        port.keys.insert(port.keys.end(), own.begin() + 1, own.end());
        return port;
    }
    for (const Protocol* protocol : protocols()) {
        for (const SettingScope way : {SettingScope::input, SettingScope::output}) {
            std::ranges::move(names_of(protocol_keys(*protocol, way)),
                              std::back_inserter(port.tolerated));
        }
    }
    return port;
}

std::string_view name_of(const Protocol* protocol) {
    return protocol == nullptr ? std::string_view{} : protocol->name;
}

SettingValues values_of(std::span<const Setting> settings, const TableContent& content) {
    SettingValues values;
    for (const Setting& setting : settings) {
        if (const SettingValue* value = content.values().find(setting.key)) {
            values.set(setting.key, *value);
        }
    }
    return values;
}

/// The same settings with the defaults that depend on them, in the order of the rows.
SettingValues with_dependent_defaults(const Protocol& protocol, const SettingValues& settings,
                                      SettingScope way) {
    const SettingValues defaults = protocol.dependent_defaults(settings, way);
    SettingValues all;
    for (const Setting& setting : protocol.settings) {
        const SettingValue* given = settings.find(setting.key);
        if (const auto* value = given != nullptr ? given : defaults.find(setting.key)) {
            all.set(setting.key, *value);
        }
    }
    return all;
}

/// The value at the end of a path of keys, or at the last part of the path that exists. Null if no
/// part exists.
const Value* value_at(const std::vector<std::string>& path, const TableContent& content) {
    const Value* value = nullptr;
    for (const std::string& part : path) {
        const auto* table = value == nullptr ? nullptr : value->as<Table>();
        const Entry* entry = value == nullptr   ? content.find(part)
                             : table == nullptr ? nullptr
                                                : table->find(part);
        if (entry == nullptr) {
            return value;
        }
        value = &entry->value;
    }
    return value;
}

/// Place of that value, or else of the table or its protocol.
Location where_of(const std::vector<std::string>& path, const TableContent& content) {
    const Value* value = value_at(path, content);
    return value != nullptr ? value->where
                            : content.where(path.empty() ? "protocol" : path.front());
}

void add_found(const std::vector<SettingMistake>& found, const TableContent& content,
               Mistakes& mistakes) {
    for (const SettingMistake& mistake : found) {
        // The types of values inside of a tree were not checked before.
        const bool in_tree = mistake.path.size() > 1;
        const Value* value = in_tree ? value_at(mistake.path, content) : nullptr;
        mistakes.add(
            where_of(mistake.path, content),
            mistake.text + std::string(value == nullptr ? "" : without_quotes_hint(*value)));
    }
}

/// Runs the protocol's own check if each of its keys is valid. Returns whether all is valid.
bool check_by_protocol(const PortKeys& port, const SettingValues& settings, SettingScope scope,
                       const TableContent& content, Reading reading) {
    if (port.protocol == nullptr || !port.protocol->goes(scope)) {
        return false;
    }
    for (const Setting& setting : port.protocol->settings) {
        if (!content.sound(setting.key) || (setting.required && !content.given(setting.key))) {
            return false;
        }
    }
    const auto found = port.protocol->check == nullptr ? std::vector<SettingMistake>{}
                                                       : port.protocol->check(settings, scope);
    add_found(found, content, reading.mistakes);
    if (found.empty() && port.protocol->warnings != nullptr) {
        add_found(port.protocol->warnings(settings, scope), content, reading.warnings);
    }
    return found.empty();
}

/// No serial driver of Linux has a setting for inversion, so `inverted = true` is always a mistake.
void check_inverted(const PortKeys& port, const TableContent& content, Mistakes& mistakes) {
    const bool inverts = port.medium != nullptr && port.medium->inverts;
    if (content.values().get_or("inverted", false)) {
        mistakes.add(
            content.where("inverted"),
            inverts
                ? "\"inverted\" is true, but an SPI port inverts the signal by itself; leave it "
                  "out"
                : "\"inverted\" is true, but Linux has no setting that inverts a serial port; let "
                  "an SPI port do it (spi = \"/dev/spidev0.0\" in place of device), or invert the "
                  "wire: with a transistor or a 74HC04, with the "
                  "inversion bit in the EEPROM of an FTDI adapter, or with the device-tree flag "
                  "that some UARTs have; then leave inverted = false");
    }
}

PortConfig port_config(const PortKeys& port, const TableContent& content) {
    PortConfig config;
    if (port.protocol != nullptr) {
        config.medium = port.medium;
        content.read_into(config);
        config.settings = values_of(port.medium->settings, content);
        config.where = content.where(port.medium->place.key);
        config.line = port.protocol->line;
        const auto baud = content.values().get_or("baud", std::int64_t{config.line.baud});
        config.line.baud = static_cast<std::uint32_t>(baud);
    }
    return config;
}

/// Runs the medium's own check if the place and each key of the medium are valid.
bool check_by_medium(const PortConfig& port, KeyUse key, SettingScope scope,
                     const TableContent& content, Mistakes& mistakes) {
    const bool sound = std::ranges::all_of(
        port.medium->settings, [&](const Setting& setting) { return content.sound(setting.key); });
    if (!sound || port.medium->check == nullptr) {
        return sound;
    }
    const auto found = port.medium->check(port.device, port.settings, scope, key);
    add_found(found, content, mistakes);
    return found.empty();
}

bool port_sound(const PortConfig& port, KeyUse key, SettingScope scope, const TableContent& content,
                Mistakes& mistakes) {
    if (port.medium == nullptr) {
        return false;
    }
    const std::string_view place = port.medium->place.key;
    return content.given(place) && content.sound(place) && content.sound("baud") &&
           content.sound("protocol") && check_by_medium(port, key, scope, content, mistakes);
}

/// `most`: upper limit of the protocol with its settings, if they are valid.
void check_period(const OutputConfig& output, std::optional<Duration> most,
                  const TableContent& content, Mistakes& mistakes) {
    const Duration period = output.schedule.period;
    const Duration wire = frame_time(output);
    const Duration protocol = output.protocol->least_period;
    const std::string longest = in_quotes(format_duration(most.value_or(kMostOutputPeriod)));
    const Location where = content.where("period");
    const std::string found =
        in_quotes(format_duration(period)) + (content.given("period") ? "" : " by default");
    const std::string name = in_quotes(output.protocol->name);
    if (period < wire) {
        const Duration least = output.force ? wire : std::max(wire, protocol);
        mistakes.add(where, fmt::format("\"period\" is {}, shorter than a frame of {} takes on the "
                                        "wire at {} baud; allowed: {} to {}",
                                        found, name, output.port.line.baud,
                                        in_quotes(format_duration(least)), longest));
    } else if (period < protocol && !output.force) {
        mistakes.add(where,
                     fmt::format("\"period\" is {}, shorter than readers of {} can follow; "
                                 "allowed: {} to {}, or add force = true",
                                 found, name, in_quotes(format_duration(protocol)), longest));
    } else if (most && period > *most) {
        mistakes.add(where,
                     fmt::format("\"period\" is {}, longer than readers of {} wait for the next "
                                 "command; allowed: {} to {}",
                                 found, name, in_quotes(format_duration(protocol)), longest));
    }
}

/// The default period: that of the settings if they define one, else that of the protocol; not
/// longer than the key allows.
Duration own_period(const Protocol& protocol, const SettingValues& settings, bool sound) {
    const auto own =
        sound && protocol.own_period != nullptr ? protocol.own_period(settings) : std::nullopt;
    return std::min(own.value_or(protocol.default_period), kMostOutputPeriod);
}

/// The receiver of the frames sets the points of the grid.
void check_timed_by_receiver(const OutputConfig& output, const TableContent& content,
                             Mistakes& mistakes) {
    constexpr std::string_view kWhy = "but the receiver of the frames says when they should come";
    if (output.schedule.kind != ScheduleKind::grid && content.sound("schedule")) {
        mistakes.add(content.where("schedule"),
                     fmt::format("\"schedule\" is \"follow\", {}; allowed: \"grid\", or leave "
                                 "schedule out",
                                 kWhy));
    }
    if (output.schedule.phase == Phase::locked && content.sound("phase")) {
        mistakes.add(content.where("phase"),
                     fmt::format("\"phase\" is \"locked\", {}; leave phase out", kWhy));
    }
}

void check_phase(const OutputConfig& output, const TableContent& content, Mistakes& mistakes) {
    if (output.schedule.phase == Phase::locked && output.schedule.kind != ScheduleKind::grid &&
        content.sound("schedule")) {
        mistakes.add(content.where("phase"),
                     "\"phase\" is \"locked\", but \"schedule\" is \"follow\", which has no grid "
                     "to lock; allowed: schedule = \"grid\", or leave phase out");
    }
}

/// A key that has a mistake counts as given.
template <class PortDraft>
KeyUse meant_key_use(const PortKeys& port, const PortDraft& draft) {
    if (port.protocol == nullptr || port.protocol->link_with_key == nullptr) {
        return KeyUse::impossible;
    }
    return draft.settings_sound ? key_use(draft.config) : KeyUse::given;
}

/// Reads the part that inputs and outputs share.
template <class PortDraft>
void read_port(const Entry& entry, const PortKeys& port, SettingScope scope,
               const TableContent& content, PortDraft& draft, Reading reading) {
    check_inverted(port, content, reading.mistakes);
    draft.where = entry.where;
    draft.config.name = entry.key;
    draft.config.protocol = port.protocol;
    if (port.protocol != nullptr) {
        draft.config.settings = values_of(port.protocol->settings, content);
    }
    draft.settings_sound = check_by_protocol(port, draft.config.settings, scope, content, reading);
    if (draft.settings_sound && port.protocol != nullptr &&
        port.protocol->dependent_defaults != nullptr) {
        draft.config.settings =
            with_dependent_defaults(*port.protocol, draft.config.settings, scope);
    }
    draft.config.port = port_config(port, content);
    draft.port_sound =
        port_sound(draft.config.port, meant_key_use(port, draft), scope, content, reading.mistakes);
}

void read_values_used(const Protocol& protocol, const TableContent& content, OutputDraft& draft) {
    const SettingValues& settings = draft.config.settings;
    draft.needs_pipeline = protocol.needs_pipeline == nullptr || protocol.needs_pipeline(settings);
    if (protocol.value_names == nullptr) {
        return;
    }
    for (const NamedUse& use : protocol.value_names(settings)) {
        draft.used_values.push_back({use, where_of(use.path, content)});
    }
}

}  // namespace

InputDraft read_input(const Entry& entry, const Table& table, Reading reading) {
    const PortKeys port = port_keys(table, input_keys(), SettingScope::input);
    const std::string title = fmt::format("[input.{}]", entry.key);
    const TableContent content =
        read_table({table, entry.value.where, title, "input", name_of(port.protocol)}, port.keys,
                   reading, port.tolerated);
    InputDraft draft;
    read_port(entry, port, SettingScope::input, content, draft, reading);
    if (content.given("timeout")) {
        draft.timeout = content.where("timeout");
    }
    // Without the settings its default is unknown.
    draft.timeout_sound =
        content.given("timeout") ? content.sound("timeout") : draft.settings_sound;
    draft.config.supervision = read_supervision(content, port.protocol, draft.config.settings,
                                                draft.settings_sound, reading);
    if (const Entry* map = content.find("map")) {
        PlacedRules placed =
            read_channels(map->value, fmt::format("[input.{}.map]", entry.key), nullptr, reading);
        draft.config.channels = std::move(placed.rules);
        draft.config.channels_where = std::move(placed.where);
    }
    return draft;
}

OutputDraft read_output(const Entry& entry, const Table& table, Reading reading) {
    const PortKeys port = port_keys(table, output_keys(), SettingScope::output);
    const std::string title = fmt::format("[output.{}]", entry.key);
    const TableContent content =
        read_table({table, entry.value.where, title, "output", name_of(port.protocol)}, port.keys,
                   reading, port.tolerated);
    OutputDraft draft;
    read_port(entry, port, SettingScope::output, content, draft, reading);
    draft.period = content.where("period");
    draft.period_sound = content.sound("period");
    if (draft.settings_sound) {
        read_values_used(*port.protocol, content, draft);
    } else if (port.protocol != nullptr && port.protocol->needs_pipeline != nullptr) {
        // It may be an output for values only, which the other mistake hides.
        draft.needs_pipeline = false;
    }
    if (port.protocol != nullptr) {
        draft.config.schedule.period =
            own_period(*port.protocol, draft.config.settings, draft.settings_sound);
    }
    content.read_into(draft.config);
    if (port.protocol != nullptr) {
        draft.config.schedule.least_spacing =
            port.protocol->least_spacing.value_or(port.protocol->least_period);
    }
    const bool judged = port.protocol != nullptr && content.sound("protocol") &&
                        content.sound("period") && content.sound("baud") && content.sound("force");
    if (judged) {
        const bool limited = draft.settings_sound && port.protocol->most_period != nullptr;
        check_period(draft.config,
                     limited ? port.protocol->most_period(draft.config.settings) : std::nullopt,
                     content, reading.mistakes);
    }
    if (draft.settings_sound && is_timed_by_receiver(draft.config)) {
        draft.config.schedule.kind =
            content.given("schedule") ? draft.config.schedule.kind : ScheduleKind::grid;
        check_timed_by_receiver(draft.config, content, reading.mistakes);
    } else {
        check_phase(draft.config, content, reading.mistakes);
    }
    if (draft.port_sound && draft.period_sound) {
        const Location where = content.where(draft.config.port.medium->enable_key);
        draft.enable_line = read_enable_line(draft.config, where, reading.mistakes);
    }
    return draft;
}

}  // namespace tribus
