#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "core/can_frame.h"
#include "core/time.h"
#include "transports/codecs/codec.h"

namespace tribus {

/// What a message says of one of its values.
struct ValueReading {
    enum class State : std::uint8_t {
        absent,         ///< the message does not hold it: another page of a multiplexed one
        not_available,  ///< it is there and says that there is no number, or none that is allowed
        number,
    };
    State state = State::absent;
    double number = 0;  ///< in the unit of the value; 0 where there is none
};

/// CAN frames in, the numbers of one kind of message out. No heap after construction. Thread-bound:
/// one thread at a time.
class CanValueReader {
  public:
    struct Value {
        std::string name;
        std::string unit;  ///< empty where there is none
    };

    virtual ~CanValueReader() = default;

    /// Every frame that it is to be given. Constant.
    virtual std::span<const CanIdMatch> wanted() const = 0;
    virtual bool uses_fd() const = 0;
    /// In the order of the message. Constant.
    virtual std::span<const Value> values() const = 0;

    /// Takes a frame that came at `at`. If a message is complete with it, `readings` has one for
    /// each value, in their order, and the instant is the one that they are of. Needs room for all.
    virtual std::optional<Instant> take(const CanFrame& frame, Instant at,
                                        std::span<ValueReading> readings) = 0;

    /// What was refused, by cause; only ever incremented.
    virtual std::span<const NamedCount> rejected() const = 0;

  protected:
    CanValueReader() = default;
    CanValueReader(const CanValueReader&) = default;
    CanValueReader& operator=(const CanValueReader&) = default;
    CanValueReader(CanValueReader&&) = default;
    CanValueReader& operator=(CanValueReader&&) = default;
};

}  // namespace tribus
