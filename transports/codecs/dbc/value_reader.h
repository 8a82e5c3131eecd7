#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "core/can_frame.h"
#include "core/time.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/dbc/file.h"
#include "transports/codecs/dbc/signal.h"

namespace tribus {

/// What a frame says of one signal.
struct DbcReading {
    enum class State : std::uint8_t {
        absent,         ///< the frame does not hold it: another page of a multiplexed message
        not_available,  ///< it is there and says that there is no number, or none that is allowed
        number,
    };
    State state = State::absent;
    double number = 0;  ///< in the unit of the signal; 0 where there is none
};

/// The frames of one message of a DBC file in, the numbers of its signals out. In J1939 the codes
/// of SAE J1939-71 are no numbers (most_j1939_bits()); elsewhere what lies beyond the range of the
/// file is none, nor are floats that are not finite. Frames that are too short, FD or not as the
/// message is not, and remote frames are refused. Pure; no heap after construction. Thread-bound:
/// one thread at a time.
class DbcValueReader {
  public:
    struct Signal {
        std::string name;
        std::string unit;
    };

    /// Of a message of one frame, not `multi_packet`.
    explicit DbcValueReader(const DbcMessage& message);

    /// The ids of the message: in J1939 of any priority, and from any source where the file has
    /// 0xFE. Constant.
    std::span<const CanIdMatch> wanted() const { return {&wanted_, 1}; }
    bool uses_fd() const { return message_.fd; }
    /// In the order of the file. Constant.
    std::span<const Signal> signals() const { return signals_; }
    /// That the file gives.
    std::optional<Duration> cycle_time() const { return message_.cycle_time; }

    /// Whether the frame is one of the message; then `readings` has one for each signal, in their
    /// order. Needs room for all.
    bool take(const CanFrame& frame, std::span<DbcReading> readings);

    /// What was refused, by cause; only ever incremented.
    std::span<const NamedCount> rejected() const { return rejected_; }

  private:
    enum RejectCause : std::size_t { kLength, kRemote };

    DbcReading read(std::size_t signal, std::span<const std::uint8_t> data) const;
    bool is_number(std::size_t signal, std::uint64_t bits, double value) const;

    DbcMessage message_;
    CanIdMatch wanted_;
    std::vector<Signal> signals_;
    std::vector<DbcLayout> layouts_;
    std::vector<std::optional<std::uint64_t>> most_bits_;  ///< of J1939
    std::array<NamedCount, 2> rejected_{{{"length"}, {"remote"}}};
};

/// Reads the message of that name. The error names the messages that can be read, for the person
/// who wrote the name.
tl::expected<DbcValueReader, std::string> make_dbc_value_reader(const DbcFile& file,
                                                                std::string_view message);

}  // namespace tribus
