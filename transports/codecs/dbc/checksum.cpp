#include "transports/codecs/dbc/checksum.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "core/can_frame.h"
#include "transports/codecs/e2e.h"

namespace tribus {
namespace {

constexpr std::uint8_t kCrcStartAndXor = 0xFF;

using Bytes = std::span<const std::uint8_t>;

std::uint8_t exclusive_or(Bytes bytes) {
    return std::accumulate(bytes.begin(), bytes.end(), std::uint8_t{0},
                           [](std::uint8_t a, std::uint8_t b) -> std::uint8_t { return a ^ b; });
}

std::uint8_t sum(Bytes bytes, std::size_t start) {
    return static_cast<std::uint8_t>(std::accumulate(bytes.begin(), bytes.end(), start));
}

}  // namespace

std::uint64_t dbc_checksum(const DbcChecksum& checksum, std::uint32_t id, Bytes data) {
    const std::size_t own = checksum.byte;
    std::array<std::uint8_t, kMostFdBytes> copy{};
    const auto before = std::ranges::copy(data.first(own), copy.begin()).out;
    std::ranges::copy(data.subspan(own + 1), before);
    const Bytes others = Bytes(copy).first(data.size() - 1);
    switch (checksum.kind) {
        case DbcChecksumKind::xor8:
            return exclusive_or(others);
        case DbcChecksumKind::sum8:
            return sum(others, 0);
        case DbcChecksumKind::agilex:
            return sum(others, id + (id >> 8U) + data.size());
        case DbcChecksumKind::crc8_1d:
            return crc8_1d(kCrcStartAndXor, others) ^ kCrcStartAndXor;
        case DbcChecksumKind::crc8_2f:
            return crc8_2f(kCrcStartAndXor, others) ^ kCrcStartAndXor;
        case DbcChecksumKind::p01:
            return p01_crc(data, checksum.data_id);
        case DbcChecksumKind::p05:
            break;
    }
    return p05_crc(data, checksum.data_id);
}

}  // namespace tribus
