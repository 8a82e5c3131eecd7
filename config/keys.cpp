#include "config/keys.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "core/channel_frame.h"

namespace tribus {
namespace {

using enum SettingType;

constexpr std::array<std::string_view, 3> kRealtimeChoices{"auto", "off", "require"};
constexpr std::array<std::string_view, 2> kScheduleChoices{"follow", "grid"};
constexpr std::array<std::string_view, 2> kPhaseChoices{"free", "locked"};
constexpr std::array<std::string_view, 3> kActionChoices{"preset", "hold", "silence"};
constexpr std::array<std::string_view, 3> kChannelSources{"from", "mix", "fixed"};
constexpr std::array<std::string_view, 7> kShapingKeys{"reverse", "trim", "expo", "deadband",
                                                       "slew",    "min",  "max"};

constexpr Setting channel_number(bool required, std::string_view help) {
    return {.key = required ? "channel" : "from",
            .type = integer,
            .required = required,
            .least = 1,
            .most = kChannelCount,
            .help = help};
}

constexpr Setting pulse_key(std::string_view key, std::string_view help) {
    return {.key = key, .type = pulse, .least = kLeastPulse, .most = kMostPulse, .help = help};
}

constexpr Setting structure(std::string_view key, std::string_view help) {
    return {.key = key, .help = help};
}

constexpr std::array kRuntimeKeys{
    Key{{.key = "realtime",
         .type = choice,
         .fallback = "\"auto\"",
         .choices = kRealtimeChoices,
         .help = "auto: SCHED_FIFO and locked memory if permitted; off; require: refuse to run "
                 "without"}},
    Key{{.key = "priority",
         .type = integer,
         .fallback = "80",
         .least = 1,
         .most = 99,
         .help = "SCHED_FIFO priority of the data thread"}},
    Key{{.key = "cpu",
         .type = integer,
         .least = 0,
         .most = 1023,
         .help = "Processor that the data thread is pinned to; absent: no pinning"}},
    Key{{.key = "spin",
         .type = duration,
         .fallback = "\"0us\"",
         .least = 0,
         .most = 0.0002,
         .help = "So long before a deadline the data thread stays awake for it: less jitter of "
                 "`grid`, for that much CPU time a frame; 60us is plenty"}},
};

constexpr std::array kLossRuleKeys{
    Key{channel_number(true, "Channel to judge")},
    Key{pulse_key("below", "A lower value means loss, microseconds")},
    Key{pulse_key("above", "A higher value means loss, microseconds")},
};

constexpr Key kProtocolKey{{.key = "protocol", .required = true, .help = "What the wire speaks"},
                           KeyKind::protocol};
constexpr std::array<std::string_view, 2> kForeignSenderChoices{"failsafe", "ignore"};

constexpr Key kDeviceKey{{.key = "device",
                          .type = text,
                          .required = true,
                          .help = "Serial device, such as \"/dev/ttyAMA2\" or a stable name under "
                                  "/dev/serial/by-id"}};
constexpr Key kInterfaceKey{{.key = "interface",
                             .type = text,
                             .required = true,
                             .help = "CAN interface, such as \"can0\""}};
constexpr Key kForeignSenderKey{
    {.key = "foreign_sender",
     .type = choice,
     .fallback = "\"failsafe\"",
     .choices = kForeignSenderChoices,
     .help = "While another node sends frames with the ids of this output. failsafe: this output "
             "says failsafe; ignore: it only counts and logs them"}};

constexpr std::array kInputKeys{
    kProtocolKey,
    Key{{.key = "timeout",
         .type = duration,
         .fallback = "\"100ms\"",
         .least = 0.005,
         .most = 10,
         .help = "No good frame for so long: this input is lost"}},
    Key{structure("failsafe_when", "Values that mean loss although the receiver keeps sending"),
        KeyKind::list, kLossRuleKeys},
};

constexpr std::array kOutputKeys{
    kProtocolKey,
    Key{{.key = "period",
         .type = duration,
         .least = 0.0001,
         .most = 1,
         .help = "Least time between the starts of two frames; the default is the protocol's"}},
    Key{{.key = "force",
         .type = boolean,
         .fallback = "false",
         .help = "Allow a period below what readers of the protocol can follow"}},
    Key{{.key = "schedule",
         .type = choice,
         .fallback = "\"follow\"",
         .choices = kScheduleChoices,
         .help = "follow: send when a new frame arrives, at most once a period, and once a period "
                 "without one; grid: strictly periodic, whatever arrives"}},
    Key{{.key = "phase",
         .type = choice,
         .fallback = "\"free\"",
         .choices = kPhaseChoices,
         .help = "For schedule \"grid\". locked: the grid is steered to stand just behind the "
                 "input's arrival"}},
};

constexpr std::array kChannelKeys{
    Key{channel_number(false, "Input channel that this output channel carries")},
    Key{structure("mix", "Weighted sum of input channels, as deviations from 1500 microseconds"),
        KeyKind::weights},
    Key{pulse_key("fixed", "Always this pulse, microseconds")},
    Key{pulse_key("above", "A switch: 2000 while the input channel is higher, else 1000")},
    Key{pulse_key("below", "A switch: 2000 while the input channel is lower, else 1000")},
    Key{{.key = "reverse",
         .type = boolean,
         .fallback = "false",
         .help = "Mirror around 1500 microseconds"}},
    Key{{.key = "trim",
         .type = pulse,
         .fallback = "0",
         .least = -500,
         .most = 500,
         .help = "Added, microseconds"}},
    Key{{.key = "expo",
         .type = number,
         .fallback = "0",
         .least = 0,
         .most = 1,
         .help = "0: straight; 1: cubic, gentle around the centre"}},
    Key{{.key = "deadband",
         .type = pulse,
         .fallback = "0",
         .least = 0,
         .most = 200,
         .help = "This far around 1500 reads as 1500, microseconds; full travel is kept"}},
    Key{{.key = "slew",
         .type = slew,
         .least = 1,
         .most = 1e6,
         .help = "Fastest change, such as \"2000us/s\""}},
    Key{pulse_key("min", "Never lower, microseconds")},
    Key{pulse_key("max", "Never higher, microseconds")},
};

constexpr Key kHoldKey{{.key = "hold",
                        .type = duration,
                        .fallback = "\"300ms\"",
                        .least = 0,
                        .most = 10,
                        .help = "After the input is lost: last values, marked frame-lost, for so "
                                "long"}};
constexpr Key kActionKey{{.key = "action",
                          .type = choice,
                          .choices = kActionChoices,
                          .help = "After the hold time: preset values, the last values, or no "
                                  "frames. The default is preset where the protocol can say "
                                  "failsafe, else silence"}};
constexpr Key kPresetKey{structure("preset",
                                   "Pulses by channel number for the action \"preset\", "
                                   "microseconds; other: all that are not named (1500)"),
                         KeyKind::presets};
constexpr Key kRecoverKey{{.key = "recover",
                           .type = duration,
                           .fallback = "\"500ms\"",
                           .least = 0,
                           .most = 60,
                           .help = "An unbroken run of good frames this long before control "
                                   "returns"}};

constexpr std::array kOutputFailsafeKeys{kHoldKey, kActionKey, kPresetKey, kRecoverKey};

constexpr std::array kFailsafeKeys{
    kHoldKey,
    kActionKey,
    kPresetKey,
    kRecoverKey,
    Key{structure("output", "Outputs that differ, by name"), KeyKind::named_tables,
        kOutputFailsafeKeys},
};

constexpr std::array kPipelineKeys{
    Key{{.key = "from", .required = true, .help = "Inputs by name: the first healthy one is used"},
        KeyKind::names},
    Key{{.key = "to", .required = true, .help = "Outputs by name"}, KeyKind::names},
    Key{structure("channels",
                  "Output channel = input channel, or how it is made; those not named pass "
                  "unchanged"),
        KeyKind::channels, kChannelKeys},
    Key{structure("failsafe", "What the outputs do when no input is healthy"), KeyKind::table,
        kFailsafeKeys},
};

constexpr std::array kRootKeys{
    Key{structure("runtime", "The data thread"), KeyKind::table, kRuntimeKeys},
    Key{structure("input", "Where RC data comes from: [input.NAME]"), KeyKind::named_tables,
        kInputKeys, SettingScope::input},
    Key{structure("output", "Where RC data goes to: [output.NAME]"), KeyKind::named_tables,
        kOutputKeys, SettingScope::output},
    Key{structure("pipeline", "Which inputs feed which outputs, and how: [pipeline.NAME]"),
        KeyKind::named_tables, kPipelineKeys},
};

}  // namespace

std::span<const Key> root_keys() {
    return kRootKeys;
}
std::span<const Key> runtime_keys() {
    return kRuntimeKeys;
}
std::span<const Key> input_keys() {
    return kInputKeys;
}
std::span<const Key> output_keys() {
    return kOutputKeys;
}
std::span<const Key> loss_rule_keys() {
    return kLossRuleKeys;
}
std::span<const Key> pipeline_keys() {
    return kPipelineKeys;
}
std::span<const Key> channel_keys() {
    return kChannelKeys;
}
std::span<const Key> failsafe_keys() {
    return kFailsafeKeys;
}
std::span<const Key> output_failsafe_keys() {
    return kOutputFailsafeKeys;
}

const Key& key_named(std::span<const Key> keys, std::string_view name) {
    const auto key = std::find_if(keys.begin(), keys.end(),
                                  [name](const Key& row) { return row.name() == name; });
    assert(key != keys.end());
    return *key;
}

const Key& place_key(LinkKind link) {
    return link == LinkKind::can ? kInterfaceKey : kDeviceKey;
}

std::vector<Key> protocol_keys(const Protocol& protocol, SettingScope scope) {
    std::vector<Key> keys{place_key(protocol.link)};
    if (protocol.link == LinkKind::can && scope == SettingScope::output) {
        keys.push_back(kForeignSenderKey);
    }
    for (const Setting& setting : protocol.settings) {
        if (setting.scope == SettingScope::both || setting.scope == scope) {
            keys.push_back({setting});
        }
    }
    return keys;
}

std::span<const std::string_view> channel_source_names() {
    return kChannelSources;
}

std::span<const std::string_view> shaping_key_names() {
    return kShapingKeys;
}

}  // namespace tribus
