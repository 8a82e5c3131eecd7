#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/can_frame.h"

/// Number of bits that a frame takes on the bus, after ISO 11898-1 (docs/protocols/can.md, "Bits of
/// a frame").
namespace tribus::test {

/// Bits from the start of frame to the end of the intermission after it.
struct BusBits {
    std::size_t nominal = 0;
    std::size_t data = 0;  ///< at the data bit rate, to which only FD frames switch

    BusBits& operator+=(const BusBits& more) {
        nominal += more.nominal;
        data += more.data;
        return *this;
    }
    bool operator==(const BusBits&) const = default;
};

/// Time of `bits` on the bus. The rates must divide a second into whole nanoseconds.
inline std::chrono::nanoseconds time_on_bus(const BusBits& bits, std::size_t nominal_rate,
                                            std::size_t data_rate) {
    constexpr std::size_t kSecond = 1'000'000'000;
    return std::chrono::nanoseconds(bits.nominal * (kSecond / nominal_rate) +
                                    bits.data * (kSecond / data_rate));
}

/// The bits of one frame in which five equal bits in a row are followed by a stuff bit: all bits up
/// to the end of the data, and in a classic frame the CRC too.
class StuffedBits {
  public:
    explicit StuffedBits(const CanFrame& frame) {
        put(0, 1);  // start of frame
        if (frame.extended) {
            put(frame.id >> 18U, 11);
            put(0b11, 2);  // SRR, IDE
            put(frame.id, 18);
        } else {
            put(frame.id, 11);
        }
        put(frame.remote ? 1 : 0, 1);    // in FD frames RRS
        put(0, frame.extended ? 0 : 1);  // IDE
        if (frame.fd) {
            put(0b10, 2);  // FDF, res
            put(frame.bit_rate_switch ? 1 : 0, 1);
            nominal_ = frame.bit_rate_switch ? bits_.size() : kAll;
            put(frame.error_state_indicator ? 1 : 0, 1);
        } else {
            put(0, frame.extended ? 2 : 1);  // r1, r0
        }
        put(length_code(frame.length), 4);
        for (const std::uint8_t byte :
             frame.remote ? std::span<const std::uint8_t>{} : frame.bytes()) {
            put(byte, 8);
        }
        if (!frame.fd) {
            put(crc(), 15);
        }
    }

    std::size_t count() const { return bits_.size(); }
    /// Number of bits before the switch to the data bit rate.
    std::size_t nominal_count() const { return std::min(nominal_, bits_.size()); }

    /// Number of stuff bits after the bits from `first` to `end` (exclusive). A stuff bit begins
    /// the next run.
    std::size_t stuff_bits(std::size_t first, std::size_t end) const {
        std::size_t found = 0;
        std::size_t run = 0;
        bool latest = false;
        for (std::size_t i = 0; i < end; ++i) {
            run = run > 0 && bits_[i] == latest ? run + 1 : 1;
            latest = bits_[i];
            if (run == kLongestRun) {
                found += i >= first ? 1U : 0U;
                latest = !latest;
                run = 1;
            }
        }
        return found;
    }

    static constexpr std::size_t kLongestRun = 5;

  private:
    static constexpr std::size_t kAll = ~std::size_t{0};

    void put(std::uint32_t value, unsigned count) {
        while (count-- > 0) {
            bits_.push_back((value >> count & 1U) != 0);
        }
    }
    static std::uint32_t length_code(std::size_t length) {
        if (length <= kMostClassicBytes) {
            return static_cast<std::uint32_t>(length);
        }
        const auto* const at = std::ranges::find(kLongFdLengths, length);
        return static_cast<std::uint32_t>(9 + (at - kLongFdLengths.begin()));
    }
    std::uint32_t crc() const {
        constexpr std::uint32_t kPolynomial = 0x4599;
        constexpr std::uint32_t kHighest = 0x4000;
        std::uint32_t value = 0;
        for (const bool bit : bits_) {
            const bool divides = ((value & kHighest) != 0) != bit;
            value = (value << 1U ^ (divides ? kPolynomial : 0U)) & 0x7FFFU;
        }
        return value;
    }

    std::vector<bool> bits_;
    std::size_t nominal_ = kAll;
};

namespace can_bits {

/// CRC delimiter, ACK, ACK delimiter, end of frame, intermission.
inline constexpr std::size_t kEnd = 1 + 1 + 1 + 7 + 3;

/// Bits of the stuff count and the CRC, with a stuff bit before every four of them.
inline std::size_t fd_crc_field(std::size_t bytes) {
    constexpr std::size_t kMostBytesOfShortCrc = 16;
    const std::size_t bits = 4 + (bytes <= kMostBytesOfShortCrc ? 17U : 21U);
    return bits + (bits + 3) / 4;
}

/// Adds the bits after the stuffed ones. `stuffed_nominal` and `stuffed_data` include stuff bits.
inline BusBits frame_bits(const CanFrame& frame, std::size_t stuffed_nominal,
                          std::size_t stuffed_data) {
    BusBits bits{.nominal = stuffed_nominal + kEnd, .data = stuffed_data};
    if (frame.fd) {
        (frame.bit_rate_switch ? bits.data : bits.nominal) += fd_crc_field(frame.length);
    }
    return bits;
}

}  // namespace can_bits

/// Bits of this frame with the stuff bits that its contents need.
inline BusBits bits_on_bus(const CanFrame& frame) {
    const StuffedBits stuffed(frame);
    const std::size_t nominal = stuffed.nominal_count();
    // The CRC field of an FD frame begins with a stuff bit, so no other stuff bit comes after the
    // data.
    const std::size_t end = stuffed.count() - (frame.fd ? 1U : 0U);
    return can_bits::frame_bits(
        frame, nominal + stuffed.stuff_bits(0, std::min(nominal, end)),
        stuffed.count() - nominal + (nominal < end ? stuffed.stuff_bits(nominal, end) : 0U));
}

/// Upper limit of the bits for any contents: one stuff bit after the first five bits, then one
/// after every four.
inline BusBits most_bits_on_bus(const CanFrame& frame) {
    const StuffedBits stuffed(frame);
    const auto most = [](std::size_t bits) { return (bits - 1) / (StuffedBits::kLongestRun - 1); };
    const std::size_t nominal = stuffed.nominal_count();
    return can_bits::frame_bits(frame, nominal + most(nominal),
                                stuffed.count() - nominal + most(stuffed.count()) - most(nominal));
}

inline BusBits bits_on_bus(std::span<const CanFrame> frames) {
    BusBits sum;
    for (const CanFrame& frame : frames) {
        sum += bits_on_bus(frame);
    }
    return sum;
}

inline BusBits most_bits_on_bus(std::span<const CanFrame> frames) {
    BusBits sum;
    for (const CanFrame& frame : frames) {
        sum += most_bits_on_bus(frame);
    }
    return sum;
}

}  // namespace tribus::test
