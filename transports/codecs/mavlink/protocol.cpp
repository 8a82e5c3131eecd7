#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "transports/codecs/mavlink/mavlink.h"
#include "transports/codecs/mavlink/telemetry.h"

namespace tribus {
namespace {

/// In the order of MavlinkChannels.
constexpr std::array<std::string_view, 4> kMavlinkMessageNames{
    "radio_rc_channels", "rc_channels_override", "rc_channels", "manual_control"};
constexpr std::array<std::string_view, 2> kOnLoss{"silence", "release"};
/// In the order of MavlinkThrottle.
constexpr std::array<std::string_view, 2> kThrottles{"zero based", "centred"};
constexpr std::size_t kVersion1Channels = 8;
constexpr std::size_t kUsualChannels = 16;
/// Channels 5 to 18.
constexpr double kMostManualButtons = 14;

constexpr std::array kMavlinkSettings{
    baud_setting("57600", "460800", 3e6),
    Setting{.key = "message",
            .type = SettingType::choice,
            .absent = "an output sends `radio_rc_channels`, an input reads the first that it hears",
            .choices = kMavlinkMessageNames,
            .help = "The message that carries the channels: `radio_rc_channels` is RC input with a "
                    "failsafe flag (ArduPilot 4.6 and newer); `rc_channels_override` takes "
                    "channels over; `manual_control` is four axes and buttons; `rc_channels` is "
                    "what an autopilot says, on inputs only",
            .example = "\"rc_channels_override\""},
    Setting{.key = "system",
            .type = SettingType::integer,
            .absent = "255 on an output; on an input the first one that is heard, until it is "
                      "silent for a second",
            .least = 1,
            .most = 255,
            .help = "System id of the sender. An input counts messages of others as "
                    "`other_sender`. An output sends as this one; for `rc_channels_override` and "
                    "`manual_control`, ArduPilot takes only that of its ground station "
                    "(`MAV_GCS_SYSID`, `SYSID_MYGCS`), and drops others without a word",
            .example = "1"},
    Setting{.key = "component",
            .type = SettingType::integer,
            .fallback = "190",
            .least = 1,
            .most = 255,
            .scope = SettingScope::output,
            .help = "Component id as which tribus sends",
            .example = "68"},
    Setting{.key = "target",
            .type = SettingType::integer,
            .fallback = "1",
            .least = 1,
            .most = 255,
            .help = "System id that is steered: the autopilot; on an input, messages to another "
                    "system are passed over",
            .example = "2"},
    Setting{.key = "version",
            .type = SettingType::integer,
            .fallback = "2",
            .least = 1,
            .most = 2,
            .scope = SettingScope::output,
            .help = "Version of MAVLink that is sent; both are read",
            .example = "1"},
    Setting{.key = "channels",
            .type = SettingType::integer,
            .absent = "16; 8 with `version = 1`",
            .least = 1,
            .most = kChannelCount,
            .scope = SettingScope::output,
            .help = "How many channels are sent, all or none",
            .example = "8"},
    Setting{.key = "buttons",
            .type = SettingType::integer,
            .absent = "none",
            .least = 1,
            .most = kMostManualButtons,
            .help = "With `manual_control`: how many buttons, channel 5 and on, above 1500 us "
                    "pressed",
            .example = "4"},
    Setting{.key = "throttle",
            .type = SettingType::choice,
            .absent = "\"zero based\"",
            .choices = kThrottles,
            .help = "With `manual_control`: how its throttle counts 1000 to 2000 us. `zero based`: "
                    "0 to 1000, for vehicles that do not reverse, and for PX4; `centred`: -1000 "
                    "to 1000, for ArduPilot's rovers and boats, where a centred stick would be "
                    "half throttle otherwise",
            .example = "\"centred\""},
    Setting{.key = "on_loss",
            .type = SettingType::choice,
            .fallback = kOnLoss[0],
            .choices = kOnLoss,
            .scope = SettingScope::output,
            .help = "When the output falls silent: `silence` sends nothing more; `release` gives "
                    "the channels of `rc_channels_override` back at once, and after a reload "
                    "those that are not sent any more",
            .example = "\"release\""},
    Setting{.key = "key",
            .type = SettingType::key_file,
            .absent = "nothing is signed, and no signature is looked at",
            .help = "Key file of the signatures of MAVLink 2: 32 bytes, or 64 hexadecimal digits; "
                    "others than its owner and group must not be able to read it. An output signs "
                    "all messages; an input takes only what is signed with this key and new",
            .example = "\"/etc/tribus/keys/drone.key\""},
    Setting{.key = "link_id",
            .type = SettingType::integer,
            .absent = "0",
            .least = 0,
            .most = 255,
            .scope = SettingScope::output,
            .help = "With `key`: the link in the signatures. Two outputs with one `system` and "
                    "`component` to one autopilot need different ones",
            .example = "1"},
};

/// The index of a word, if the key is given.
template <std::size_t count>
std::optional<std::size_t> chosen_word(const SettingValues& settings, std::string_view key,
                                       const std::array<std::string_view, count>& words) {
    const auto* word = settings.find_as<std::string>(key);
    const auto found = word == nullptr ? words.end() : std::ranges::find(words, *word);
    return found == words.end() ? std::nullopt
                                : std::optional(static_cast<std::size_t>(found - words.begin()));
}

std::optional<MavlinkChannels> chosen_message(const SettingValues& settings) {
    const auto index = chosen_word(settings, "message", kMavlinkMessageNames);
    return index ? std::optional(static_cast<MavlinkChannels>(*index)) : std::nullopt;
}

std::uint8_t id_setting(const SettingValues& settings, std::string_view key,
                        std::int64_t fallback) {
    return static_cast<std::uint8_t>(settings.get_or(key, fallback));
}
std::size_t count_setting(const SettingValues& settings, std::string_view key,
                          std::size_t fallback) {
    return static_cast<std::size_t>(settings.get_or(key, static_cast<std::int64_t>(fallback)));
}

MavlinkThrottle throttle_setting(const SettingValues& settings) {
    return static_cast<MavlinkThrottle>(chosen_word(settings, "throttle", kThrottles).value_or(0));
}

std::optional<SecretKey> key_setting(const SettingValues& settings) {
    const auto* file = settings.find_as<KeyFile>("key");
    return file == nullptr ? std::nullopt : std::optional(file->secret);
}

MavlinkEncoder::Settings encoder_settings(const SettingValues& settings) {
    const bool version_1 = count_setting(settings, "version", 2) == 1;
    return {.message = chosen_message(settings).value_or(MavlinkChannels::radio_rc_channels),
            .version_1 = version_1,
            .system = id_setting(settings, "system", 255),
            .component = id_setting(settings, "component", 190),
            .target = id_setting(settings, "target", 1),
            .channels =
                count_setting(settings, "channels", version_1 ? kVersion1Channels : kUsualChannels),
            .buttons = count_setting(settings, "buttons", 0),
            .throttle = throttle_setting(settings),
            .releases = chosen_word(settings, "on_loss", kOnLoss) == 1U,
            .key = key_setting(settings),
            .link_id = id_setting(settings, "link_id", 0)};
}

SettingValues mavlink_defaults(const SettingValues& settings, SettingScope way) {
    SettingValues defaults;
    if (way != SettingScope::output) {
        return defaults;
    }
    const MavlinkEncoder::Settings sent = encoder_settings(settings);
    defaults.set("message",
                 std::string(kMavlinkMessageNames[static_cast<std::size_t>(sent.message)]));
    defaults.set("system", std::int64_t{sent.system});
    if (sent.message != MavlinkChannels::manual_control) {
        defaults.set("channels", static_cast<std::int64_t>(sent.channels));
    } else {
        defaults.set("throttle", std::string(kThrottles[static_cast<std::size_t>(sent.throttle)]));
    }
    if (sent.key) {
        defaults.set("link_id", std::int64_t{sent.link_id});
    }
    return defaults;
}

void check_signing(const SettingValues& settings, bool version_1,
                   std::vector<SettingMistake>& mistakes) {
    const bool signs = settings.find("key") != nullptr;
    if (signs && version_1) {
        mistakes.push_back({{"key"},
                            "\"key\" has no effect with MAVLink 1, which has no signatures; leave "
                            "it out, or version = 2"});
    }
    if (!signs && settings.find("link_id") != nullptr) {
        mistakes.push_back(
            {{"link_id"}, "\"link_id\" has no effect without \"key\"; leave it out"});
    }
}

std::vector<SettingMistake> check_sent(const SettingValues& settings) {
    const MavlinkEncoder::Settings sent = encoder_settings(settings);
    std::vector<SettingMistake> mistakes;
    if (sent.message == MavlinkChannels::rc_channels) {
        mistakes.push_back({{"message"},
                            "\"message\" is \"rc_channels\", which only autopilots send; allowed: "
                            "\"radio_rc_channels\", \"rc_channels_override\", "
                            "\"manual_control\""});
    }
    if (sent.version_1 && sent.message == MavlinkChannels::radio_rc_channels) {
        mistakes.push_back({{"version"},
                            "\"version\" is 1, which has no radio_rc_channels; allowed: 2, or "
                            "message = \"rc_channels_override\""});
    } else if (sent.version_1 && sent.channels > kVersion1Channels) {
        mistakes.push_back({{"channels"},
                            "\"channels\" is " + std::to_string(sent.channels) +
                                ", and MAVLink 1 carries 8; allowed: 1 to 8, or version = 2"});
    }
    if (sent.releases && sent.message != MavlinkChannels::rc_channels_override) {
        mistakes.push_back({{"on_loss"},
                            "\"on_loss\" is \"release\", and only rc_channels_override can give "
                            "channels back; allowed: \"silence\""});
    }
    if (settings.find("channels") != nullptr && sent.message == MavlinkChannels::manual_control) {
        mistakes.push_back({{"channels"},
                            "\"channels\" has no effect with manual_control, which carries "
                            "channels 1 to 4 and \"buttons\"; leave it out"});
    }
    check_signing(settings, sent.version_1, mistakes);
    return mistakes;
}

std::vector<SettingMistake> check_mavlink(const SettingValues& settings, SettingScope scope) {
    auto mistakes =
        scope == SettingScope::input ? std::vector<SettingMistake>{} : check_sent(settings);
    for (const char* const key : {"buttons", "throttle"}) {
        if (settings.find(key) != nullptr &&
            chosen_message(settings) != MavlinkChannels::manual_control) {
            mistakes.push_back({{key},
                                "\"" + std::string(key) +
                                    "\" has no effect without message = \"manual_control\"; "
                                    "leave it out"});
        }
    }
    return mistakes;
}

/// The configuration does not tell which vehicle it is.
std::vector<SettingMistake> doubt_throttle(const SettingValues& settings, SettingScope scope) {
    if (scope != SettingScope::output || settings.find("throttle") != nullptr ||
        chosen_message(settings) != MavlinkChannels::manual_control) {
        return {};
    }
    return {{{"message"},
             "\"manual_control\" without \"throttle\": on a rover or boat with ArduPilot a centred "
             "stick would be half throttle, and reverse could not be reached; add throttle = "
             "\"centred\" for such a vehicle, throttle = \"zero based\" for all others"}};
}

/// The default preset of the throttle, 988 us, is full reverse where its centre stands still.
std::optional<MovingPresets> moves_by_default_throttle(const SettingValues& settings) {
    const MavlinkEncoder::Settings sent = encoder_settings(settings);
    return sent.message == MavlinkChannels::manual_control &&
                   sent.throttle == MavlinkThrottle::centred
               ? std::optional(MovingPresets{1U << 2U, kCentrePulse})
               : std::nullopt;
}

std::size_t bytes_of_signatures(const SettingValues& settings) {
    return key_setting(settings) ? MavlinkEncoder::kLongestSigned - MavlinkEncoder::kLongest : 0;
}

std::string mavlink_advice_of(const SettingValues& settings, const Answers& answers) {
    return mavlink_advice(encoder_settings(settings), answers);
}

/// RC_CHANNELS does by SYS_STATUS beside it.
bool mavlink_signals_failsafe(const SettingValues& settings) {
    const auto message = chosen_message(settings);
    return !message || message == MavlinkChannels::radio_rc_channels ||
           message == MavlinkChannels::rc_channels;
}

AnyDecoder make_mavlink_decoder(const SettingValues& settings) {
    const auto* system = settings.find_as<std::int64_t>("system");
    return std::make_unique<MavlinkDecoder>(MavlinkDecoder::Settings{
        .message = chosen_message(settings),
        .system =
            system == nullptr ? std::nullopt : std::optional(static_cast<std::uint8_t>(*system)),
        .target = id_setting(settings, "target", 1),
        .buttons = count_setting(settings, "buttons", 0),
        .throttle = throttle_setting(settings),
        .key = key_setting(settings)});
}

AnyEncoder make_mavlink_encoder(const SettingValues& settings) {
    return std::make_unique<MavlinkEncoder>(encoder_settings(settings));
}

std::unique_ptr<ByteValueReader> make_mavlink_reader(const SettingValues& settings) {
    return std::make_unique<MavlinkTelemetryReader>(key_setting(settings));
}

constexpr std::array kMavlinkTelemetrySettings{
    baud_setting("57600", "460800", 3e6),
    Setting{.key = "key",
            .type = SettingType::key_file,
            .absent = "no signature is looked at",
            .help = "key file of the signatures; only what is signed with this key counts",
            .example = "\"/etc/tribus/keys/drone.key\""},
};

}  // namespace

// Links of a ground station pass 10 to 50 messages a second. RC_CHANNELS of an autopilot comes as
// often as its stream rate says, often twice a second.
const Protocol kMavlinkProtocol{
    .name = "mavlink",
    .title = "MAVLink",
    .description =
        "Channels over MAVLink 1 and 2, to autopilots and from them, from ground "
        "stations and radio links",
    .line = {.baud = 57600, .parity = Parity::none, .stop_bits = 1},
    .settings = kMavlinkSettings,
    .longest_frame = MavlinkEncoder::kLongest,
    .longer_by = bytes_of_signatures,
    .default_period = std::chrono::milliseconds(20),
    .least_period = std::chrono::milliseconds(4),
    .default_timeout = std::chrono::milliseconds(500),
    .signals_failsafe = mavlink_signals_failsafe,
    .check = check_mavlink,
    .warnings = doubt_throttle,
    .dependent_defaults = mavlink_defaults,
    .moves_by_default = moves_by_default_throttle,
    .advice_by_answers = mavlink_advice_of,
    .make_decoder = make_mavlink_decoder,
    .make_encoder = make_mavlink_encoder,
};

const Protocol kMavlinkTelemetryProtocol{
    .name = "mavlink-telemetry",
    .title = "MAVLink telemetry",
    .description = "Named values of an autopilot: battery, GPS, attitude, speeds, its own state",
    .line = {.baud = 57600, .parity = Parity::none, .stop_bits = 1},
    .settings = kMavlinkTelemetrySettings,
    .signals_failsafe = never_signals_failsafe,
    .make_value_reader = make_mavlink_reader,
};

}  // namespace tribus
