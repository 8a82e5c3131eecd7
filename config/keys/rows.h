#pragma once

#include <array>
#include <string_view>

#include "config/keys/keys.h"
#include "core/channel_frame.h"

/// How rows of the key table are written. For config/keys/keys.cpp and its tables only.
namespace tribus::key_rows {

using enum SettingType;

constexpr Setting channel_number(std::string_view key, std::string_view help,
                                 std::string_view example) {
    return {.key = key,
            .type = integer,
            .least = 1,
            .most = kChannelCount,
            .help = help,
            .example = example};
}

constexpr Setting pulse_key(std::string_view key, std::string_view help, std::string_view example) {
    return {.key = key,
            .type = pulse,
            .least = kLeastPulse,
            .most = kMostPulse,
            .help = help,
            .example = example};
}

constexpr Setting pulses_key(std::string_view key, std::string_view help, std::string_view example,
                             std::string_view fallback = {}) {
    return {.key = key,
            .type = pulses,
            .fallback = fallback,
            .least = 0,
            .most = kMostWirePulse,
            .help = help,
            .example = example};
}

constexpr Setting structure(std::string_view key, std::string_view help,
                            std::string_view example = {}, std::string_view absent = {}) {
    return {.key = key, .absent = absent, .help = help, .example = example};
}

}  // namespace tribus::key_rows
