#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>

/// The bits of a payload in the order of DroneCAN's serialisation: the low byte of a value comes
/// first and its highest, possibly partial, byte last. Inside a byte the most significant bit comes
/// first. Nothing is aligned. Source: the DSDL chapter of the specification; docs/protocols/can.md,
/// "DroneCAN: RCInput". Pure, no heap. Thread-bound.
namespace tribus::dronecan {

class BitReader {
  public:
    explicit BitReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

    /// The next `bits` bits, 0 to 64, right-aligned. If fewer are left, returns zero and refuses
    /// the payload.
    std::uint64_t take(unsigned bits) {
        if (bits > left()) {
            refuse();
            return 0;
        }
        std::uint64_t value = 0;
        for (unsigned taken = 0; taken < bits; taken += 8) {
            value |= std::uint64_t{take_within_byte(std::min(8U, bits - taken))} << taken;
        }
        return value;
    }

    /// Marks the payload as not readable as its type. No bits are left then.
    void refuse() {
        refused_ = true;
        taken_ = bytes_.size() * 8;
    }

    std::size_t left() const { return bytes_.size() * 8 - taken_; }
    bool refused() const { return refused_; }

  private:
    unsigned take_within_byte(unsigned bits) {
        const std::size_t byte = taken_ / 8;
        const unsigned end = taken_ % 8 + bits;
        const unsigned next = end > 8 ? bytes_[byte + 1] : 0U;
        const unsigned window = (unsigned{bytes_[byte]} << 8U) | next;
        taken_ += bits;
        return (window >> (16 - end)) & ((1U << bits) - 1);
    }

    std::span<const std::uint8_t> bytes_;
    std::size_t taken_ = 0;
    bool refused_ = false;
};

class BitWriter {
  public:
    /// `bytes` must be zero and have room for all bits that are put.
    explicit BitWriter(std::span<std::uint8_t> bytes) : bytes_(bytes) {}

    /// Appends the low `bits` (0 to 64) of the value.
    void put(std::uint64_t value, unsigned bits) {
        assert(put_ + bits <= bytes_.size() * 8);
        for (unsigned done = 0; done < bits; done += 8) {
            const unsigned count = std::min(8U, bits - done);
            put_within_byte(static_cast<unsigned>(value >> done) & ((1U << count) - 1), count);
        }
    }

    std::size_t bytes_put() const { return (put_ + 7) / 8; }

  private:
    void put_within_byte(unsigned value, unsigned bits) {
        const std::size_t byte = put_ / 8;
        const unsigned end = put_ % 8 + bits;
        const unsigned window = value << (16 - end);
        bytes_[byte] = static_cast<std::uint8_t>(bytes_[byte] | (window >> 8U));
        if (end > 8) {
            bytes_[byte + 1] = static_cast<std::uint8_t>(window & 0xFFU);
        }
        put_ += bits;
    }

    std::span<std::uint8_t> bytes_;
    std::size_t put_ = 0;
};

}  // namespace tribus::dronecan
