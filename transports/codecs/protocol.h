#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/line_settings.h"
#include "core/pulse.h"
#include "core/setting.h"
#include "core/time.h"
#include "core/wire_shape.h"
#include "transports/codecs/can_codec.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/frame_encoder.h"
#include "transports/codecs/link_with_key.h"
#include "transports/codecs/value_reader.h"

namespace tribus {

/// A decoder, by what arrives.
using AnyDecoder = std::variant<std::unique_ptr<ByteDecoder>, std::unique_ptr<CanDecoder>>;

/// A named value that an output sends.
struct NamedUse {
    std::string name;
    /// The key that names the value. Inside a tree: the keys that lead to it.
    std::vector<std::string> path;
    /// In which it is sent; a value whose unit does not convert to it is refused. Empty: any.
    std::string unit{};
    /// Whether a pulse in us will do, too.
    bool takes_pulses = false;
};

/// The bytes with which each frame of a protocol on bytes begins, as far as they are always the
/// same.
struct FrameBeginning {
    std::uint8_t first = 0;
    std::optional<std::uint8_t> second{};
};

/// Channels of which any pulse but one moves a motor.
struct MovingPresets {
    std::uint32_t channels = 0;  ///< one bit each
    Pulse standstill{};
};

/// Description of a protocol for the rest of the program. Each one is a line of the table in
/// transports/registry/protocols.inc. The functions are pure and reentrant.
struct Protocol {
    /// As in configurations.
    std::string_view name;
    /// As people call it.
    std::string_view title;
    std::string_view description;
    WireShape shape = WireShape::bytes;
    /// The name of the one medium that carries it. Empty: every medium of its shape does, but those
    /// for protocols of their own only.
    std::string_view only_on = {};
    /// Settings of a serial line for it. Only for protocols of bytes.
    LineSettings line = {};
    /// How frames may begin; `doctor` recognises an inverted line by them.
    std::span<const FrameBeginning> beginnings = {};
    /// Keys of this protocol, in addition to those of every input or output.
    std::span<const Setting> settings;
    /// Longest frame that an encoder of a serial protocol writes, in bytes.
    std::size_t longest_frame = 0;
    /// By how many bytes more these settings can make it. Null: by none.
    std::size_t (*longer_by)(const SettingValues&) = nullptr;
    Duration default_period{};
    /// The period that the settings themselves give, if any. Null: they never give one.
    std::optional<Duration> (*own_period)(const SettingValues&) = nullptr;
    /// Shorter periods need `force = true`, because usual receivers would lose frames.
    Duration least_period{};
    /// Least time from the start of a frame that was late, or a repeat, to that of the next one: so
    /// little only now and then. By default `least_period`.
    std::optional<Duration> least_spacing{};
    /// Default timeout of an input: some periods of the slowest usual sender. By default that of
    /// SupervisionSettings.
    std::optional<Duration> default_timeout{};
    /// Longest period before receivers of these frames stop acting on them. Null or nothing: no
    /// limit.
    std::optional<Duration> (*most_period)(const SettingValues&) = nullptr;
    /// Whether the wire format can signal failsafe with these settings. Frames of such a format are
    /// not judged as stale.
    bool (*signals_failsafe)(const SettingValues&) = nullptr;
    /// Pulse of the raw value zero, if receivers send zero for "no value". Null: they do not.
    Pulse (*raw_zero)(const SettingValues&) = nullptr;
    /// The channels that every good frame of an input with these settings has, one bit each; other
    /// channels may be absent. Null or nothing: the sender decides.
    std::optional<std::uint32_t> (*sure_channels)(const SettingValues&) = nullptr;
    /// The channels that frames of an input with these settings can have, one bit each. Null: all.
    std::uint32_t (*possible_channels)(const SettingValues&) = nullptr;
    /// Errors in settings that are each valid alone. Null: none possible.
    std::vector<SettingMistake> (*check)(const SettingValues&, SettingScope) = nullptr;
    /// What `check` accepts, but is probably not meant. Null: nothing.
    std::vector<SettingMistake> (*warnings)(const SettingValues&, SettingScope) = nullptr;
    /// The channels whose absence is no loss of an input with these settings, one bit each. Null:
    /// none.
    std::uint32_t (*optional_channels)(const SettingValues&) = nullptr;
    /// The defaults that depend on the direction or on other settings (`absent` says in words what
    /// they are), for those keys that have an effect. Keys that were given may be among them. The
    /// settings must be checked. Null: none.
    SettingValues (*dependent_defaults)(const SettingValues&, SettingScope) = nullptr;
    /// What the receivers of an output with these settings do with the default presets, if they
    /// move something. Null or nothing: nothing that matters.
    std::optional<MovingPresets> (*moves_by_default)(const SettingValues&) = nullptr;
    /// The named values that an output with these settings sends. Null: none.
    std::vector<NamedUse> (*value_names)(const SettingValues&) = nullptr;
    /// Whether an output with these settings sends channels. If not, it needs no pipeline. Null:
    /// always.
    bool (*needs_pipeline)(const SettingValues&) = nullptr;

    /// Whether the receiver of an output's frames asks for their timing on the same line. Such an
    /// output reads what comes back (ByteEncoder::hear), and its schedule is a grid. Null: never.
    bool (*is_timed_by_receiver)(const SettingValues&) = nullptr;

    /// What is wrong by the answers of the receiver of an output's frames, and what to check. Their
    /// counts begin with control. Such an output reads what comes back (ByteEncoder::hear,
    /// Encoder::answers). Empty: nothing is. Null: receivers do not answer.
    std::string (*advice_by_answers)(const SettingValues&, const Answers&) = nullptr;

    /// The name of the link, if messages on it are proved by a key: what both ends of one link
    /// share, and no other link with that key. Its inputs answer their senders, and its outputs
    /// hear the answers. Null or nothing: no key.
    std::optional<LinkWithKey> (*link_with_key)(const SettingValues&) = nullptr;

    /// Null where there is no codec. Settings must be checked.
    AnyDecoder (*make_decoder)(const SettingValues&) = nullptr;
    AnyEncoder (*make_encoder)(const SettingValues&) = nullptr;
    /// The named values that arrive. Null: none. A protocol with them is in kValueProtocols.
    std::unique_ptr<ByteValueReader> (*make_value_reader)(const SettingValues&) = nullptr;

    /// Whether it carries channels. If not, no input or output has it, but `decode`, `record`,
    /// `replay` and `doctor` know it.
    bool has_channels() const { return make_decoder != nullptr || make_encoder != nullptr; }
    /// Whether there is a codec for this direction.
    bool goes(SettingScope way) const {
        return (way == SettingScope::output || make_decoder != nullptr) &&
               (way == SettingScope::input || make_encoder != nullptr);
    }
};

/// The decoder of a protocol on bytes.
inline std::unique_ptr<ByteDecoder> make_byte_decoder(const Protocol& protocol,
                                                      const SettingValues& settings) {
    return std::get<std::unique_ptr<ByteDecoder>>(protocol.make_decoder(settings));
}
/// The decoder of a protocol on CAN.
inline std::unique_ptr<CanDecoder> make_can_decoder(const Protocol& protocol,
                                                    const SettingValues& settings) {
    return std::get<std::unique_ptr<CanDecoder>>(protocol.make_decoder(settings));
}

/// The key for the bit rate of a protocol whose devices differ in it.
constexpr Setting baud_setting(std::string_view fallback, std::string_view example,
                               double most = 1e6) {
    return {.key = "baud",
            .type = SettingType::integer,
            .fallback = fallback,
            .least = 9600,
            .most = most,
            .unit = "baud",
            .of_line = true,
            .help = "Bit rate of the line",
            .example = example};
}

/// For formats that can always, or never, signal failsafe.
inline bool always_signals_failsafe(const SettingValues&) {
    return true;
}
inline bool never_signals_failsafe(const SettingValues&) {
    return false;
}

/// The first `count` channels, one bit each.
constexpr std::uint32_t first_channels(std::size_t count) {
    return (1U << count) - 1;
}
template <std::size_t count>
std::uint32_t has_at_most_first(const SettingValues&) {
    return first_channels(count);
}
template <std::size_t count>
std::optional<std::uint32_t> always_has_first(const SettingValues&) {
    return first_channels(count);
}

}  // namespace tribus
