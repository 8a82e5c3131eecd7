#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "core/time.h"

/// DBC description of a CAN bus (docs/protocols/can.md, "DBC files"): text in, plain structs out.
/// Pure and reentrant.
namespace tribus {

/// Limit of the text in bytes, far above the largest description of a real bus. A longer text is
/// another kind of file.
inline constexpr std::size_t kLongestDbcText = std::size_t{16} << 20U;
/// Limit of the depth of selectors: a signal depends on one, that on the next. Two or three are
/// usual.
inline constexpr std::size_t kDeepestDbcMultiplexing = 8;
/// Largest length of a signal in bits.
inline constexpr unsigned kLongestDbcSignal = 64;

enum class DbcByteOrder : std::uint8_t {
    intel,     ///< start_bit is the least significant bit
    motorola,  ///< start_bit is the most significant bit
};

enum class DbcValueKind : std::uint8_t { integer, float32, float64 };

/// The meaning of a raw value. For an unsigned signal of 64 bits, the value modulo 2^64.
struct DbcValueText {
    std::int64_t raw = 0;
    std::string text;

    bool operator==(const DbcValueText&) const = default;
};

/// Values of a selector, both ends included.
struct DbcSelectorRange {
    std::uint64_t first = 0;
    std::uint64_t last = 0;

    bool operator==(const DbcSelectorRange&) const = default;
};

/// One field of a frame. physical = raw * factor + offset. Bit number = byte * 8 + bit, where bit 0
/// is the least significant bit of its byte. A signal of a parsed file lies within its message.
struct DbcSignal {
    std::string name;
    unsigned start_bit = 0;
    /// 1 to kLongestDbcSignal; 32 or 64 for floating-point kinds.
    unsigned bit_length = 1;
    DbcByteOrder byte_order = DbcByteOrder::intel;
    bool is_signed = false;
    DbcValueKind kind = DbcValueKind::integer;
    /// Never 0.
    double factor = 1;
    double offset = 0;
    double minimum = 0;
    double maximum = 0;
    std::string unit;
    /// Whether the presence of other signals depends on the raw value of this one.
    bool is_selector = false;
    /// Index within the message of the selector on which this signal depends. Nothing: the signal
    /// is always present.
    std::optional<std::size_t> selector;
    /// The raw values of that selector with which this signal is present.
    std::vector<DbcSelectorRange> selected_by;
    /// The file does not say which selector decides, or by which values. Such a signal has no
    /// selector and is never present.
    bool page_unknown = false;
    std::vector<DbcValueText> value_texts;
    /// Line in the file, from 1.
    unsigned line = 0;

    /// [0|0] in the file means "no range"; so does an empty or reversed range.
    bool has_range() const { return minimum < maximum; }
};

/// Error in a text. Lines and columns count from 1, columns in bytes.
struct DbcMistake {
    unsigned line = 1;
    unsigned column = 1;
    std::string text;
};

/// A message or a signal that a mistake makes unusable. The rest of the file counts.
struct DbcUnusable {
    std::string name;
    DbcMistake why;
};

/// One message (BO_) with its signals.
struct DbcMessage {
    std::string name;
    /// 11 bits, or 29 if extended, without the flag bits of the file and of the kernel.
    std::uint32_t id = 0;
    bool extended = false;
    /// VFrameFormat J1939PG: the id holds priority, parameter group and source address.
    bool j1939 = false;
    /// VFrameFormat StandardCAN_FD or ExtendedCAN_FD, or longer than 8 bytes.
    bool fd = false;
    /// CANFD_BRS; never set for a classic frame.
    bool bit_rate_switch = false;
    /// J1939 only: longer than 8 bytes, so it needs a transport protocol and is not a single frame.
    bool multi_packet = false;
    /// In bytes: 0 to 8, or 12, 16, 20, 24, 32, 48, 64; any length if multi_packet.
    unsigned length = 0;
    /// GenMsgCycleTime of the message, or the default of all messages. Nothing if that is 0.
    std::optional<Duration> cycle_time;
    /// RcE2eDataId of the message, or the default of all messages; a default of 0 does not count.
    std::optional<std::uint32_t> e2e_data_id;
    std::string sender;
    /// The signals that can be used. Their names are unique.
    std::vector<DbcSignal> signals;
    std::vector<DbcUnusable> unusable{};
    /// Line in the file, from 1.
    unsigned line = 0;

    /// The signal with that name, or nullptr.
    const DbcSignal* find(std::string_view signal_name) const;
};

/// Content of a DBC file.
struct DbcFile {
    /// The messages that can be used. Names are unique, and so are ids of one kind.
    std::vector<DbcMessage> messages;
    std::vector<DbcUnusable> unusable{};
    /// All that is wrong with an accepted file, in its order, one mistake a place.
    std::vector<DbcMistake> warnings{};

    /// The message with that name, or nullptr.
    const DbcMessage* find(std::string_view message_name) const;
};

/// Reads a whole DBC text. Tolerates harmless deviations: line ends, tabs, a byte order mark, texts
/// in cp1252 (returned as UTF-8), sections in any order, unknown sections, references to unknown
/// signals, a last statement without ';', no message at all. Long names replace short ones. A
/// mistake that would falsify values makes the message or the signal unusable that it is about.
/// Returns an error if that is not known, and for a text that is cut off within a statement.
tl::expected<DbcFile, DbcMistake> parse_dbc(std::string_view text);

}  // namespace tribus
