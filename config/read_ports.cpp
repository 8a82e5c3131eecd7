#include "config/read_ports.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "config/nearest.h"
#include "config/read_rules.h"
#include "config/values.h"
#include "transports/registry/registry.h"

namespace tribus {
namespace {

/// The protocol that a table names, or most likely means.
const Protocol* meant_protocol(const Table& table, std::span<const Key> keys) {
    for (const Entry& entry : table.entries) {
        const Key* key = meant_key(entry.key, keys);
        const auto* name = entry.value.as<std::string>();
        if (key == nullptr || key->kind != KeyKind::protocol || name == nullptr) {
            continue;
        }
        if (const Protocol* protocol = find_protocol(*name)) {
            return protocol;
        }
        const auto near = nearest(*name, protocol_names());
        return near ? find_protocol(*near) : nullptr;
    }
    return nullptr;
}

/// What may stand in the table of an input or output, by its protocol.
struct PortKeys {
    const Protocol* protocol = nullptr;
    std::vector<Key> keys;
    /// Of an unknown protocol, any protocol's keys: none is a mistake of its own.
    std::vector<std::string_view> tolerated;
};

PortKeys port_keys(const Table& table, std::span<const Key> common, SettingScope scope) {
    PortKeys port{meant_protocol(table, common), {common.begin(), common.end()}, {}};
    for (const Protocol* protocol : protocols()) {
        const auto own = protocol_keys(*protocol, scope);
        if (protocol == port.protocol) {
            port.keys.insert(port.keys.end(), own.begin(), own.end());
        } else if (port.protocol == nullptr) {
            std::ranges::move(names_of(own), std::back_inserter(port.tolerated));
        }
    }
    return port;
}

SettingValues own_settings(const PortKeys& port, std::size_t common, const TableContent& content) {
    SettingValues settings;
    for (std::size_t i = common; i < port.keys.size(); ++i) {
        if (const SettingValue* value = content.values().find(port.keys[i].name())) {
            settings.set(port.keys[i].name(), *value);
        }
    }
    return settings;
}

/// No serial driver of Linux has a setting that inverts a line, so the wish is always a mistake.
void check_inverted(const TableContent& content, Mistakes& mistakes) {
    if (content.values().get_or("inverted", false)) {
        mistakes.add(content.where("inverted"),
                     "\"inverted\" is true, but Linux has no setting that inverts a serial port; "
                     "invert the wire instead: with a transistor or a 74HC04, with the inversion "
                     "bit in the EEPROM of an FTDI adapter, or with the device-tree flag that some "
                     "UARTs have; then leave inverted = false");
    }
}

PortConfig port_config(const PortKeys& port, const TableContent& content) {
    PortConfig config;
    config.device = content.values().get_or("device", std::string());
    config.where = content.where("device");
    if (port.protocol != nullptr) {
        config.line = port.protocol->line;
        const auto baud = content.values().get_or("baud", std::int64_t{config.line.baud});
        config.line.baud = static_cast<std::uint32_t>(baud);
    }
    return config;
}

bool port_sound(const PortKeys& port, const TableContent& content) {
    return port.protocol != nullptr && content.given("device") && content.sound("device") &&
           content.sound("baud") && content.sound("protocol");
}

/// A frame must have left before the next one is due, with a byte of silence between.
Duration wire_period(const OutputConfig& output) {
    return output.port.line.bytes_time(output.protocol->longest_frame + 1);
}

void check_period(const OutputConfig& output, const TableContent& content, Mistakes& mistakes) {
    const Duration period = output.schedule.period;
    const Duration wire = wire_period(output);
    const Duration protocol = output.protocol->least_period;
    const Location where = content.where("period");
    const std::string found =
        in_quotes(format_duration(period)) + (content.given("period") ? "" : " by default");
    const std::string name = in_quotes(output.protocol->name);
    if (period < wire) {
        const Duration least = output.force ? wire : std::max(wire, protocol);
        mistakes.add(where, fmt::format("\"period\" is {}, shorter than a frame of {} takes on the "
                                        "wire at {} baud; allowed: {} to \"1s\"",
                                        found, name, output.port.line.baud,
                                        in_quotes(format_duration(least))));
    } else if (period < protocol && !output.force) {
        mistakes.add(where, fmt::format("\"period\" is {}, shorter than readers of {} can follow; "
                                        "allowed: {} to \"1s\", or add force = true",
                                        found, name, in_quotes(format_duration(protocol))));
    }
}

ScheduleSettings schedule_settings(const TableContent& content, const Protocol* protocol) {
    ScheduleSettings schedule;
    const SettingValues& values = content.values();
    schedule.kind = values.get_or<std::string>("schedule", {}) == "grid" ? ScheduleKind::grid
                                                                         : ScheduleKind::follow;
    schedule.phase =
        values.get_or<std::string>("phase", {}) == "locked" ? Phase::locked : Phase::free;
    const Duration fallback = protocol == nullptr ? schedule.period : protocol->default_period;
    schedule.period = values.get_or("period", fallback);
    return schedule;
}

void check_phase(const OutputConfig& output, const TableContent& content, Mistakes& mistakes) {
    if (output.schedule.phase == Phase::locked && output.schedule.kind != ScheduleKind::grid &&
        content.sound("schedule")) {
        mistakes.add(content.where("phase"),
                     "\"phase\" is \"locked\", but \"schedule\" is \"follow\", which has no grid "
                     "to lock; allowed: schedule = \"grid\", or leave phase out");
    }
}

}  // namespace

InputDraft read_input(const Entry& entry, const Table& table, Reading reading) {
    const PortKeys port = port_keys(table, input_keys(), SettingScope::input);
    const std::string title = fmt::format("[input.{}]", entry.key);
    const TableContent content =
        read_table({table, entry.value.where, title}, port.keys, reading, port.tolerated);
    check_inverted(content, reading.mistakes);
    InputDraft draft;
    draft.where = entry.where;
    if (content.given("timeout")) {
        draft.timeout = content.where("timeout");
    }
    draft.timeout_sound = content.sound("timeout");
    draft.port_sound = port_sound(port, content);
    draft.config.name = entry.key;
    draft.config.protocol = port.protocol;
    draft.config.settings = own_settings(port, input_keys().size(), content);
    draft.config.port = port_config(port, content);
    draft.config.timeout = content.values().get_or("timeout", Duration::zero());
    if (const Entry* rules = content.find("failsafe_when")) {
        draft.config.failsafe_when = read_loss_rules(rules->value, reading);
    }
    return draft;
}

OutputDraft read_output(const Entry& entry, const Table& table, Reading reading) {
    const PortKeys port = port_keys(table, output_keys(), SettingScope::output);
    const std::string title = fmt::format("[output.{}]", entry.key);
    const TableContent content =
        read_table({table, entry.value.where, title}, port.keys, reading, port.tolerated);
    check_inverted(content, reading.mistakes);
    OutputDraft draft;
    draft.where = entry.where;
    draft.period = content.where("period");
    draft.period_sound = content.sound("period");
    draft.port_sound = port_sound(port, content);
    draft.config.name = entry.key;
    draft.config.protocol = port.protocol;
    draft.config.settings = own_settings(port, output_keys().size(), content);
    draft.config.port = port_config(port, content);
    draft.config.schedule = schedule_settings(content, port.protocol);
    draft.config.force = content.values().get_or("force", false);
    const bool judged = port.protocol != nullptr && content.sound("protocol") &&
                        content.sound("period") && content.sound("baud") && content.sound("force");
    if (judged) {
        check_period(draft.config, content, reading.mistakes);
    }
    check_phase(draft.config, content, reading.mistakes);
    return draft;
}

}  // namespace tribus
