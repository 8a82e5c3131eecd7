#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include <fmt/format.h>

namespace tribus {

/// Tells texts apart: 16 hex digits (FNV-1a, 64 bits). No protection against somebody who looks for
/// two texts with the same. Pure.
inline std::string fingerprint(std::string_view text) {
    constexpr std::uint64_t kOffset = 0xCBF29CE484222325;
    constexpr std::uint64_t kPrime = 0x100000001B3;
    std::uint64_t hash = kOffset;
    for (const char c : text) {
        hash = (hash ^ static_cast<unsigned char>(c)) * kPrime;
    }
    return fmt::format("{:016x}", hash);
}

}  // namespace tribus
