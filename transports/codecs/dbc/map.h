#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "core/can_frame.h"
#include "core/setting.h"
#include "core/time.h"
#include "transports/codecs/dbc/file.h"
#include "transports/codecs/dbc/signal.h"

/// Places of channels, flags, counters and checksums in the messages of a user's DBC file: the
/// meaning of the keys `dbc`, `signals` and `cycles`. Plain values. Pure and reentrant.
namespace tribus {

/// A signal that carries a channel.
struct DbcChannel {
    std::size_t channel = 0;  ///< from 0
    std::string signal{};     ///< its name
    DbcLayout layout;
    /// Two points of a straight line between physical values and microseconds.
    std::array<double, 2> value{};
    std::array<double, 2> microseconds{};
    /// Physical values that the file allows. Sent values are limited to them; a received value
    /// outside is no value.
    std::optional<std::array<double, 2>> range{};
    /// Raw bits that are no value (J1939: all ones, and one less).
    std::optional<std::uint64_t> not_available{};
    std::optional<std::uint64_t> error{};
    /// The bits that J1939 has for "not available": no value, even without the keys above.
    std::optional<std::uint64_t> usual_not_available{};
    /// A missing value means that the channel is absent, not that the source has failed.
    bool optional = false;
    /// Only if the layout holds a magnitude: signals that give its direction, with 0 no, 1 yes, 2
    /// error, 3 not available, as in J1939 joysticks (docs/protocols/can.md, "J1939 joysticks").
    std::optional<DbcLayout> negative{};
    std::optional<DbcLayout> positive{};
    std::optional<DbcLayout> neutral{};
};

/// Meaning of a flag signal.
enum class DbcFlagMeaning : std::uint8_t {
    failsafe,
    frame_lost,
    good,
    cause,  ///< the number of the LinkCause; ignored in received frames
};

/// A signal that is sent as 1 if the meaning applies, else as 0. In received frames, `good`
/// requires exactly 1 and the others exactly 0: the codes of J1939 for "error" and "not available"
/// count as bad.
struct DbcFlag {
    DbcFlagMeaning meaning = DbcFlagMeaning::failsafe;
    DbcLayout layout;
};

/// A signal that always has this raw value. A received frame with another value counts as failsafe.
struct DbcFixed {
    std::string signal;  ///< its name
    DbcLayout layout;
    std::uint64_t bits = 0;
};

/// A signal of an output that carries a named value.
struct DbcValue {
    std::string from;    ///< name of the value
    std::string signal;  ///< its name
    std::string unit;    ///< unit of the signal; empty if the file has none
    DbcLayout layout;
    /// Physical values that the file allows. Sent values are limited to them.
    std::optional<std::array<double, 2>> range{};
    /// The greatest raw bits that are a number. J1939 uses those above for codes.
    std::optional<std::uint64_t> most_bits{};
    /// Raw bits that mean "not available". Without them, the frame is not sent while there is no
    /// value.
    std::optional<std::uint64_t> not_available{};
};

/// A signal whose value gives the page of a multiplexed message.
struct DbcSelector {
    DbcLayout layout;
    std::vector<DbcSelectorRange> selected_by;  ///< values that mean this page
    std::uint64_t sent = 0;                     ///< one of them
};

/// A signal that increases with each frame.
struct DbcCounter {
    DbcLayout layout;
    std::uint64_t most = 0;  ///< counts from 0 to this, then starts again
};

/// Checksums over all bytes of the frame but their own (docs/protocols/can.md, "End-to-end
/// protection" and "Drive units and robots").
enum class DbcChecksumKind : std::uint8_t {
    xor8,     ///< exclusive or
    sum8,     ///< sum modulo 256
    agilex,   ///< sum of id, length and bytes modulo 256 (AgileX Scout, HUNTER)
    crc8_1d,  ///< SAE J1850: polynomial 0x1D, start and final XOR 0xFF
    crc8_2f,  ///< polynomial 0x2F, start and final XOR 0xFF
    p01,      ///< AUTOSAR end-to-end profile 1, data id in both bytes
    p05,      ///< profile 5 at offset 0
};

struct DbcChecksum {
    DbcChecksumKind kind = DbcChecksumKind::xor8;
    DbcLayout layout;
    std::size_t byte = 0;  ///< its own byte, or the first of its two
    std::uint16_t data_id = 0;
};

/// Content of one frame of a message. For an input: the signals that are present under the same
/// conditions, so one frame may hold several parts. For an output: one frame to send, with every
/// mapped signal that a receiver will find in it.
struct DbcPart {
    std::size_t message = 0;  ///< index into DbcMap::messages
    std::vector<DbcSelector> selectors;
    std::vector<DbcChannel> channels;
    std::vector<DbcFlag> flags;
    std::vector<DbcFixed> fixed;
    std::vector<DbcValue> values;
};

/// One message with its counter and checksum.
struct DbcMappedMessage {
    std::string name;
    CanIdMatch id;  ///< ids that are received; `sent_id` is sent
    std::uint32_t sent_id = 0;
    bool fd = false;
    bool bit_rate_switch = false;
    std::uint8_t length = 0;
    std::uint8_t fill = 0;  ///< value of bytes that no signal sets: ones in J1939
    std::optional<Duration> cycle;
    std::optional<DbcCounter> counter;
    std::optional<DbcChecksum> checksum;
};

/// The messages of an input or output, and the content of their frames.
struct DbcMap {
    std::vector<DbcMappedMessage> messages;
    std::vector<DbcPart> parts;

    /// The shortest cycle time of the messages with channels; nothing if none has one.
    std::optional<Duration> shortest_cycle() const;
    /// The same of all messages.
    std::optional<Duration> shortest_cycle_of_all() const;
    /// Whether a frame can tell the receiver not to use the values.
    bool signals_failsafe() const;
    /// Whether the frames of this message can tell it of their own channels.
    bool message_signals_failsafe(std::size_t message) const;
    /// Whether a frame carries a channel or a flag.
    bool needs_channels() const;
};

/// What is wrong with a file that is accepted, at most ten mistakes and the number of the others.
std::vector<SettingMistake> warnings_about_dbc(const DbcFile& file, const std::string& path);

/// Builds the map of an input or output from checked settings. The error lists all mistakes with
/// the path of each key, for the person who wrote them.
tl::expected<DbcMap, std::vector<SettingMistake>> build_dbc_map(const SettingValues& settings,
                                                                SettingScope scope);

}  // namespace tribus
