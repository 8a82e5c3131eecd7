#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

/// AUTOSAR end-to-end protection, profiles 1, 5 and 22 (docs/protocols/can.md, "End-to-end
/// protection"): a counter and a CRC in the payload. The CRC also covers an id that is not sent, so
/// that a frame of another sender is not accepted. All functions are pure and reentrant.
namespace tribus {

/// CRC-8, polynomial 0x1D, most significant bit first, no final XOR.
std::uint8_t crc8_1d(std::uint8_t start, std::span<const std::uint8_t> bytes);
/// CRC-8, polynomial 0x2F, otherwise the same. Detects all errors of 1 to 3 bits in up to 127 bits,
/// which 0x1D does not.
std::uint8_t crc8_2f(std::uint8_t start, std::span<const std::uint8_t> bytes);
/// CRC-16, polynomial 0x1021, otherwise the same.
std::uint16_t crc16_1021(std::uint16_t start, std::span<const std::uint8_t> bytes);

/// The part of the 16-bit data id that enters the CRC of profile 1.
enum class P01DataId : std::uint8_t {
    both,         ///< the low byte, then the high byte
    alternating,  ///< the low byte with an even counter, the high byte with an odd one
    low,          ///< the low byte
    nibble,       ///< the low byte and a zero; the payload holds the low nibble of the high byte
};

inline constexpr std::size_t kCrc8At = 0;        ///< position of the CRC of profiles 1 and 22
inline constexpr std::size_t kE2eCounterAt = 1;  ///< position of their counter, in the low nibble

/// CRC of profile 1 over all bytes but byte 0. Needs at least 2 bytes. The counter goes from 0 to
/// 14.
std::uint8_t p01_crc(std::span<const std::uint8_t> payload, std::uint16_t data_id,
                     P01DataId mode = P01DataId::both);

/// CRC of profile 22 over all bytes but byte 0. Needs at least 1 byte. `listed_id` is the entry of
/// the data id list for the counter of this payload, which goes from 0 to 15.
std::uint8_t p22_crc(std::span<const std::uint8_t> payload, std::uint8_t listed_id);

/// CRC of profile 5 over all bytes but the two at `offset`, which hold the CRC, low byte first. The
/// next byte is the counter, 0 to 255. Needs at least `offset` + 2 bytes.
std::uint16_t p05_crc(std::span<const std::uint8_t> payload, std::uint16_t data_id,
                      std::size_t offset = 0);

}  // namespace tribus
