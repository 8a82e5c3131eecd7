#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <iterator>
#include <memory>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "transports/codecs/dbc/dbc.h"
#include "transports/codecs/dbc/map.h"
#include "transports/codecs/dbc/roles.h"
#include "transports/codecs/dbc/signal_keys.h"

namespace tribus {
namespace {

constexpr std::array kDbcSettings{
    Setting{.key = "dbc",
            .type = SettingType::file,
            .required = true,
            .help = "DBC file that describes the messages, from the folder of the configuration",
            .example = "\"rover.dbc\""},
    Setting{.key = "signals",
            .type = SettingType::tree,
            .required = true,
            .help = "What the signals are for: `{ MESSAGE = { SIGNAL = meaning } }`. A meaning "
                    "is a channel number, or a table with one of `channel`, `flag`, `fixed`, "
                    "`counter`, `checksum`, `from`",
            .example = "{ Command = { Steering = 1, Lost = { flag = \"failsafe\" } } }",
            .inside = kDbcSignalKeys},
    Setting{.key = "own_address",
            .type = SettingType::integer,
            .least = 0,
            .most = 253,
            .scope = SettingScope::output,
            .help = "J1939: source address of this program. Fills the source address of ids that "
                    "the DBC file leaves at 0xFE; other ids stay",
            .example = "0x33"},
    Setting{.key = "cycles",
            .type = SettingType::tree,
            .absent = "the cycle times of the DBC file",
            .help = "Cycle times that differ from those of the DBC file, 1ms to 60s: `{ MESSAGE "
                    "= \"100ms\" }`",
            .example = "{ Heartbeat = \"1s\" }"},
};

constexpr Duration kLeastDbcPeriod = std::chrono::milliseconds(1);
/// Period if neither the user nor the file gives one: J1939 joysticks and drive units of rovers are
/// sent every 20 ms at most (docs/protocols/can.md, "J1939 joysticks" and "Drive units and
/// robots").
constexpr Duration kDefaultDbcPeriod = std::chrono::milliseconds(20);

std::vector<SettingMistake> check_dbc(const SettingValues& settings, SettingScope scope) {
    auto map = build_dbc_map(settings, scope);
    return map ? std::vector<SettingMistake>{} : std::move(map.error());
}

std::vector<SettingMistake> warnings_of_map(const DbcMap& map) {
    std::vector<SettingMistake> warnings;
    if (!map.signals_failsafe()) {
        return warnings;
    }
    for (std::size_t i = 0; i < map.messages.size(); ++i) {
        if (!map.message_signals_failsafe(i)) {
            warnings.push_back(
                {{"signals", map.messages[i].name},
                 "its frames cannot say failsafe, although other messages of this output can: "
                 "their receiver sees held values and presets unmarked; add a signal with { flag "
                 "= \"failsafe\" } or { flag = \"good\" }, or \"error\" or \"not_available\" to "
                 "each of its channels"});
        }
    }
    return warnings;
}

std::vector<SettingMistake> warnings_about(const SettingValues& settings, SettingScope scope) {
    const auto* text = settings.find_as<SettingFile>("dbc");
    const auto file = text == nullptr ? DbcFile{} : parse_dbc(text->content).value_or(DbcFile{});
    auto warnings = warnings_about_dbc(file, text == nullptr ? "" : text->path);
    if (scope == SettingScope::output) {
        if (const auto map = build_dbc_map(settings, scope)) {
            std::ranges::move(warnings_of_map(*map), std::back_inserter(warnings));
        }
    }
    return warnings;
}

bool signals_failsafe(const SettingValues& settings) {
    const auto map = build_dbc_map(settings, SettingScope::output);
    return map && map->signals_failsafe();
}

std::optional<Duration> own_period(const SettingValues& settings) {
    // Tries both directions, because each allows roles that the other refuses.
    auto map = build_dbc_map(settings, SettingScope::output);
    if (!map) {
        map = build_dbc_map(settings, SettingScope::input);
    }
    auto cycle = map ? map->shortest_cycle() : std::nullopt;
    if (map && !cycle && !map->needs_channels()) {
        // Slower messages of such an output keep their own cycle.
        const auto quickest = map->shortest_cycle_of_all();
        cycle = quickest && *quickest < kDefaultDbcPeriod ? quickest : std::nullopt;
    }
    return cycle ? std::optional(std::max(*cycle, kLeastDbcPeriod)) : std::nullopt;
}

/// The unit of a signal that carries a value.
std::string unit_of_value_signal(const DbcMap& map, const std::string& message,
                                 const std::string& signal) {
    for (const DbcPart& part : map.parts) {
        const auto found = std::ranges::find(part.values, signal, &DbcValue::signal);
        if (map.messages[part.message].name == message && found != part.values.end()) {
            return found->unit;
        }
    }
    return {};
}

std::vector<NamedUse> value_names(const SettingValues& settings) {
    std::vector<NamedUse> uses;
    const auto map = build_dbc_map(settings, SettingScope::output);
    const auto* signals = settings.find_as<SettingTree>("signals");
    const auto* messages = signals == nullptr ? nullptr : signals->as<SettingTree::Table>();
    if (messages == nullptr) {
        return uses;
    }
    for (const SettingEntry& message : *messages) {
        const auto* roles = message.value.as<SettingTree::Table>();
        if (roles == nullptr) {
            continue;
        }
        for (const SettingEntry& signal : *roles) {
            std::vector<SettingMistake> ignored;
            const auto role = read_dbc_role(signal.value, {}, ignored);
            if (const auto* value = role ? std::get_if<DbcValueRole>(&*role) : nullptr) {
                uses.push_back(
                    {value->from,
                     {"signals", message.key, signal.key, "from"},
                     map ? unit_of_value_signal(*map, message.key, signal.key) : std::string()});
            }
        }
    }
    return uses;
}

bool needs_pipeline(const SettingValues& settings) {
    const auto map = build_dbc_map(settings, SettingScope::output);
    return !map || map->needs_channels();
}

/// The channels of an input that match, one bit each. Nothing if the settings have mistakes.
std::optional<std::uint32_t> channels_that(const SettingValues& settings,
                                           bool (*match)(const DbcChannel&)) {
    const auto map = build_dbc_map(settings, SettingScope::input);
    if (!map) {
        return std::nullopt;
    }
    std::uint32_t channels = 0;
    for (const DbcPart& part : map->parts) {
        for (const DbcChannel& channel : part.channels) {
            channels |= match(channel) ? 1U << channel.channel : 0U;
        }
    }
    return channels;
}

bool is_sure(const DbcChannel& channel) {
    return !channel.optional;
}

bool is_optional(const DbcChannel& channel) {
    return channel.optional;
}

std::optional<std::uint32_t> sure_dbc_channels(const SettingValues& settings) {
    return channels_that(settings, is_sure);
}

std::uint32_t possible_dbc_channels(const SettingValues& settings) {
    return channels_that(settings, [](const DbcChannel&) { return true; }).value_or(kAllChannels);
}

std::uint32_t optional_dbc_channels(const SettingValues& settings) {
    return channels_that(settings, is_optional).value_or(0);
}

AnyDecoder make_dbc_decoder(const SettingValues& settings) {
    auto map = build_dbc_map(settings, SettingScope::input);
    return std::make_unique<DbcDecoder>(map ? std::move(*map) : DbcMap{});
}

AnyEncoder make_dbc_encoder(const SettingValues& settings) {
    auto map = build_dbc_map(settings, SettingScope::output);
    return std::make_unique<DbcEncoder>(map ? std::move(*map) : DbcMap{});
}

}  // namespace

const Protocol kDbcProtocol{
    .name = "dbc",
    .title = "DBC",
    .description = "Messages that a DBC file describes",
    .shape = WireShape::can_frames,
    .line = {},
    .settings = kDbcSettings,
    .default_period = kDefaultDbcPeriod,
    .own_period = own_period,
    .least_period = kLeastDbcPeriod,
    .signals_failsafe = signals_failsafe,
    .sure_channels = sure_dbc_channels,
    .possible_channels = possible_dbc_channels,
    .check = check_dbc,
    .warnings = warnings_about,
    .optional_channels = optional_dbc_channels,
    .value_names = value_names,
    .needs_pipeline = needs_pipeline,
    .make_decoder = make_dbc_decoder,
    .make_encoder = make_dbc_encoder,
};

}  // namespace tribus
