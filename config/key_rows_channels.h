#pragma once

#include <array>
#include <string_view>

#include "config/key_rows.h"

/// Rows about channels: rules on their values, and how they are made.
namespace tribus::key_rows {

using enum SettingType;

inline constexpr std::array<std::string_view, 4> kChannelSources{"from", "mix", "fixed", "line"};

inline constexpr std::array<std::string_view, 7> kShapingKeys{"reverse", "trim", "expo", "deadband",
                                                              "slew",    "min",  "max"};

inline constexpr std::array kLossRuleKeys{
    Key{channel_number("channel", "Channel to judge, as the receiver numbers it")},
    Key{pulse_key("below", "A lower value means loss, microseconds")},
    Key{pulse_key("above", "A higher value means loss, microseconds")},
    Key{pulses_key("between", "A value in this range, ends included, means loss, microseconds")},
    Key{{.key = "all_zero",
         .type = boolean,
         .fallback = "false",
         .help = "Instead of a channel: all channels at the wire's own zero mean loss"}},
};

inline constexpr std::array kReleaseRuleKeys{
    Key{channel_number("channel", "Channel of the output")},
    Key{pulse_key("below", "Released by a lower value, microseconds")},
    Key{pulse_key("above", "Released by a higher value, microseconds")},
    Key{pulses_key("between", "Released by a value in this range, ends included, microseconds")},
};

inline constexpr std::array kChannelKeys{
    Key{channel_number("from", "Input channel that this output channel carries")},
    Key{structure("mix", "Weighted sum of input channels, as deviations from 1500 microseconds"),
        KeyKind::weights},
    Key{pulse_key("fixed", "Always this pulse, microseconds")},
    Key{{.key = "line",
         .type = text,
         .help = "A GPIO line with role \"button\": 2000 while it is active, else 1000"}},
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

}  // namespace tribus::key_rows
