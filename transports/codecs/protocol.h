#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/line_settings.h"
#include "core/pulse.h"
#include "core/setting.h"
#include "core/time.h"
#include "transports/codecs/can_codec.h"
#include "transports/codecs/codec.h"

namespace tribus {

enum class LinkKind : std::uint8_t { serial, can };

/// A named value that an output sends.
struct NamedUse {
    std::string name;
    /// The key that says so, and where it is inside a tree the keys that lead there.
    std::vector<std::string> path;
};

/// All that the rest of the program needs to know of one protocol: one of these is one line of the
/// table in transports/registry.cpp.
struct Protocol {
    std::string_view name;
    std::string_view description;
    LinkKind link = LinkKind::serial;
    /// Serial protocols only.
    LineSettings line;
    /// Keys that only this protocol has, beside those that every input or output has.
    std::span<const Setting> settings;
    /// Longest frame that an encoder of a serial protocol writes, in bytes.
    std::size_t longest_frame = 0;
    Duration default_period{};
    /// The period that these settings themselves tell, if they do; null: they never do.
    std::optional<Duration> (*own_period)(const SettingValues&) = nullptr;
    /// Shorter periods need `force = true`: readers in the field would lose frames.
    Duration least_period{};
    /// Receivers of these settings' frames stop what they do if they wait longer; null, or nothing:
    /// none does.
    std::optional<Duration> (*most_period)(const SettingValues&) = nullptr;
    /// Whether the wire format, with these settings, can say "failsafe", so that a frame that says
    /// it is not stale.
    bool (*says_failsafe)(const SettingValues&) = nullptr;
    /// What a channel reads whose value on the wire is zero, where receivers send that for "no
    /// value"; null: none does.
    Pulse (*raw_zero)(const SettingValues&) = nullptr;
    /// The channels that every good frame of an input with these settings has, a bit each; others
    /// it may have or not. Null, or nothing: that is up to the sender.
    std::optional<std::uint32_t> (*sure_channels)(const SettingValues&) = nullptr;
    /// What is wrong with settings that are each sound alone; null: nothing can be.
    std::vector<SettingMistake> (*check)(const SettingValues&, SettingScope) = nullptr;
    /// The named values that an output with these settings sends; null: never any.
    std::vector<NamedUse> (*value_names)(const SettingValues&) = nullptr;
    /// Whether an output with these settings tells anything of channels; else it needs no pipeline.
    /// Null: always.
    bool (*needs_pipeline)(const SettingValues&) = nullptr;

    /// A serial protocol has the first two, a CAN protocol the other two. Settings are checked.
    std::unique_ptr<Decoder> (*make_decoder)(const SettingValues&) = nullptr;
    std::unique_ptr<Encoder> (*make_encoder)(const SettingValues&) = nullptr;
    std::unique_ptr<CanDecoder> (*make_can_decoder)(const SettingValues&) = nullptr;
    std::unique_ptr<CanEncoder> (*make_can_encoder)(const SettingValues&) = nullptr;

    /// Whether there is a codec for this way.
    bool goes(SettingScope way) const {
        const bool in = make_decoder != nullptr || make_can_decoder != nullptr;
        const bool out = make_encoder != nullptr || make_can_encoder != nullptr;
        return (way == SettingScope::output || in) && (way == SettingScope::input || out);
    }
};

/// For formats that always, or never, can say failsafe.
inline bool always_says_failsafe(const SettingValues&) {
    return true;
}
inline bool never_says_failsafe(const SettingValues&) {
    return false;
}

/// The first so many channels, as bits.
constexpr std::uint32_t first_channels(std::size_t count) {
    return (1U << count) - 1;
}
template <std::size_t count>
std::optional<std::uint32_t> always_has_first(const SettingValues&) {
    return first_channels(count);
}

}  // namespace tribus
