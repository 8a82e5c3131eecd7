#pragma once

#include <array>
#include <string_view>

#include "config/key_rows_channels.h"

/// Rows of pipelines and of what they do without an input.
namespace tribus::key_rows {

using enum SettingType;

inline constexpr std::array<std::string_view, 4> kModeChoices{"priority", "sticky", "freshest",
                                                              "median"};

inline constexpr std::array<std::string_view, 3> kActionChoices{"preset", "hold", "silence"};

inline constexpr std::array kHandoverKeys{
    Key{{.key = "input", .type = text, .required = true, .help = "The input with the channel"}},
    Key{{.key = "channel",
         .type = integer,
         .required = true,
         .least = 1,
         .most = kChannelCount,
         .help = "Its travel from 1000 to 2000 us is divided evenly among the inputs of the "
                 "pipeline, in their order; of a median, the lowest part leaves it to the vote"}},
};

inline constexpr Key kHoldKey{
    {.key = "hold",
     .type = duration,
     .fallback = "\"300ms\"",
     .least = 0,
     .most = 10,
     .help = "After the input is lost: last values, marked frame-lost, for so "
             "long"}};
inline constexpr Key kActionKey{{.key = "action",
                                 .type = choice,
                                 .choices = kActionChoices,
                                 .help =
                                     "After the hold time: preset values, the last values, or no "
                                     "frames. The default is preset where the protocol can say "
                                     "failsafe, else silence"}};
inline constexpr Key kPresetKey{structure("preset",
                                          "Pulses by channel number for the action \"preset\", and "
                                          "for channels that the input does not have, "
                                          "microseconds; other: all that are not named (1500)"),
                                KeyKind::presets};
inline constexpr Key kFailsafeSlewKey{{.key = "slew",
                                       .type = slew,
                                       .least = 1,
                                       .most = 1e6,
                                       .help =
                                           "Fastest change of a channel into the presets, and from "
                                           "them back, such as \"1000us/s\"; absent: at once"}};
inline constexpr Key kRecoverKey{{.key = "recover",
                                  .type = duration,
                                  .fallback = "\"500ms\"",
                                  .least = 0,
                                  .most = 60,
                                  .help = "An unbroken run of good frames this long before control "
                                          "returns"}};

inline constexpr Key kPowerOnKey{{.key = "power_on",
                                  .type = duration,
                                  .least = 0,
                                  .most = 60,
                                  .help =
                                      "An unbroken run of good frames this long before control is "
                                      "given for the first time; absent: as long as `recover`"}};
inline constexpr Key kReleaseKey{
    structure("release_when",
              "After failsafe, and at the start, control waits for this "
              "value of an output channel: a low throttle"),
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
    Key{structure("output", "Outputs that differ, by name"), KeyKind::named_tables,
        kOutputFailsafeKeys},
};

inline constexpr std::array kPipelineKeys{
    Key{{.key = "from", .required = true, .help = "Inputs by name, the preferred first"},
        KeyKind::names},
    Key{{.key = "to", .required = true, .help = "Outputs by name"}, KeyKind::names},
    Key{{.key = "mode",
         .type = choice,
         .fallback = "\"priority\"",
         .choices = kModeChoices,
         .help = "Which of several inputs counts. priority: the first healthy one, which returns "
                 "after `recover`; sticky: the one in control until it fails; freshest: for each "
                 "frame the youngest values; median: of three or more, channel by channel"}},
    Key{{.key = "tolerance",
         .type = pulse,
         .fallback = "50",
         .least = 1,
         .most = 1000,
         .help = "For mode \"median\": an input that differs by more is outvoted, microseconds"}},
    Key{structure("handover", "A channel by which a person picks the input"), KeyKind::table,
        kHandoverKeys},
    Key{{.key = "changeover",
         .type = slew,
         .least = 1,
         .most = 1e6,
         .help = "Fastest change of a channel while control passes from one input to another, "
                 "such as \"2000us/s\"; absent: at once"}},
    Key{structure("channels",
                  "Output channel = input channel, or how it is made; those not named pass "
                  "unchanged"),
        KeyKind::channels, kChannelKeys},
    Key{structure("failsafe", "What the outputs do when no input is healthy"), KeyKind::table,
        kFailsafeKeys},
};

}  // namespace tribus::key_rows
