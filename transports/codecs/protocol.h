#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/line_settings.h"
#include "core/setting.h"
#include "core/time.h"
#include "transports/codecs/can_codec.h"
#include "transports/codecs/codec.h"

namespace tribus {

enum class LinkKind : std::uint8_t { serial, can };

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
    /// Whether the wire format, with these settings, can say "failsafe", so that a frame that says
    /// it is not stale.
    bool (*says_failsafe)(const SettingValues&) = nullptr;
    /// What is wrong with settings that are each sound alone; null: nothing can be.
    std::vector<SettingMistake> (*check)(const SettingValues&, SettingScope) = nullptr;

    /// A serial protocol has the first two, a CAN protocol the other two. Settings are checked.
    std::unique_ptr<Decoder> (*make_decoder)(const SettingValues&) = nullptr;
    std::unique_ptr<Encoder> (*make_encoder)(const SettingValues&) = nullptr;
    std::unique_ptr<CanDecoder> (*make_can_decoder)(const SettingValues&) = nullptr;
    std::unique_ptr<CanEncoder> (*make_can_encoder)(const SettingValues&) = nullptr;
};

/// For formats that always, or never, can say failsafe.
inline bool always_says_failsafe(const SettingValues&) {
    return true;
}
inline bool never_says_failsafe(const SettingValues&) {
    return false;
}

}  // namespace tribus
