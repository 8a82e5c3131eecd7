#pragma once

#include <array>
#include <string_view>

#include "config/keys/rows.h"

/// Rows about channels: rules on their values, and how they are made.
namespace tribus::key_rows {

using enum SettingType;

inline constexpr std::array<std::string_view, 4> kChannelSources{"from", "mix", "fixed", "line"};

inline constexpr std::array<std::string_view, 7> kShapingKeys{"reverse", "trim", "expo", "deadband",
                                                              "slew",    "min",  "max"};

inline constexpr std::array kLossRuleKeys{
    channel_row<&ValueRule::channel>(
        channel_number("channel", "Channel to judge, as the receiver numbers it", "3")),
    row<&ValueRule::below>(
        pulse_key("below", "The link is lost while the channel is below this value", "950")),
    row<&ValueRule::above>(
        pulse_key("above", "The link is lost while the channel is above this value", "2050")),
    row<&ValueRule::between>(
        pulses_key("between", "The link is lost while the channel is in this range, ends included",
                   "[985, 995]")),
    row<&ValueRule::all_zero>(
        {.key = "all_zero",
         .help = "`true`: the link is lost while all channels are at raw zero, which receivers "
                 "send for \"no value\". Stands alone in its rule; only with `sbus`",
         .example = "true"}),
};

inline constexpr std::array kReleaseRuleKeys{
    channel_row<&ValueRule::channel>(channel_number("channel", "Channel of the output", "3")),
    row<&ValueRule::below>(
        pulse_key("below", "Control is released by a value below this one", "1050")),
    row<&ValueRule::above>(
        pulse_key("above", "Control is released by a value above this one", "1950")),
    row<&ValueRule::between>(pulses_key(
        "between", "Control is released by a value in this range, ends included", "[1480, 1520]")),
};

inline constexpr std::array kChannelKeys{
    Key{channel_number("from", "Input channel that the output channel is made of", "2")},
    Key{structure("mix",
                  "Weighted sum of input channels: 1500 us plus, for each channel, its deviation "
                  "from 1500 us times its weight",
                  "{ 1 = 0.5, 2 = -0.5 }"),
        KeyKind::weights},
    Key{pulse_key("fixed", "Constant pulse", "1500")},
    Key{{.key = "line",
         .type = text,
         .help = "Name of a GPIO line with the role `button`: 2000 us while the line is active, "
                 "else 1000 us. Not in `map` of an input",
         .example = "\"record\""}},
    Key{pulse_key("above",
                  "Makes a switch of `from`: 2000 us while the input channel is above this value, "
                  "else 1000 us. With `below` too, it is on outside of both limits",
                  "1700")},
    Key{pulse_key("below",
                  "Makes a switch of `from`: 2000 us while the input channel is below this value, "
                  "else 1000 us",
                  "1300")},
    row<&ChannelRule::reverse>(
        {.key = "reverse", .help = "`true`: mirrors the channel at 1500 us", .example = "true"}),
    row<&ChannelRule::trim>({.key = "trim",
                             .least = -500,
                             .most = 500,
                             .help = "Is added to the channel, after `reverse`",
                             .example = "-12"}),
    row<&ChannelRule::expo>(
        {.key = "expo",
         .type = number,
         .least = 0,
         .most = 1,
         .help = "Curve of the channel. 0: straight; 1: cubic, gentle around the centre. The "
                 "centre and both ends stay where they are",
         .example = "0.3"}),
    row<&ChannelRule::deadband>(
        {.key = "deadband",
         .least = 0,
         .most = 200,
         .help = "Values that differ from 1500 us by no more than this become 1500 us. The rest "
                 "is stretched, so that nothing jumps and 1000 and 2000 us stay",
         .example = "20"}),
    row<&ChannelRule::slew_us_per_second>({.key = "slew",
                                           .type = slew,
                                           .absent = "no limit",
                                           .least = 1,
                                           .most = 1e6,
                                           .help = "Fastest change of the channel",
                                           .example = "\"2000us/s\""}),
    row<&ChannelRule::min>(pulse_key("min", "The channel never goes below this value", "1100")),
    row<&ChannelRule::max>(pulse_key("max", "The channel never goes above this value", "1900")),
};

}  // namespace tribus::key_rows
