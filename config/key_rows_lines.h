#pragma once

#include <array>
#include <string_view>

#include "config/key_rows_channels.h"

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
         .help = "GPIO chip, such as \"gpiochip0\"; absent: `line` is a name on any chip"}},
    Key{{.key = "line",
         .required = true,
         .help = "The line: its number on the chip, or its name, such as \"GPIO17\""},
        KeyKind::line},
    Key{{.key = "role",
         .type = choice,
         .required = true,
         .choices = kRoleChoices,
         .help = "What it is for. link: on under control, blinks while values are held, off in "
                 "failsafe; failsafe: on in failsafe; fresh: a square wave that only fresh data "
                 "on time makes; force_failsafe: an input that forces failsafe; select: an input "
                 "that picks `input`; inverter: on from start to end; button: an input that "
                 "channels are made from; switch: on while a channel of `output` is in a range"}},
    Key{{.key = "active_low",
         .type = boolean,
         .fallback = "false",
         .help = "The low level is the active one"}},
    Key{{.key = "bias",
         .type = choice,
         .fallback = "\"as_is\"",
         .choices = kBiasChoices,
         .help = "Of an input: what holds its level while nothing drives it"}},
    Key{{.key = "debounce",
         .type = duration,
         .fallback = "\"20ms\"",
         .least = 0,
         .most = 1,
         .help = "Of an input: a level counts once it has stood still for so long"}},
    Key{{.key = "output",
         .type = text,
         .help = "The output that the line is about; absent: all of them"}},
    Key{{.key = "input", .type = text, .help = "For role \"select\": the input that it picks"}},
    Key{{.key = "period",
         .type = duration,
         .fallback = "\"40ms\"",
         .least = 0.002,
         .most = 2,
         .help = "Of the wave of role \"fresh\": at least twice the period of the outputs"}},
    Key{channel_number("channel", "For role \"switch\": channel of the output")},
    Key{pulse_key("below", "For role \"switch\": on at a lower value, microseconds")},
    Key{pulse_key("above", "For role \"switch\": on at a higher value, microseconds")},
    Key{pulses_key("between",
                   "For role \"switch\": on in this range, ends included, microseconds")},
};

}  // namespace tribus::key_rows
