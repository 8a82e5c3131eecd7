#pragma once

#include <bit>
#include <cstdint>

/// IEEE 754 binary16, in which DroneCAN sends most measurements. Pure; not libm.
namespace tribus::dronecan {

/// What nodes put where they do not know the value (docs/protocols/can.md, "DroneCAN: telemetry").
/// Others write 0x7FFF.
inline constexpr std::uint16_t kFloat16Unknown = 0x7E00;

/// Exact. Whatever is not a number, in any of its encodings, is a NaN.
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

/// The nearest one, to even if there are two. Saturated as DSDL's casts are by default: what is
/// too large becomes +-65504, but infinite stays infinite. NaN becomes kFloat16Unknown.
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
        // The last place of a float from 0.5 on is 2^-24, that of a subnormal binary16: the sum is
        // rounded to it.
        const float sum = std::bit_cast<float>(magnitude) + 0.5F;
        half = std::bit_cast<std::uint32_t>(sum) - std::bit_cast<std::uint32_t>(0.5F);
    } else {
        const std::uint32_t to_even = 0xFFFU + ((magnitude >> 13U) & 1U);
        half = (magnitude - (112U << 23U) + to_even) >> 13U;
    }
    return static_cast<std::uint16_t>(sign | half);
}

}  // namespace tribus::dronecan
