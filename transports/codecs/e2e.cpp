#include "transports/codecs/e2e.h"

#include <array>

#include "transports/codecs/crc.h"

namespace tribus {
namespace {

constexpr std::uint8_t low_byte(std::uint16_t word) {
    return static_cast<std::uint8_t>(word);
}
constexpr std::uint8_t high_byte(std::uint16_t word) {
    return static_cast<std::uint8_t>(word >> 8);
}

// AUTOSAR's CRC-8 routine starts with FF and ends with XOR FF. Profile 1 calls it so that both
// cancel; profile 22 keeps them.
constexpr std::uint8_t kP01Start = 0x00;
constexpr std::uint8_t kP22StartAndXor = 0xFF;
constexpr std::uint16_t kP05Start = 0xFFFF;

std::uint8_t p01_id_crc(std::uint16_t data_id, P01DataId mode, bool odd_counter) {
    const std::uint8_t low = low_byte(data_id);
    const std::uint8_t high = high_byte(data_id);
    switch (mode) {
        case P01DataId::both:
            return crc8_1d(kP01Start, std::array{low, high});
        case P01DataId::alternating:
            return crc8_1d(kP01Start, std::array{odd_counter ? high : low});
        case P01DataId::nibble:
            return crc8_1d(kP01Start, std::array{low, std::uint8_t{0}});
        case P01DataId::low:
            break;
    }
    return crc8_1d(kP01Start, std::array{low});
}

}  // namespace

std::uint8_t crc8_1d(std::uint8_t start, std::span<const std::uint8_t> bytes) {
    return Crc<std::uint8_t, 0x1D>::of_few(start, bytes);
}

std::uint8_t crc8_2f(std::uint8_t start, std::span<const std::uint8_t> bytes) {
    return Crc<std::uint8_t, 0x2F>::of_few(start, bytes);
}

std::uint16_t crc16_1021(std::uint16_t start, std::span<const std::uint8_t> bytes) {
    return Crc<std::uint16_t, 0x1021>::of_few(start, bytes);
}

std::uint8_t p01_crc(std::span<const std::uint8_t> payload, std::uint16_t data_id, P01DataId mode) {
    const bool odd_counter = (payload[kE2eCounterAt] & 1U) != 0;
    return crc8_1d(p01_id_crc(data_id, mode, odd_counter), payload.subspan(kCrc8At + 1));
}

std::uint8_t p22_crc(std::span<const std::uint8_t> payload, std::uint8_t listed_id) {
    const std::uint8_t crc = crc8_2f(kP22StartAndXor, payload.subspan(kCrc8At + 1));
    return crc8_2f(crc, std::array{listed_id}) ^ kP22StartAndXor;
}

std::uint16_t p05_crc(std::span<const std::uint8_t> payload, std::uint16_t data_id,
                      std::size_t offset) {
    std::uint16_t crc = crc16_1021(kP05Start, payload.first(offset));
    crc = crc16_1021(crc, payload.subspan(offset + sizeof crc));
    return crc16_1021(crc, std::array{low_byte(data_id), high_byte(data_id)});
}

}  // namespace tribus
