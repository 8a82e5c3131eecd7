#pragma once

#include <bit>
#include <cstdint>

/// IEEE 754 binary16, the form of most DroneCAN measurements. Pure and reentrant; without libm.
namespace tribus::dronecan {

/// The usual encoding of an unknown value; some nodes write 0x7FFF (docs/protocols/can.md,
/// "DroneCAN: telemetry").
inline constexpr std::uint16_t kFloat16Unknown = 0x7E00;

/// Exact. Every encoding of not-a-number becomes NaN.
constexpr float float_from_float16(std::uint16_t bits) {
    const std::uint32_t sign = (bits & 0x8000U) << 16U;
    const std::uint32_t exponent = (bits >> 10U) & 0x1FU;
    const std::uint32_t mantissa = bits & 0x3FFU;
    if (exponent == 0) {
        const float magnitude = static_cast<float>(mantissa) * 0x1p-24F;
        return sign != 0 ? -magnitude : magnitude;
    }
    if (exponent == 0x1F) {
        const std::uint32_t quiet = mantissa != 0 ? 0x400000U : 0U;
        return std::bit_cast<float>(sign | 0x7F800000U | quiet | (mantissa << 13U));
    }
    return std::bit_cast<float>(sign | ((exponent + 112) << 23U) | (mantissa << 13U));
}

/// The nearest value, to even in a tie. Saturates as DSDL does by default: larger values become
/// +-65504, but infinity stays infinity. NaN becomes kFloat16Unknown.
constexpr std::uint16_t float16_from_float(float value) {
    constexpr std::uint32_t kInfinity = 0x7F800000U;
    constexpr std::uint32_t kTooLarge = 0x477FF000U;     // 65520, which would round to 65536
    constexpr std::uint32_t kLeastNormal = 0x38800000U;  // 2^-14
    const auto bits = std::bit_cast<std::uint32_t>(value);
    const std::uint32_t sign = (bits >> 16U) & 0x8000U;
    const std::uint32_t magnitude = bits & 0x7FFFFFFFU;
    std::uint32_t half = 0;
    if (magnitude > kInfinity) {
        return kFloat16Unknown;
    }
    if (magnitude == kInfinity) {
        half = 0x7C00U;
    } else if (magnitude >= kTooLarge) {
        half = 0x7BFFU;
    } else if (magnitude < kLeastNormal) {
        // From 0.5 on, the last bit of a float is 2^-24, as in a subnormal binary16, so the sum is
        // rounded to that.
        const float sum = std::bit_cast<float>(magnitude) + 0.5F;
        half = std::bit_cast<std::uint32_t>(sum) - std::bit_cast<std::uint32_t>(0.5F);
    } else {
        const std::uint32_t to_even = 0xFFFU + ((magnitude >> 13U) & 1U);
        half = (magnitude - (112U << 23U) + to_even) >> 13U;
    }
    return static_cast<std::uint16_t>(sign | half);
}

}  // namespace tribus::dronecan
