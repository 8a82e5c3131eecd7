#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace tribus {

inline constexpr std::size_t kSecretKeyBytes = 32;

/// A secret that two ends share. Its memory is cleared at the end.
struct SecretKey : std::array<std::uint8_t, kSecretKeyBytes> {
    ~SecretKey() { ::explicit_bzero(data(), size()); }
};

}  // namespace tribus
