#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <type_traits>

#include "config/keys/keys.h"
#include "core/channel_frame.h"

/// How rows of the key table are written. For config/keys/keys.cpp and its tables only.
namespace tribus::key_rows {

using enum SettingType;

/// A row that sets the member at the end of the path. The member says the type and the choices,
/// unless it is a double, which has several notations, or the row has choices of its own.
template <auto... path>
constexpr Key row(Setting setting) {
    using Member = typename TypesOf<path...>::Member;
    constexpr bool kSaysType =
        !std::is_same_v<Member, double> && !std::is_same_v<Member, std::optional<double>>;
    if (kSaysType && setting.choices.empty()) {
        setting.type = Notation<Member>::kType;
        setting.choices = choices_of<Member>();
    }
    return {.setting = setting, .field = Access<Notation<Member>, path...>::kField};
}

/// A row that sets a channel. It has no default.
template <auto... path>
constexpr Key channel_row(Setting setting) {
    setting.type = ChannelNotation::kType;
    Key key{.setting = setting, .field = Access<ChannelNotation, path...>::kField};
    key.field.initial = nullptr;
    return key;
}

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
