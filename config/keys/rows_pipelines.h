#pragma once

#include <array>
#include <string_view>

#include "config/keys/rows_channels.h"

/// Rows of pipelines and of what they do without an input.
namespace tribus::key_rows {

using enum SettingType;

inline constexpr std::array kHandoverKeys{
    Key{{.key = "input",
         .type = text,
         .required = true,
         .help = "Name of the input that has the channel",
         .example = "\"main\""}},
    channel_row<&HandoverSettings::channel>(
        {.key = "channel",
         .required = true,
         .least = 1,
         .most = kChannelCount,
         .help = "The channel that selects. Its travel from 1000 to 2000 us is divided evenly "
                 "among the inputs of the pipeline, in their order. With `mode = \"median\"` "
                 "the lowest part leaves it to the vote",
         .example = "8"}),
};

inline constexpr Key kHoldKey = row<&FailsafeSettings::hold>(
    {.key = "hold",
     .least = 0,
     .most = 10,
     .help = "For this long after the input is lost, the last values are sent, marked "
             "frame-lost where the protocol can. `\"0s\"`: failsafe at once",
     .example = "\"0s\""});
inline constexpr Key kActionKey = row<&FailsafeSettings::action>(
    {.key = "action",
     .absent = "`\"preset\"` where the protocol can say failsafe, else `\"silence\"`",
     .help = "What is sent in failsafe, after `hold`. `preset`: the pulses of `preset`; `hold`: "
             "the last values, marked failsafe, only where the protocol can say failsafe; "
             "`silence`: no frames",
     .example = "\"silence\""});
inline constexpr Key kPresetKey{
    structure("preset",
              "Pulses in failsafe with the action `preset`, by output channel; also for channels "
              "that the input does not have. `other`: all channels that are not named, 1500 us if "
              "it is left out",
              "{ 3 = 1000, other = 1500 }", "`{ 3 = 988, other = 1500 }`"),
    KeyKind::presets};
inline constexpr Key kFailsafeSlewKey = row<&FailsafeSettings::slew_us_per_second>(
    {.key = "slew",
     .type = slew,
     .absent = "no limit",
     .least = 1,
     .most = 1e6,
     .help = "Fastest change of a channel into the presets, and back from them",
     .example = "\"1000us/s\""});
inline constexpr Key kRecoverKey = row<&FailsafeSettings::recover>(
    {.key = "recover",
     .least = 0,
     .most = 60,
     .help = "Control returns after good frames without a break for this long",
     .example = "\"1s\""});

inline constexpr Key kPowerOnKey = row<&FailsafeSettings::power_on>(
    {.key = "power_on",
     .absent = "as `recover`",
     .least = 0,
     .most = 60,
     .help = "Control is given for the first time after good frames without a break for this "
             "long",
     .example = "\"2s\""});
inline constexpr Key kReleaseKey{
    structure("release_when",
              "After failsafe and at the start, control also waits until an output channel has "
              "this value, such as a low throttle",
              "{ channel = 3, below = 1050 }", "control does not wait"),
    KeyKind::table, kReleaseRuleKeys};

inline constexpr std::array kOutputFailsafeKeys{
    kHoldKey, kActionKey, kPresetKey, kFailsafeSlewKey, kRecoverKey, kPowerOnKey, kReleaseKey};

inline constexpr std::array kFailsafeKeys{
    kHoldKey,
    kActionKey,
    kPresetKey,
    kFailsafeSlewKey,
    kRecoverKey,
    kPowerOnKey,
    kReleaseKey,
    Key{structure("output",
                  "The same keys for outputs that differ, in a table for each: "
                  "`[pipeline.NAME.failsafe.output.NAME]`",
                  "{ bus = { action = \"silence\" } }", "all outputs are alike"),
        KeyKind::named_tables, kOutputFailsafeKeys},
};

inline constexpr std::array kPipelineKeys{
    Key{{.key = "from",
         .required = true,
         .help = "Inputs by name, the preferred one first",
         .example = "[\"main\", \"backup\"]"},
        KeyKind::names},
    Key{{.key = "to", .required = true, .help = "Outputs by name", .example = "\"servos\""},
        KeyKind::names},
    row<&SelectionSettings::mode>(
        {.key = "mode",
         .help = "Which of several inputs has control. `priority`: the first healthy one, which "
                 "takes control back after `recover`; `sticky`: the one in control until it "
                 "fails; `freshest`: for each frame the one with the youngest values; `median`: "
                 "of three or more, the middle value of each channel",
         .example = "\"sticky\""}),
    row<&SelectionSettings::tolerance>(
        {.key = "tolerance",
         .least = 1,
         .most = 1000,
         .help = "With `mode = \"median\"`: an input that differs by more than this is outvoted",
         .example = "30"}),
    Key{structure("handover", "A channel by which a person selects the input",
                  "{ input = \"main\", channel = 8 }", "`mode` decides alone"),
        KeyKind::table, kHandoverKeys},
    row<&SelectionSettings::changeover_us_per_second>(
        {.key = "changeover",
         .type = slew,
         .absent = "no limit",
         .least = 1,
         .most = 1e6,
         .help = "Fastest change of a channel while control passes from one input to another. "
                 "Not with `mode = \"freshest\"`",
         .example = "\"2000us/s\""}),
    Key{structure("channels",
                  "The map: output channel = input channel, or a table that says how it is made. "
                  "Channels that are not named pass unchanged",
                  "{ 1 = 2, 2 = { from = 1, reverse = true } }", "all channels pass unchanged"),
        KeyKind::channels, kChannelKeys},
    Key{structure("failsafe", "What the outputs do while no input is healthy",
                  "{ hold = \"100ms\" }", "the defaults of its keys"),
        KeyKind::table, kFailsafeKeys},
};

}  // namespace tribus::key_rows
