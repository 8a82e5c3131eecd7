#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string_view>

#include "core/line_settings.h"
#include "core/setting.h"
#include "core/time.h"
#include "transports/codecs/codec.h"

namespace tribus {

/// All that the rest of the program needs to know of one protocol: one of these is one line of the
/// table in transports/registry.cpp.
struct Protocol {
    std::string_view name;
    std::string_view description;
    LineSettings line;
    /// Keys that only this protocol has, beside those that every input or output has.
    std::span<const Setting> settings;
    /// Longest frame that an encoder of this protocol writes, in bytes.
    std::size_t longest_frame = 0;
    Duration default_period{};
    /// Shorter periods need `force = true`: readers in the field would lose frames.
    Duration least_period{};
    /// The wire format can say "failsafe", so a frame that says it is not stale.
    bool says_failsafe = false;
    std::unique_ptr<Decoder> (*make_decoder)(const SettingValues&) = nullptr;
    std::unique_ptr<Encoder> (*make_encoder)(const SettingValues&) = nullptr;
};

}  // namespace tribus
