#pragma once

#include <memory>
#include <optional>
#include <span>
#include <variant>

#include "core/can_frame.h"
#include "core/time.h"
#include "transports/codecs/value_reader.h"

namespace tribus {

/// For one kind of message on CAN.
class CanValueReader : public ValueReader {
  public:
    /// The ids of the frames that `take` needs. Constant.
    virtual std::span<const CanIdMatch> wanted() const = 0;
    virtual bool uses_fd() const = 0;

    /// Takes a frame that arrived at `at`. If it completes a message, fills `readings` with one
    /// entry for each value, in their order, and returns the instant of the numbers. `readings`
    /// needs room for all values.
    virtual std::optional<Instant> take(const CanFrame& frame, Instant at,
                                        std::span<ValueReading> readings) = 0;
};

/// A reader, by what arrives.
using AnyValueReader =
    std::variant<std::unique_ptr<CanValueReader>, std::unique_ptr<ByteValueReader>>;

}  // namespace tribus
