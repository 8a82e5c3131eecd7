#pragma once

#include <cstdint>
#include <span>
#include <string>

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

/// What arrives in, numbers with names out. No heap after construction. Thread-bound.
class ValueReader {
  public:
    struct Value {
        std::string name;
        std::string unit;  ///< empty if it has none
    };

    virtual ~ValueReader() = default;

    /// In the order of readings. Constant.
    virtual std::span<const Value> values() const = 0;
    /// Refused frames by cause. The counts only ever increase.
    virtual std::span<const NamedCount> rejected() const = 0;

  protected:
    ValueReader() = default;
    ValueReader(const ValueReader&) = default;
    ValueReader& operator=(const ValueReader&) = default;
    ValueReader(ValueReader&&) = default;
    ValueReader& operator=(ValueReader&&) = default;
};

/// For messages in a stream of bytes.
class ByteValueReader : public ValueReader {
  public:
    /// Removes bytes from the front of `bytes` until a message is complete, then fills `readings`
    /// with one entry for each value and returns true; call again with the rest. Returns false when
    /// all bytes are taken. `readings` needs room for all values.
    virtual bool next(std::span<const std::uint8_t>& bytes, Instant received,
                      std::span<ValueReading> readings) = 0;
    /// Bytes that belonged to no frame of the protocol.
    virtual std::uint64_t skipped_bytes() const = 0;
    /// A byte with a parity or framing error stood here in the stream. Before this, call `next`
    /// until it returns false.
    virtual void damaged_byte() = 0;
    /// The line was unplugged and may be another one when it returns: forgets all bytes so far.
    virtual void reset() = 0;
    /// See ByteDecoder.
    virtual void use_clock(const WallClock& /*clock*/) {}
};

}  // namespace tribus
