#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "core/can_frame.h"
#include "core/time.h"
#include "transports/codecs/codec.h"

namespace tribus {

/// One value of a received message.
struct ValueReading {
    enum class State : std::uint8_t {
        absent,         ///< the message does not hold it: another page of a multiplexed one
        not_available,  ///< the message holds it, but marks it as not available or gives no allowed
                        ///< number
        number,
    };
    State state = State::absent;
    double number = 0;  ///< in the unit of the value; 0 without a number
};

/// CAN frames in, the numbers of one kind of message out. No heap after construction. Thread-bound.
class CanValueReader {
  public:
    struct Value {
        std::string name;
        std::string unit;  ///< empty if it has none
    };

    virtual ~CanValueReader() = default;

    /// The ids of the frames that `take` needs. Constant.
    virtual std::span<const CanIdMatch> wanted() const = 0;
    virtual bool uses_fd() const = 0;
    /// In the order of the message. Constant.
    virtual std::span<const Value> values() const = 0;

    /// Takes a frame that arrived at `at`. If it completes a message, fills `readings` with one
    /// entry for each value, in their order, and returns the instant of the numbers. `readings`
    /// needs room for all values.
    virtual std::optional<Instant> take(const CanFrame& frame, Instant at,
                                        std::span<ValueReading> readings) = 0;

    /// Refused frames by cause. The counts only ever increase.
    virtual std::span<const NamedCount> rejected() const = 0;

  protected:
    CanValueReader() = default;
    CanValueReader(const CanValueReader&) = default;
    CanValueReader& operator=(const CanValueReader&) = default;
    CanValueReader(CanValueReader&&) = default;
    CanValueReader& operator=(CanValueReader&&) = default;
};

}  // namespace tribus
