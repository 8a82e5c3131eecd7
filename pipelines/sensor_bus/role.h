#pragma once

#include <cstdint>
#include <span>

#include "core/time.h"
#include "core/value_board.h"

namespace tribus {

/// One end of an i.Bus sensor bus, in either role. Takes bytes and times, returns bytes. Makes no
/// system call and does not allocate after construction. Thread-bound.
class SensorBusRole {
  public:
    SensorBusRole() = default;
    SensorBusRole(const SensorBusRole&) = delete;
    SensorBusRole& operator=(const SensorBusRole&) = delete;
    virtual ~SensorBusRole() = default;

    /// Call once, before any other call.
    virtual void start(Instant now) = 0;
    /// Takes undamaged bytes that were read at `now`.
    virtual void receive(std::span<const std::uint8_t> bytes, Instant now, ValueBoard& board) = 0;
    /// A byte that was damaged on the line came at `now`.
    virtual void damaged_byte(Instant now) = 0;
    /// When to call `run`. `receive` may change it.
    virtual Instant due() const = 0;
    /// Call when due. Returns the bytes to write at once, or nothing. Valid until the next call.
    virtual std::span<const std::uint8_t> run(Instant now, ValueBoard& board) = 0;
    /// The bytes from `run` were handed over, or dropped because the port did not take them.
    virtual void written(Instant now, ValueBoard& board) = 0;
    virtual void dropped() = 0;
    /// The device is gone. It will be opened again.
    virtual void device_lost(ValueBoard& board) = 0;
};

}  // namespace tribus
