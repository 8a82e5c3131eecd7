#pragma once

#include <array>
#include <string_view>

#include "config/keys/rows_channels.h"

/// Rows of GPIO lines.
namespace tribus::key_rows {

using enum SettingType;

/// In the order of `LineRole`.
inline constexpr std::array<std::string_view, 8> kRoleChoices{
    "link", "failsafe", "fresh", "force_failsafe", "select", "inverter", "button", "switch"};

/// In the order of `GpioBias`.
inline constexpr std::array<std::string_view, 4> kBiasChoices{"as_is", "pull_up", "pull_down",
                                                              "none"};

inline constexpr std::array kLineKeys{
    Key{{.key = "chip",
         .type = text,
         .absent = "the chip that has a line of that name",
         .help = "GPIO chip of the line. Required if `line` is a number",
         .example = "\"gpiochip0\""}},
    Key{{.key = "line",
         .required = true,
         .help = "The line: its name, or its number on the chip",
         .example = "\"GPIO17\""},
        KeyKind::line},
    Key{{.key = "role",
         .type = choice,
         .required = true,
         .choices = kRoleChoices,
         .help = "What the line does. `link`: a lamp, on under control, blinking while values "
                 "are held, off in failsafe; `failsafe`: on in failsafe; `fresh`: a square wave "
                 "that only fresh frames, sent on time, make; `force_failsafe`: an input that "
                 "forces failsafe while it is active; `select`: an input that selects `input` "
                 "while it is active; `inverter`: on from start to end; `button`: an input that "
                 "channels are made of; `switch`: on while a channel of `output` is in a range",
         .example = "\"link\""}},
    Key{{.key = "active_low",
         .type = boolean,
         .fallback = "false",
         .help = "`true`: the low level is the active one",
         .example = "true"}},
    Key{{.key = "bias",
         .type = choice,
         .fallback = "\"as_is\"",
         .choices = kBiasChoices,
         .help = "Roles that are inputs: what holds the level while nothing drives the line",
         .example = "\"pull_up\""}},
    Key{{.key = "debounce",
         .type = duration,
         .fallback = "\"20ms\"",
         .least = 0,
         .most = 1,
         .help = "Roles that are inputs: a level counts once it has been steady for this long",
         .example = "\"50ms\""}},
    Key{{.key = "output",
         .type = text,
         .absent = "all outputs; `switch` requires it",
         .help = "Roles `link`, `failsafe`, `fresh`, `force_failsafe`, `switch`: name of the "
                 "output that the line belongs to",
         .example = "\"servos\""}},
    Key{{.key = "input",
         .type = text,
         .absent = "none; `select` requires it",
         .help = "Role `select`: name of the input that the line selects",
         .example = "\"backup\""}},
    Key{{.key = "period",
         .type = duration,
         .fallback = "\"40ms\"",
         .least = 0.002,
         .most = 2,
         .help = "Role `fresh`: period of the wave. At least twice the `period` of its outputs, "
                 "best four times",
         .example = "\"60ms\""}},
    Key{channel_number("channel", "Role `switch`: channel of the output", "9")},
    Key{pulse_key("below", "Role `switch`: on while the channel is below this value", "1300")},
    Key{pulse_key("above", "Role `switch`: on while the channel is above this value", "1700")},
    Key{pulses_key("between", "Role `switch`: on while the channel is in this range, ends included",
                   "[1400, 1600]")},
};

}  // namespace tribus::key_rows
