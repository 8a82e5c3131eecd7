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

/// The frames of one DBC message in, the numbers of its signals out. These are no numbers: codes of
/// SAE J1939-71 (most_j1939_bits()), values outside the range of the file, and floats that are not
/// finite. Refuses frames that are too short, of the wrong kind (classic or FD), or remote.
/// Thread-bound.
class DbcValueReader final : public CanValueReader {
  public:
    /// `message` must be of one frame, not `multi_packet`.
    explicit DbcValueReader(const DbcMessage& message);

    /// The ids of the message (see received_ids()). Constant.
    std::span<const CanIdMatch> wanted() const override { return {&wanted_, 1}; }
    bool uses_fd() const override { return message_.fd; }
    /// The signals, in the order of the file.
    std::span<const Value> values() const override { return signals_; }
    /// Cycle time in the file, if any.
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
    std::vector<std::optional<std::uint64_t>> most_bits_;  ///< J1939 only
    std::array<NamedCount, 2> rejected_{{{"length"}, {"remote"}}};
};

/// Makes a reader of the message with that name. The error names the messages that can be read.
tl::expected<DbcValueReader, std::string> make_dbc_value_reader(const DbcFile& file,
                                                                std::string_view message);

}  // namespace tribus
