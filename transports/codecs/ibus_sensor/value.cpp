#include <algorithm>
#include <cmath>
#include <limits>

#include "core/rounding.h"
#include "transports/codecs/ibus_sensor/types.h"

namespace tribus {
namespace {

constexpr unsigned kByteBits = 8;
constexpr unsigned kMostBits = 64;
/// From here on, every double is whole.
constexpr double kAlwaysWhole = 9007199254740992.0;

std::uint64_t mask_of(const SensorField& field) {
    return field.bits >= kMostBits ? ~std::uint64_t{0} : (std::uint64_t{1} << field.bits) - 1;
}

std::int64_t least_of(const SensorField& field) {
    if (field.least) {
        return *field.least;
    }
    const bool has_sign = field.is_signed && field.bits > 0;
    return has_sign ? -static_cast<std::int64_t>(mask_of(field) >> 1U) - 1 : 0;
}

std::int64_t most_of(const SensorField& field) {
    constexpr std::int64_t kMostSum = std::numeric_limits<std::int64_t>::max();
    const std::int64_t least = least_of(field);
    const std::uint64_t room =
        static_cast<std::uint64_t>(kMostSum) - static_cast<std::uint64_t>(least);
    const std::uint64_t span = mask_of(field);
    return span >= room ? kMostSum
                        : static_cast<std::int64_t>(static_cast<std::uint64_t>(least) + span);
}

bool fits(const SensorField& field, std::size_t bytes) {
    return field.bits <= kMostBits && field.first_bit + field.bits <= bytes * kByteBits;
}

/// Position of a bit in a value whose lowest byte comes first.
struct BitPlace {
    std::size_t byte;
    unsigned bit;
};
BitPlace place_of(unsigned bit) {
    return {.byte = bit / kByteBits, .bit = bit % kByteBits};
}

}  // namespace

std::optional<std::int64_t> raw_in(const SensorField& field, std::span<const std::uint8_t> data) {
    if (!fits(field, data.size())) {
        return std::nullopt;
    }
    std::uint64_t bits = 0;
    for (unsigned done = 0; done < field.bits;) {
        const BitPlace place = place_of(field.first_bit + done);
        bits |= static_cast<std::uint64_t>(data[place.byte] >> place.bit) << done;
        done += kByteBits - place.bit;
    }
    const auto least = static_cast<std::uint64_t>(least_of(field));
    // Counted upwards from the least raw value, within the bits of the field.
    return static_cast<std::int64_t>(least + ((bits - least) & mask_of(field)));
}

std::optional<std::uint64_t> plain_raw_in(std::span<const std::uint8_t> data) {
    if (data.size() > sizeof(std::uint64_t)) {
        return std::nullopt;
    }
    std::uint64_t raw = 0;
    for (std::size_t i = data.size(); i-- > 0;) {
        raw = raw << kByteBits | data[i];
    }
    return raw;
}

void put_raw(const SensorField& field, std::int64_t raw, std::span<std::uint8_t> data) {
    if (!fits(field, data.size())) {
        return;
    }
    const std::uint64_t bits = static_cast<std::uint64_t>(raw) & mask_of(field);
    for (unsigned done = 0; done < field.bits;) {
        const BitPlace place = place_of(field.first_bit + done);
        const unsigned here = std::min(kByteBits - place.bit, field.bits - done);
        const unsigned mask = ((1U << here) - 1U) << place.bit;
        const auto part = static_cast<unsigned>(bits >> done) << place.bit;
        data[place.byte] = static_cast<std::uint8_t>((data[place.byte] & ~mask) | (part & mask));
        done += here;
    }
}

std::optional<double> number_of(const SensorField& field, std::int64_t raw) {
    if (raw == field.not_available) {
        return std::nullopt;
    }
    return static_cast<double>(raw) * field.scale + field.offset;
}

std::int64_t raw_of(const SensorField& field, double number) {
    const std::int64_t least = least_of(field);
    const std::int64_t most = most_of(field);
    const double exact = (number - field.offset) / field.scale;
    if (exact != exact) {
        return field.not_available.value_or(std::clamp<std::int64_t>(0, least, most));
    }
    std::int64_t raw = 0;
    if (exact >= static_cast<double>(most)) {
        raw = most;
    } else if (exact <= static_cast<double>(least)) {
        raw = least;
    } else {
        const bool whole = exact >= kAlwaysWhole || exact <= -kAlwaysWhole;
        raw = whole ? static_cast<std::int64_t>(exact) : nearest_whole(exact);
    }
    if (raw != field.not_available) {
        return raw;
    }
    return raw > least ? raw - 1 : raw + 1;
}

bool lacks_sign_for(const SensorField& field, double number) {
    if (!(number < 0)) {
        return false;
    }
    const double sent = static_cast<double>(raw_of(field, number)) * field.scale + field.offset;
    return sent >= 0 && sent - number > std::abs(field.scale) / 2;
}

}  // namespace tribus
