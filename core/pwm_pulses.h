#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

/// Records that an output of servo pulses hands to a PWM chip: one for each output of the chip, its
/// number and the length of its pulse in nanoseconds, the low byte first; 0 switches the output off
/// (docs/protocols/pwm.md). Pure and reentrant.
namespace tribus::pwm_pulses {

inline constexpr std::size_t kRecordBytes = 5;
inline constexpr std::uint32_t kOff = 0;

inline void put(std::span<std::uint8_t> record, std::uint8_t output, std::uint32_t nanoseconds) {
    record[0] = output;
    for (std::size_t byte = 0; byte < sizeof nanoseconds; ++byte) {
        record[1 + byte] = static_cast<std::uint8_t>(nanoseconds >> (8 * byte));
    }
}

inline std::uint32_t nanoseconds_of(std::span<const std::uint8_t> record) {
    std::uint32_t nanoseconds = 0;
    for (std::size_t byte = 0; byte < sizeof nanoseconds; ++byte) {
        nanoseconds |= std::uint32_t{record[1 + byte]} << (8 * byte);
    }
    return nanoseconds;
}

}  // namespace tribus::pwm_pulses
