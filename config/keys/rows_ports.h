#pragma once

#include <array>
#include <string_view>

#include "config/keys/rows_channels.h"

/// Rows of inputs and outputs.
namespace tribus::key_rows {

using enum SettingType;

inline constexpr std::array<std::string_view, 2> kScheduleChoices{"follow", "grid"};

inline constexpr std::array<std::string_view, 2> kPhaseChoices{"free", "locked"};

inline constexpr Key kProtocolKey{
    {.key = "protocol", .required = true, .help = "Protocol on the wire", .example = "\"sbus\""},
    KeyKind::protocol};
inline constexpr std::array<std::string_view, 2> kForeignSenderChoices{"failsafe", "ignore"};

inline constexpr Key kDeviceKey{
    {.key = "device",
     .type = text,
     .required = true,
     .help = "Serial device, such as \"/dev/ttyAMA2\" or a stable name under /dev/serial/by-id",
     .example = "\"/dev/ttyAMA2\""}};
inline constexpr Key kInterfaceKey{{.key = "interface",
                                    .type = text,
                                    .required = true,
                                    .help = "CAN interface, such as \"can0\"",
                                    .example = "\"can0\""}};
inline constexpr Key kForeignSenderKey{
    {.key = "foreign_sender",
     .type = choice,
     .fallback = "\"failsafe\"",
     .choices = kForeignSenderChoices,
     .help = "Outputs on CAN: what happens while another node sends frames with the ids of this "
             "output. `failsafe`: the output says failsafe; `ignore`: the frames are only "
             "counted and logged",
     .example = "\"ignore\""}};

inline constexpr std::array kOutputKeys{
    kProtocolKey,
    Key{{.key = "period",
         .type = duration,
         .absent = "the default of the protocol",
         .least = 0.0001,
         .most = 1,
         .help = "Least time between the starts of two frames",
         .example = "\"10ms\""}},
    Key{{.key = "force",
         .type = boolean,
         .fallback = "false",
         .help = "`true`: allows a `period` shorter than readers of the protocol can follow",
         .example = "true"}},
    Key{{.key = "schedule",
         .type = choice,
         .fallback = "\"follow\"",
         .choices = kScheduleChoices,
         .help = "When frames are sent. `follow`: when a new frame arrives, at most once a "
                 "`period`, and once a `period` while none arrives; `grid`: exactly once a "
                 "`period`, whatever arrives",
         .example = "\"grid\""}},
    Key{{.key = "phase",
         .type = choice,
         .fallback = "\"free\"",
         .choices = kPhaseChoices,
         .help = "With `schedule = \"grid\"`. `locked`: frames are sent just after those of the "
                 "input arrive, so that values are fresh; `free`: the grid does not follow the "
                 "input",
         .example = "\"locked\""}},
};

inline constexpr std::array kInputKeys{
    kProtocolKey,
    Key{{.key = "timeout",
         .type = duration,
         .fallback = "\"100ms\"",
         .least = 0.005,
         .most = 10,
         .help = "The input is lost when no good frame has come for this long. Must be longer "
                 "than the `period` of every output that the input feeds",
         .example = "\"250ms\""}},
    Key{{.key = "failsafe_flag",
         .type = boolean,
         .fallback = "true",
         .help = "`true`: the sender's failsafe flag means that the link is lost; `false`: the "
                 "flag is ignored. Not with `ibus`, which has no flags",
         .example = "false"}},
    Key{{.key = "frame_lost_flag",
         .type = boolean,
         .fallback = "true",
         .help = "`true`: a frame that the sender marks frame-lost has old values; `false`: the "
                 "mark is ignored. Not with `ibus`",
         .example = "false"}},
    Key{{.key = "frame_lost_run",
         .type = duration,
         .absent = "as `timeout`",
         .least = 0.005,
         .most = 10,
         .help = "The input is lost when all frames for this long were marked frame-lost. Not "
                 "with `ibus`",
         .example = "\"500ms\""}},
    Key{{.key = "frame_lost_ratio",
         .type = number,
         .fallback = "0.9",
         .least = 0.01,
         .most = 1,
         .help = "The input is lost when more than this share of the latest hundred frames is "
                 "marked frame-lost; `1`: never. Not with `ibus`",
         .example = "0.5"}},
    Key{structure("failsafe_when",
                  "Rules for channel values that mean that the link is lost although the receiver "
                  "goes on sending",
                  "[{ channel = 3, below = 950 }]", "no rules"),
        KeyKind::list, kLossRuleKeys},
    Key{{.key = "frozen",
         .type = duration,
         .fallback = "\"0s\"",
         .least = 0,
         .most = 3600,
         .help = "The input is lost when no bit of any channel has changed for this long; "
                 "`\"0s\"`: never. Only for a link whose values always tremble a little: sticks "
                 "that lie still are normal",
         .example = "\"2s\""}},
    Key{pulses_key("plausible",
                   "A frame with a channel outside of this range does not count; `[0, 4095]`: any "
                   "value counts",
                   "[850, 2150]", "[800, 2200]")},
    Key{{.key = "zero_guard",
         .type = duration,
         .fallback = "\"1s\"",
         .least = 0,
         .most = 10,
         .help = "For this long after the start and after a loss, a frame with a channel at raw "
                 "zero does not count; `\"0s\"`: it counts. Only with `sbus`",
         .example = "\"0s\""}},
    Key{structure("map",
                  "Makes the channels of the input from those that this receiver sends, as "
                  "`channels` of a pipeline does. Channels that are not named pass unchanged",
                  "{ 5 = 6, 6 = 5 }", "all channels pass unchanged"),
        KeyKind::channels, kChannelKeys},
};

}  // namespace tribus::key_rows
