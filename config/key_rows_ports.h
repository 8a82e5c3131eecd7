#pragma once

#include <array>
#include <string_view>

#include "config/key_rows_channels.h"

/// Rows of inputs and outputs.
namespace tribus::key_rows {

using enum SettingType;

inline constexpr std::array<std::string_view, 2> kScheduleChoices{"follow", "grid"};

inline constexpr std::array<std::string_view, 2> kPhaseChoices{"free", "locked"};

inline constexpr Key kProtocolKey{
    {.key = "protocol", .required = true, .help = "What the wire speaks"}, KeyKind::protocol};
inline constexpr std::array<std::string_view, 2> kForeignSenderChoices{"failsafe", "ignore"};

inline constexpr Key kDeviceKey{
    {.key = "device",
     .type = text,
     .required = true,
     .help = "Serial device, such as \"/dev/ttyAMA2\" or a stable name under "
             "/dev/serial/by-id"}};
inline constexpr Key kInterfaceKey{{.key = "interface",
                                    .type = text,
                                    .required = true,
                                    .help = "CAN interface, such as \"can0\""}};
inline constexpr Key kForeignSenderKey{
    {.key = "foreign_sender",
     .type = choice,
     .fallback = "\"failsafe\"",
     .choices = kForeignSenderChoices,
     .help = "While another node sends frames with the ids of this output. failsafe: this output "
             "says failsafe; ignore: it only counts and logs them"}};

inline constexpr std::array kOutputKeys{
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

inline constexpr std::array kInputKeys{
    kProtocolKey,
    Key{{.key = "timeout",
         .type = duration,
         .fallback = "\"100ms\"",
         .least = 0.005,
         .most = 10,
         .help = "No good frame for so long: this input is lost"}},
    Key{{.key = "failsafe_flag",
         .type = boolean,
         .fallback = "true",
         .help = "The sender's failsafe flag means loss; false: it is not believed"}},
    Key{{.key = "frame_lost_flag",
         .type = boolean,
         .fallback = "true",
         .help = "A frame that the sender marks frame-lost has old values; false: it is not "
                 "believed"}},
    Key{{.key = "frame_lost_run",
         .type = duration,
         .least = 0.005,
         .most = 10,
         .help = "Nothing but frames marked frame-lost for so long means loss; the default is "
                 "the timeout"}},
    Key{{.key = "frame_lost_ratio",
         .type = number,
         .fallback = "0.9",
         .least = 0.01,
         .most = 1,
         .help = "A larger share of frames marked frame-lost among the latest hundred means "
                 "loss; 1: never"}},
    Key{structure("failsafe_when", "Values that mean loss although the receiver keeps sending"),
        KeyKind::list, kLossRuleKeys},
    Key{{.key = "frozen",
         .type = duration,
         .fallback = "\"0s\"",
         .least = 0,
         .most = 3600,
         .help = "No change of any bit of a channel for so long means loss, on a link whose values "
                 "are never "
                 "quite still; 0s: never"}},
    Key{pulses_key("plausible",
                   "A frame with a channel outside of this range does not count, microseconds; "
                   "[0, 4095]: any value counts",
                   "[800, 2200]")},
    Key{{.key = "zero_guard",
         .type = duration,
         .fallback = "\"1s\"",
         .least = 0,
         .most = 10,
         .help = "For so long after the start and after a loss, a frame with a channel at the "
                 "wire's own zero does not count; 0s: it does"}},
    Key{structure("map",
                  "How this receiver's channels become the input's: channel = channel, or how it "
                  "is made; those not named pass unchanged"),
        KeyKind::channels, kChannelKeys},
};

}  // namespace tribus::key_rows
