#pragma once

#include <cstdint>
#include <span>

#include "core/time.h"
#include "core/value_board.h"

namespace tribus {

/// One end of an i.Bus sensor bus, whichever role it has. Bytes and instants in, bytes out: makes
/// no system call and no allocation after construction. Thread-bound to whoever drives it.
class SensorBusRole {
  public:
    SensorBusRole() = default;
    SensorBusRole(const SensorBusRole&) = delete;
    SensorBusRole& operator=(const SensorBusRole&) = delete;
    virtual ~SensorBusRole() = default;

    virtual void start(Instant now) = 0;
    /// Bytes that were read at `now`, in which the line damaged none.
    virtual void receive(std::span<const std::uint8_t> bytes, Instant now, ValueBoard& board) = 0;
    /// A byte stood here that the line damaged.
    virtual void damaged_byte(Instant now) = 0;
    /// When to call `run`; may be moved by `receive`.
    virtual Instant due() const = 0;
    /// Its turn, at `now`: what is to be written at once, perhaps nothing. Valid until the next
    /// call.
    virtual std::span<const std::uint8_t> run(Instant now, ValueBoard& board) = 0;
    /// What `run` returned has been handed over, or dropped because the port took nothing.
    virtual void written(Instant now, ValueBoard& board) = 0;
    virtual void dropped() = 0;
    /// The device is gone; it will be opened again.
    virtual void device_lost(ValueBoard& board) = 0;
};

}  // namespace tribus
