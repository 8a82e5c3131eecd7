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

/// How channels, flags, counters and checksums lie in the messages of a user's DBC file: what the
/// keys `dbc`, `signals` and `cycles` mean, worked out once. Plain values; pure and reentrant.
namespace tribus {

/// A signal on its way to or from a channel.
struct DbcChannel {
    std::size_t channel = 0;  ///< from 0
    DbcLayout layout;
    /// Two points of a straight line between physical values and microseconds.
    std::array<double, 2> value{};
    std::array<double, 2> microseconds{};
    /// Physical values that the file allows: what is sent keeps to them, what is received beyond
    /// them is no value.
    std::optional<std::array<double, 2>> range{};
    /// Raw bits that are no value (J1939: all ones, and one less).
    std::optional<std::uint64_t> not_available{};
    std::optional<std::uint64_t> error{};
    /// A missing value means an absent channel, not that the source has failed.
    bool optional = false;
    /// The layout holds a magnitude, and these tell its direction: 0 no, 1 yes, 2 error, 3 not
    /// available, as the joysticks of J1939 do (docs/protocols/can.md, "J1939 joysticks").
    std::optional<DbcLayout> negative{};
    std::optional<DbcLayout> positive{};
    std::optional<DbcLayout> neutral{};
};

enum class DbcFlagMeaning : std::uint8_t {
    failsafe,
    frame_lost,
    good,
    cause,  ///< the number of the LinkCause; received, it says nothing
};

/// A signal that is sent as 1 where the meaning holds, else as 0. Received, only a plain 1 says
/// good and only a plain 0 says that nothing is lost: the codes of J1939 for "error" and "not
/// available" reassure nobody.
struct DbcFlag {
    DbcFlagMeaning meaning = DbcFlagMeaning::failsafe;
    DbcLayout layout;
};

/// A signal that always has this raw value; a frame received with another one says failsafe.
struct DbcFixed {
    DbcLayout layout;
    std::uint64_t bits = 0;
};

/// A signal of an output that holds a named value.
struct DbcValue {
    std::string from;  ///< the name of the value
    std::string unit;  ///< of the signal; empty where the file tells none
    DbcLayout layout;
    /// Physical values that the file allows: what is sent keeps to them.
    std::optional<std::array<double, 2>> range{};
    /// The greatest raw bits that are a number; J1939 keeps those above for codes.
    std::optional<std::uint64_t> most_bits{};
    /// Raw bits that say that there is none; without them the frame is not sent then.
    std::optional<std::uint64_t> not_available{};
};

/// A signal that tells which page of a multiplexed message a frame is.
struct DbcSelector {
    DbcLayout layout;
    std::vector<DbcSelectorRange> selected_by;  ///< values that mean this page
    std::uint64_t sent = 0;                     ///< one of them
};

struct DbcCounter {
    DbcLayout layout;
    std::uint64_t most = 0;  ///< counts from 0 to this, then from 0 again
};

/// Over all bytes of the frame but its own.
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
    std::size_t byte = 0;  ///< its own, or the first of its own
    std::uint16_t data_id = 0;
};

/// What one frame of a message holds. Of an input: the signals that are present under the same
/// conditions, so that a frame may hold several parts. Of an output: one frame that is sent, with
/// every mapped signal that a reader will find in it.
struct DbcPart {
    std::size_t message = 0;  ///< index into DbcMap::messages
    std::vector<DbcSelector> selectors;
    std::vector<DbcChannel> channels;
    std::vector<DbcFlag> flags;
    std::vector<DbcFixed> fixed;
    std::vector<DbcValue> values;
};

struct DbcMappedMessage {
    std::string name;
    CanIdMatch id;  ///< what is received; `sent_id` is what is sent
    std::uint32_t sent_id = 0;
    bool fd = false;
    bool bit_rate_switch = false;
    std::uint8_t length = 0;
    std::uint8_t fill = 0;  ///< of bytes that no signal sets: J1939 wants ones
    std::optional<Duration> cycle;
    std::optional<DbcCounter> counter;
    std::optional<DbcChecksum> checksum;
};

struct DbcMap {
    std::vector<DbcMappedMessage> messages;
    std::vector<DbcPart> parts;

    /// The shortest cycle time of a message with channels, if any has one.
    std::optional<Duration> shortest_cycle() const;
    /// A frame can tell a reader that the values are not to be used.
    bool says_failsafe() const;
    /// A frame tells something of channels.
    bool needs_channels() const;
};

/// Works out checked settings for an input or an output. The error is everything that is wrong, for
/// the person who wrote them, with the path of each key.
tl::expected<DbcMap, std::vector<SettingMistake>> build_dbc_map(const SettingValues& settings,
                                                                SettingScope scope);

}  // namespace tribus
