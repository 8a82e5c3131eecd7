#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "transports/codecs/dronecan/actuators.h"
#include "transports/codecs/dronecan/dronecan.h"
#include "transports/codecs/dronecan/rc.h"

namespace tribus {
namespace dronecan {
namespace {

constexpr std::array<std::string_view, 3> kCarries{"rc", "servos", "motors"};
constexpr std::array<std::string_view, 3> kScales{"us", "sbus", "full_range"};
constexpr std::array<std::string_view, 3> kSafetyRules{"heard", "required", "ignored"};
constexpr std::array<std::string_view, 2> kCommands{"unitless", "pulse"};
constexpr std::array<std::string_view, 5> kQualityTypes{"link_quality", "rssi", "rssi_dbm", "snr",
                                                        "tx_power"};
constexpr std::size_t kMostServos = 15;
constexpr std::size_t kMostMotors = 20;

constexpr std::array kDroneCanSettings{
    Setting{.key = "carries",
            .type = SettingType::choice,
            .fallback = "\"rc\"",
            .choices = kCarries,
            .help = "`rc`: channels as RCInput; `servos`: commands as ArrayCommand; `motors`: "
                    "commands as RawCommand",
            .example = "\"motors\""},
    Setting{.key = "node_id",
            .type = SettingType::integer,
            .absent = "the `node_id` of `[dronecan.NAME]` with that interface",
            .least = 1,
            .most = kMostOwnDroneCanNodeId,
            .scope = SettingScope::output,
            .help = "Node id of this program on the interface",
            .example = "42"},
    Setting{.key = "fd",
            .type = SettingType::boolean,
            .fallback = "false",
            .help = "`true`: an output sends CAN FD frames with bit rate switching; an input "
                    "takes such frames too",
            .example = "true"},
    Setting{.key = "from_node",
            .type = SettingType::integer,
            .absent = "the first one that is heard, until it has been silent for 3 s",
            .least = 1,
            .most = kMostNodeId,
            .scope = SettingScope::input,
            .help = "The only node that is listened to",
            .example = "50"},
    Setting{.key = "receiver",
            .type = SettingType::integer,
            .absent = "any for an input, 0 for an output",
            .least = 0,
            .most = 15,
            .help = "With `rc`: number of the receiver, where a node has several",
            .example = "1"},
    Setting{.key = "channels",
            .type = SettingType::integer,
            .absent = "18; 4 for an output of servos or motors",
            .least = 1,
            .most = static_cast<double>(kChannelCount),
            .help = "How many channels. A message holds 15 servos, or motors up to number 19",
            .example = "8"},
    Setting{.key = "first",
            .type = SettingType::integer,
            .absent = "servo 1, motor 0",
            .least = 0,
            .most = 255,
            .help = "With `servos` and `motors`: number of the servo or motor that is channel 1",
            .example = "5"},
    Setting{.key = "scale",
            .type = SettingType::choice,
            .fallback = "\"us\"",
            .choices = kScales,
            .scope = SettingScope::input,
            .help = "With `rc`: what the sender's numbers are. `us`: microseconds; `sbus`: raw "
                    "SBUS values; `full_range`: 0 to 4095 for 1000 to 2000 us",
            .example = "\"sbus\""},
    Setting{.key = "safety",
            .type = SettingType::choice,
            .fallback = "\"heard\"",
            .choices = kSafetyRules,
            .scope = SettingScope::input,
            .help =
                "With `servos` and `motors`: whether the vehicle's SafetyState and ArmingStatus "
                "count. `heard`: failsafe while they say that it is not safe to move; "
                "`required`: failsafe unless they say that it is safe; `ignored`: they do not "
                "count",
            .example = "\"required\""},
    Setting{.key = "command",
            .type = SettingType::choice,
            .fallback = "\"unitless\"",
            .choices = kCommands,
            .scope = SettingScope::output,
            .help = "With `servos`: `unitless`: -1 to 1 for 1000 to 2000 us; `pulse`: pulses in "
                    "us",
            .example = "\"pulse\""},
    Setting{.key = "reversible",
            .type = SettingType::boolean,
            .fallback = "false",
            .help = "With `motors`: `true`: 1500 us is standstill; `false`: 1000 us is",
            .example = "true"},
    Setting{.key = "arms",
            .type = SettingType::boolean,
            .fallback = "false",
            .scope = SettingScope::output,
            .help = "With `servos` and `motors`: `true`: tells their nodes that they may move "
                    "(SafetyState, ArmingStatus), once an input has had control",
            .example = "true"},
    Setting{.key = "quality",
            .type = SettingType::text,
            .fallback = "\"link\"",
            .scope = SettingScope::output,
            .help = "With `rc`: link quality that is sent. `link`: that of the input, or the share "
                    "of its frames that are good; `none`; or a named value",
            .example = "\"input.receiver.channel.14\""},
    Setting{.key = "quality_type",
            .type = SettingType::choice,
            .fallback = "\"link_quality\"",
            .choices = kQualityTypes,
            .scope = SettingScope::output,
            .help = "With `rc`: unit of `quality` that the receiver of the message shows: "
                    "percent (`link_quality`, `rssi`), dBm (`rssi_dbm`), dB (`snr`), mW "
                    "(`tx_power`)",
            .example = "\"rssi_dbm\""},
};

bool carries_rc(const SettingValues& settings) {
    return settings.get_or<std::string>("carries", "rc") == "rc";
}

/// Servo and motor nodes have timeouts, so an unchanged command is repeated at 25 Hz or more
/// (docs/protocols/can.md, "DroneCAN: commands").
std::optional<Duration> most_period(const SettingValues& settings) {
    constexpr Duration kMostCommandPeriod = std::chrono::milliseconds(40);
    return carries_rc(settings) ? std::nullopt : std::optional(kMostCommandPeriod);
}

CommandKind command_kind(const SettingValues& settings) {
    return settings.get_or<std::string>("carries", "rc") == "motors" ? CommandKind::motors
                                                                     : CommandKind::servos;
}

template <class Integer>
std::optional<Integer> number(const SettingValues& settings, std::string_view key) {
    const auto* value = settings.find_as<std::int64_t>(key);
    return value == nullptr ? std::nullopt : std::optional(static_cast<Integer>(*value));
}

/// On a bus the node sets the id. Frames that are written without a node are those of node 1.
NodeId node_of(const SettingValues& settings) {
    return number<NodeId>(settings, "node_id").value_or(1);
}

std::size_t place_of(std::string_view name, std::span<const std::string_view> names) {
    return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
}

RcInputFormat rc_input(const SettingValues& settings) {
    return {.source = {number<NodeId>(settings, "from_node")},
            .scale = static_cast<RcScale>(
                place_of(settings.get_or<std::string>("scale", "us"), kScales)),
            .receiver = number<std::uint8_t>(settings, "receiver"),
            .fd = settings.get_or("fd", false)};
}

RcOutputFormat rc_output(const SettingValues& settings) {
    constexpr std::array kTypes{RcInput::kQualityTypeLinkQuality, RcInput::kQualityTypeRssi,
                                RcInput::kQualityTypeRssiDbm, RcInput::kQualityTypeSnr,
                                RcInput::kQualityTypeTxPower};
    const auto quality = settings.get_or<std::string>("quality", "link");
    return {.node = node_of(settings),
            .fd = settings.get_or("fd", false),
            .receiver = number<std::uint8_t>(settings, "receiver").value_or(0),
            .channels = number<std::size_t>(settings, "channels").value_or(kChannelCount),
            .quality = quality == "none"   ? RcQuality::none
                       : quality == "link" ? RcQuality::link
                                           : RcQuality::value,
            .quality_type = kTypes[place_of(
                settings.get_or<std::string>("quality_type", "link_quality"), kQualityTypes)],
            .quality_value = quality};
}

std::uint8_t first_of(const SettingValues& settings) {
    return number<std::uint8_t>(settings, "first")
        .value_or(command_kind(settings) == CommandKind::servos ? 1 : 0);
}

CommandInputFormat command_input(const SettingValues& settings) {
    return {.kind = command_kind(settings),
            .source = {number<NodeId>(settings, "from_node")},
            .first = first_of(settings),
            .channels = number<std::size_t>(settings, "channels").value_or(kChannelCount),
            .reversible = settings.get_or("reversible", false),
            .safety = static_cast<SafetyRule>(
                place_of(settings.get_or<std::string>("safety", "heard"), kSafetyRules)),
            .fd = settings.get_or("fd", false)};
}

CommandOutputFormat command_output(const SettingValues& settings) {
    return {.node = node_of(settings),
            .kind = command_kind(settings),
            .fd = settings.get_or("fd", false),
            .first = first_of(settings),
            .channels =
                number<std::size_t>(settings, "channels").value_or(CommandOutputFormat{}.channels),
            .pulses = settings.get_or<std::string>("command", "unitless") == "pulse",
            .reversible = settings.get_or("reversible", false),
            .arms = settings.get_or("arms", false)};
}

/// Refuses a key that has no meaning here. A key with a default counts as given if it differs from
/// that.
void refuse(const SettingValues& settings, std::string_view key, std::string_view fallback,
            std::string_view meant_for, std::vector<SettingMistake>& mistakes) {
    const auto* text = settings.find_as<std::string>(key);
    const auto* truth = settings.find_as<bool>(key);
    const bool given = text != nullptr    ? *text != fallback
                       : truth != nullptr ? *truth
                                          : settings.find(key) != nullptr;
    if (given) {
        mistakes.push_back({{std::string(key)},
                            "\"" + std::string(key) + "\" is for carries = " +
                                std::string(meant_for) + "; leave it out"});
    }
}

void check_count(const SettingValues& settings, std::vector<SettingMistake>& mistakes) {
    const CommandOutputFormat format = command_output(settings);
    const bool servos = format.kind == CommandKind::servos;
    const std::size_t most = servos ? kMostServos : kMostMotors;
    const std::size_t count = servos ? format.channels : format.first + format.channels;
    if (count > most) {
        mistakes.push_back({{"channels"},
                            std::to_string(count) + " do not fit into one message; allowed: " +
                                std::to_string(most) + (servos ? " servos" : " motors, from 0") +
                                ", or further outputs for more"});
    }
    if (servos && format.first + format.channels > 256) {
        mistakes.push_back({{"first"}, "actuator numbers go up to 255"});
    }
}

std::vector<SettingMistake> check(const SettingValues& settings, SettingScope scope) {
    std::vector<SettingMistake> mistakes;
    constexpr std::string_view kActuators = "\"servos\" or \"motors\"";
    const auto carries = settings.get_or<std::string>("carries", "rc");
    if (carries == "rc") {
        refuse(settings, "first", {}, kActuators, mistakes);
        refuse(settings, "safety", "heard", kActuators, mistakes);
        refuse(settings, "arms", {}, kActuators, mistakes);
    } else {
        refuse(settings, "receiver", {}, "\"rc\"", mistakes);
        refuse(settings, "scale", "us", "\"rc\"", mistakes);
        refuse(settings, "quality", "link", "\"rc\"", mistakes);
        refuse(settings, "quality_type", "link_quality", "\"rc\"", mistakes);
    }
    if (carries != "servos") {
        refuse(settings, "command", "unitless", "\"servos\"", mistakes);
    }
    if (carries != "motors") {
        refuse(settings, "reversible", {}, "\"motors\"", mistakes);
    }
    if (carries != "rc" && scope == SettingScope::output) {
        check_count(settings, mistakes);
    }
    return mistakes;
}

SettingValues dependent_defaults(const SettingValues& settings, SettingScope way) {
    SettingValues defaults;
    const bool sends = way == SettingScope::output;
    if (carries_rc(settings)) {
        const RcOutputFormat format = rc_output(settings);
        if (sends) {
            defaults.set("receiver", std::int64_t{format.receiver});
            defaults.set("channels", static_cast<std::int64_t>(format.channels));
        }
        return defaults;
    }
    const std::size_t channels =
        sends ? command_output(settings).channels : command_input(settings).channels;
    defaults.set("channels", static_cast<std::int64_t>(channels));
    defaults.set("first", std::int64_t{first_of(settings)});
    return defaults;
}

/// The sender of an RCInput decides how many channels it has.
std::uint32_t possible_channels(const SettingValues& settings) {
    return carries_rc(settings) ? kAllChannels : first_channels(command_input(settings).channels);
}

std::optional<MovingPresets> moves_by_default(const SettingValues& settings) {
    if (carries_rc(settings) || command_kind(settings) != CommandKind::motors) {
        return std::nullopt;
    }
    const CommandOutputFormat format = command_output(settings);
    return MovingPresets{first_channels(format.channels),
                         Pulse::from_microseconds(format.reversible ? 1500 : 1000)};
}

std::vector<NamedUse> value_names(const SettingValues& settings) {
    const RcOutputFormat format = rc_output(settings);
    const bool named = carries_rc(settings) && format.quality == RcQuality::value;
    if (!named) {
        return {};
    }
    const std::string unit(unit_of_quality(format.quality_type));
    return {{.name = format.quality_value,
             .path = {"quality"},
             .unit = unit,
             .takes_pulses = unit == "%"}};
}

AnyDecoder make_decoder(const SettingValues& settings) {
    if (carries_rc(settings)) {
        return std::make_unique<RcDecoder>(rc_input(settings));
    }
    return std::make_unique<CommandDecoder>(command_input(settings));
}

AnyEncoder make_encoder(const SettingValues& settings) {
    if (carries_rc(settings)) {
        return std::make_unique<RcEncoder>(rc_output(settings));
    }
    return std::make_unique<CommandEncoder>(command_output(settings));
}

}  // namespace
}  // namespace dronecan

const Protocol kDroneCanProtocol{
    .name = "dronecan",
    .title = "DroneCAN",
    .description = "DroneCAN: RCInput, ArrayCommand, RawCommand",
    .shape = WireShape::can_frames,
    .line = {},
    .settings = dronecan::kDroneCanSettings,
    .default_period = std::chrono::milliseconds(10),
    // More than 100 Hz fills a shared bus, and autopilots do not distinguish shorter periods.
    .least_period = std::chrono::milliseconds(10),
    .most_period = dronecan::most_period,
    .signals_failsafe = dronecan::carries_rc,
    .possible_channels = dronecan::possible_channels,
    .check = dronecan::check,
    .dependent_defaults = dronecan::dependent_defaults,
    .moves_by_default = dronecan::moves_by_default,
    .value_names = dronecan::value_names,
    .make_decoder = dronecan::make_decoder,
    .make_encoder = dronecan::make_encoder,
};

}  // namespace tribus
