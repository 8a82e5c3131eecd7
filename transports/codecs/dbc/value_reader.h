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
#include "transports/codecs/can_value_reader.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/dbc/file.h"
#include "transports/codecs/dbc/signal.h"

namespace tribus {

/// The frames of one message of a DBC file in, the numbers of its signals out. In J1939 the codes
/// of SAE J1939-71 are no numbers (most_j1939_bits()); elsewhere what lies beyond the range of the
/// file is none, nor are floats that are not finite. Frames that are too short, FD or not as the
/// message is not, and remote frames are refused. Pure.
class DbcValueReader final : public CanValueReader {
  public:
    /// Of a message of one frame, not `multi_packet`.
    explicit DbcValueReader(const DbcMessage& message);

    /// The ids of the message: in J1939 of any priority, and from any source where the file has
    /// 0xFE. Constant.
    std::span<const CanIdMatch> wanted() const override { return {&wanted_, 1}; }
    bool uses_fd() const override { return message_.fd; }
    /// The signals, in the order of the file.
    std::span<const Value> values() const override { return signals_; }
    /// That the file gives.
    std::optional<Duration> cycle_time() const { return message_.cycle_time; }

    std::optional<Instant> take(const CanFrame& frame, Instant at,
                                std::span<ValueReading> readings) override;

    std::span<const NamedCount> rejected() const override { return rejected_; }

  private:
    enum RejectCause : std::size_t { kLength, kRemote };

    ValueReading read(std::size_t signal, std::span<const std::uint8_t> data) const;
    bool is_number(std::size_t signal, std::uint64_t bits, double value) const;

    DbcMessage message_;
    CanIdMatch wanted_;
    std::vector<Value> signals_;
    std::vector<DbcLayout> layouts_;
    std::vector<std::optional<std::uint64_t>> most_bits_;  ///< of J1939
    std::array<NamedCount, 2> rejected_{{{"length"}, {"remote"}}};
};

/// Reads the message of that name. The error names the messages that can be read, for the person
/// who wrote the name.
tl::expected<DbcValueReader, std::string> make_dbc_value_reader(const DbcFile& file,
                                                                std::string_view message);

}  // namespace tribus
