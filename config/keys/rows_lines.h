#pragma once

#include <array>
#include <chrono>
#include <string_view>

#include "config/keys/rows_channels.h"

/// Rows of GPIO lines.
namespace tribus::key_rows {

using enum SettingType;

inline constexpr std::array kLineKeys{
    row<&LineConfig::place, &GpioPlace::chip>(
        {.key = "chip",
         .absent = "the chip that has a line of that name",
         .help = "GPIO chip of the line. Required if `line` is a number",
         .example = "\"gpiochip0\""}),
    Key{{.key = "line",
         .required = true,
         .help = "The line: its name, or its number on the chip",
         .example = "\"GPIO17\""},
        KeyKind::line},
    row<&LineConfig::task, &LineTask::role>(
        {.key = "role",
         .required = true,
         .help = "What the line does. `link`: a lamp, on under control, blinking while values "
                 "are held, off in failsafe; `failsafe`: on in failsafe; `fresh`: a square wave "
                 "that only fresh frames, sent on time, make; `force_failsafe`: an input that "
                 "forces failsafe while it is active; `select`: an input that selects `input` "
                 "while it is active; `inverter`: on from start to end; `button`: an input that "
                 "channels are made of; `switch`: on while a channel of `output` is in a range",
         .example = "\"link\""}),
    row<&LineConfig::active_low>({.key = "active_low",
                                  .help = "`true`: the low level is the active one",
                                  .example = "true"}),
    row<&LineConfig::bias>(
        {.key = "bias",
         .help = "Roles that are inputs: what holds the level while nothing drives the line",
         .example = "\"pull_up\""}),
    row<&LineConfig::task, &LineTask::debounce>(
        {.key = "debounce",
         .least = 0,
         .most = 1,
         .help = "Roles that are inputs: a level counts once it has been steady for this long",
         .example = "\"50ms\""}),
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
    row<&LineConfig::task, &LineTask::period>(
        {.key = "period",
         .least = 0.002,
         .most = std::chrono::duration<double>(kMostWavePeriod).count(),
         .help = "Role `fresh`: period of the wave. At least twice the `period` of its outputs, "
                 "best four times",
         .example = "\"60ms\""}),
    channel_row<&LineConfig::task, &LineTask::rule, &ValueRule::channel>(
        channel_number("channel", "Role `switch`: channel of the output", "9")),
    row<&LineConfig::task, &LineTask::rule, &ValueRule::below>(
        pulse_key("below", "Role `switch`: on while the channel is below this value", "1300")),
    row<&LineConfig::task, &LineTask::rule, &ValueRule::above>(
        pulse_key("above", "Role `switch`: on while the channel is above this value", "1700")),
    row<&LineConfig::task, &LineTask::rule, &ValueRule::between>(
        pulses_key("between", "Role `switch`: on while the channel is in this range, ends included",
                   "[1400, 1600]")),
};

}  // namespace tribus::key_rows
