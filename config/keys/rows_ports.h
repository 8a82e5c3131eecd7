#pragma once

#include <array>
#include <string_view>

#include "config/keys/rows_channels.h"
#include "transports/links/can/can_medium.h"
#include "transports/links/serial/serial_medium.h"

/// Rows of inputs and outputs.
namespace tribus::key_rows {

using enum SettingType;

inline constexpr Key kProtocolKey{
    {.key = "protocol", .required = true, .help = "Protocol on the wire", .example = "\"sbus\""},
    KeyKind::protocol};
inline constexpr Key kDeviceKey = row<&PortConfig::device>(kDeviceSetting);
inline constexpr Key kInterfaceKey = row<&PortConfig::device>(kInterfaceSetting);
inline constexpr Key kForeignSenderKey = row<&OutputConfig::foreign_sender>(
    {.key = "foreign_sender",
     .help = "Outputs on CAN: what happens while another node sends frames with the ids of this "
             "output. `failsafe`: the output says failsafe; `ignore`: the frames are only "
             "counted and logged",
     .example = "\"ignore\""});

inline constexpr std::array kOutputKeys{
    kProtocolKey,
    row<&OutputConfig::schedule, &ScheduleSettings::period>(
        {.key = "period",
         .absent = "the default of the protocol",
         .least = 0.0001,
         .most = 1,
         .help = "Least time between the starts of two frames. Behind a late frame one may come "
                 "sooner (channels.md, \"When an output sends\")",
         .example = "\"10ms\""}),
    row<&OutputConfig::force>(
        {.key = "force",
         .help = "`true`: allows a `period` shorter than readers of the protocol can follow, and a "
                 "`hold` over 300 ms where held values are not marked",
         .example = "true"}),
    row<&OutputConfig::schedule, &ScheduleSettings::kind>(
        {.key = "schedule",
         .help =
             "When frames are sent. `follow`: when a new frame arrives, over any time at most "
             "once a `period`, and once a `period` while none arrives; `grid`: by its own clock, "
             "whatever arrives",
         .example = "\"grid\""}),
    row<&OutputConfig::schedule, &ScheduleSettings::phase>(
        {.key = "phase",
         .help =
             "With `schedule = \"grid\"`. `free`: exactly once a `period`; `locked`: just after "
             "a frame of the input, so that values are fresh: each one, or each second or third "
             "if a `period` is longer than the input's",
         .example = "\"locked\""}),
};

inline constexpr std::array kInputKeys{
    kProtocolKey,
    row<&SupervisionSettings::timeout>(
        {.key = "timeout",
         .least = 0.005,
         .most = 10,
         .help = "The input is lost when no good frame has come for this long. Must be longer "
                 "than the `period` of every output that the input feeds. With `dbc` the default "
                 "is three cycles of the messages, if that is longer than 100 ms",
         .example = "\"250ms\""}),
    row<&SupervisionSettings::failsafe_flag>(
        {.key = "failsafe_flag",
         .help = "`true`: the sender's failsafe flag means that the link is lost; `false`: the "
                 "flag is ignored. Not with `ibus`, which has no flags",
         .example = "false"}),
    row<&SupervisionSettings::frame_lost_flag>(
        {.key = "frame_lost_flag",
         .help = "`true`: a frame that the sender marks frame-lost has old values; `false`: the "
                 "mark is ignored. Not with `ibus`",
         .example = "false"}),
    row<&SupervisionSettings::frame_lost_run>(
        {.key = "frame_lost_run",
         .absent = "as `timeout`",
         .least = 0.005,
         .most = 10,
         .help = "The input is lost when all frames for this long were marked frame-lost. Not "
                 "with `ibus`",
         .example = "\"500ms\""}),
    row<&SupervisionSettings::frame_lost_ratio>(
        {.key = "frame_lost_ratio",
         .type = number,
         .least = 0.01,
         .most = 1,
         .help = "The input is lost when more than this share of the latest hundred frames is "
                 "marked frame-lost; `1`: never. Not with `ibus`",
         .example = "0.5"}),
    Key{structure("failsafe_when",
                  "Rules for channel values that mean that the link is lost although the receiver "
                  "goes on sending",
                  "[{ channel = 3, below = 950 }]", "no rules"),
        KeyKind::list, kLossRuleKeys},
    row<&SupervisionSettings::frozen>(
        {.key = "frozen",
         .least = 0,
         .most = 3600,
         .help = "The input is lost when no bit of any channel has changed for this long; "
                 "`\"0s\"`: never. Only for a link whose values always tremble a little: sticks "
                 "that lie still are normal",
         .example = "\"2s\""}),
    row<&SupervisionSettings::plausible>(
        pulses_key("plausible",
                   "A frame with a channel outside of this range does not count; `[0, 4095]`: any "
                   "value counts",
                   "[850, 2150]", "[800, 2200]")),
    row<&SupervisionSettings::zero_guard>(
        {.key = "zero_guard",
         .least = 0,
         .most = 10,
         .help = "For this long after the start and after a loss, a frame with a channel at raw "
                 "zero does not count; `\"0s\"`: it counts. Only with `sbus`",
         .example = "\"0s\""}),
    Key{structure("map",
                  "Makes the channels of the input from those that this receiver sends, as "
                  "`channels` of a pipeline does. Channels that are not named pass unchanged",
                  "{ 5 = 6, 6 = 5 }", "all channels pass unchanged"),
        KeyKind::channels, kChannelKeys},
};

}  // namespace tribus::key_rows
