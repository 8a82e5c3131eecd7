#pragma once

#include <array>
#include <string_view>

#include "core/setting.h"

/// Keys of SBUS that protocols with its channels or its wire have too.
namespace tribus {

inline constexpr std::array<std::string_view, 5> kSbusScaleChoices{"betaflight", "ardupilot", "px4",
                                                                   "frsky", "futaba"};
inline constexpr Setting kSbusScaleSetting{
    .key = "scale",
    .type = SettingType::scale,
    .fallback = "\"betaflight\"",
    .choices = kSbusScaleChoices,
    .help = "How raw values become microseconds: a maker's scale, or two points",
    .example = "{ raw = [172, 1811], us = [988, 2012] }"};
inline constexpr Setting kInvertedSetting{
    .key = "inverted",
    .type = SettingType::boolean,
    .fallback = "false",
    .of_line = true,
    .help =
        "Must be false: Linux has no setting that inverts a serial line. Use an "
        "inverter",
    .example = "false"};

}  // namespace tribus
