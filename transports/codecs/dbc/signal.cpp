#include "transports/codecs/dbc/signal.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/rounding.h"

namespace tribus {
namespace {

constexpr unsigned kBitsPerByte = 8;

double finite(double value, double most) {
    return std::clamp(value, -most, most);
}

/// Position of a bit in wire order. Motorola numbers the bits of a byte downwards and its bytes
/// upwards; in wire order both go upwards.
unsigned wire_position(unsigned bit) {
    return bit / kBitsPerByte * kBitsPerByte + (kBitsPerByte - 1 - bit % kBitsPerByte);
}

}  // namespace

DbcLayout::DbcLayout(const DbcSignal& signal)
    : kind_(signal.kind),
      is_signed_(signal.is_signed),
      motorola_(signal.byte_order == DbcByteOrder::motorola),
      bit_length_(signal.bit_length),
      lowest_byte_(signal.start_bit / kBitsPerByte),
      shift_(signal.start_bit % kBitsPerByte),
      byte_count_((shift_ + bit_length_ + kBitsPerByte - 1) / kBitsPerByte),
      needed_bytes_(lowest_byte_ + byte_count_),
      mask_(~std::uint64_t{0} >> (kLongestDbcSignal - bit_length_)),
      factor_(signal.factor),
      offset_(signal.offset) {
    if (motorola_) {
        const unsigned last = wire_position(signal.start_bit) + bit_length_ - 1;
        lowest_byte_ = last / kBitsPerByte;
        shift_ = kBitsPerByte - 1 - last % kBitsPerByte;
        byte_count_ = (shift_ + bit_length_ + kBitsPerByte - 1) / kBitsPerByte;
        needed_bytes_ = lowest_byte_ + 1;
    }
}

// A signal of 64 bits may touch nine bytes. Then shift_ is not 0, so the ninth is shifted by less
// than 64.
std::uint64_t DbcLayout::raw_bits(std::span<const std::uint8_t> data) const {
    std::uint64_t bits = std::uint64_t{data[lowest_byte_]} >> shift_;
    for (unsigned at = 1; at < byte_count_; ++at) {
        bits |= std::uint64_t{data[byte_index(at)]} << (at * kBitsPerByte - shift_);
    }
    return bits & mask_;
}

void DbcLayout::set_raw_bits(std::span<std::uint8_t> data, std::uint64_t bits) const {
    const std::uint64_t value = bits & mask_;
    const auto put = [&](unsigned at, std::uint64_t byte, std::uint64_t own) {
        std::uint8_t& target = data[byte_index(at)];
        target = static_cast<std::uint8_t>((target & ~own) | byte);
    };
    put(0, value << shift_, mask_ << shift_);
    for (unsigned at = 1; at < byte_count_; ++at) {
        const unsigned down = at * kBitsPerByte - shift_;
        put(at, value >> down, mask_ >> down);
    }
}

std::int64_t DbcLayout::raw_value(std::uint64_t bits) const {
    const unsigned unused = kLongestDbcSignal - bit_length_;
    const bool extends = is_signed_ && kind_ == DbcValueKind::integer;
    return extends ? static_cast<std::int64_t>(bits << unused) >> unused
                   : static_cast<std::int64_t>(bits);
}

std::optional<std::uint64_t> DbcLayout::bits_from_raw(std::int64_t raw) const {
    const std::uint64_t bits = static_cast<std::uint64_t>(raw) & mask_;
    return raw_value(bits) == raw ? std::optional(bits) : std::nullopt;
}

double DbcLayout::number(std::uint64_t bits) const {
    switch (kind_) {
        case DbcValueKind::float32:
            return double{std::bit_cast<float>(static_cast<std::uint32_t>(bits))};
        case DbcValueKind::float64:
            return std::bit_cast<double>(bits);
        case DbcValueKind::integer:
            break;
    }
    return is_signed_ ? static_cast<double>(raw_value(bits)) : static_cast<double>(bits);
}

double DbcLayout::physical(std::uint64_t bits) const {
    return number(bits) * factor_ + offset_;
}

std::uint64_t DbcLayout::bits_from_physical(double physical) const {
    const double raw = (physical - offset_) / factor_;
    if (std::isnan(raw)) {
        return 0;
    }
    switch (kind_) {
        case DbcValueKind::float32:
            return std::bit_cast<std::uint32_t>(
                static_cast<float>(finite(raw, double{std::numeric_limits<float>::max()})));
        case DbcValueKind::float64:
            return std::bit_cast<std::uint64_t>(finite(raw, std::numeric_limits<double>::max()));
        case DbcValueKind::integer:
            break;
    }
    constexpr double kWholeFromHere = 0x1p52;
    const bool may_be_broken = std::abs(raw) < kWholeFromHere;
    return bits_from_integer(may_be_broken ? static_cast<double>(nearest_whole(raw)) : raw);
}

// The limits are compared as powers of two, which a double holds exactly. Where it does not hold
// `greatest`, the conversion rounds that up to the next power itself.
std::uint64_t DbcLayout::bits_from_integer(double raw) const {
    const std::uint64_t greatest = is_signed_ ? mask_ >> 1U : mask_;
    const double beyond = static_cast<double>(greatest) + 1;
    const double least = is_signed_ ? -beyond : 0;
    if (raw >= beyond) {
        return greatest;
    }
    if (raw <= least) {
        return is_signed_ ? greatest + 1 : 0;
    }
    return is_signed_ ? static_cast<std::uint64_t>(static_cast<std::int64_t>(raw)) & mask_
                      : static_cast<std::uint64_t>(raw);
}

std::optional<std::uint64_t> most_j1939_bits(const DbcSignal& signal) {
    const bool coded =
        signal.kind == DbcValueKind::integer && !signal.is_signed && signal.bit_length > 1;
    if (!coded) {
        return std::nullopt;
    }
    const std::uint64_t ones = ~std::uint64_t{0} >> (kLongestDbcSignal - signal.bit_length);
    constexpr std::uint64_t kCodesOfHighestByte = 0xFF - 0xFA;
    const bool whole_bytes = signal.bit_length % kBitsPerByte == 0;
    return whole_bytes ? ones - (kCodesOfHighestByte << (signal.bit_length - kBitsPerByte))
                       : ones - 2;
}

std::optional<std::uint64_t> j1939_not_available(const DbcSignal& signal) {
    const bool coded = signal.kind != DbcValueKind::integer || most_j1939_bits(signal);
    return coded ? std::optional(~std::uint64_t{0} >> (kLongestDbcSignal - signal.bit_length))
                 : std::nullopt;
}

bool present(const DbcMessage& message, const DbcSignal& signal,
             std::span<const std::uint8_t> data) {
    if (DbcLayout(signal).needed_bytes() > data.size()) {
        return false;
    }
    const DbcSignal* selected = &signal;
    for (std::size_t depth = 0; selected->selector && depth < kDeepestDbcMultiplexing; ++depth) {
        const DbcSignal& selector = message.signals[*selected->selector];
        const DbcLayout layout(selector);
        if (layout.needed_bytes() > data.size()) {
            return false;
        }
        const std::uint64_t value = layout.raw_bits(data);
        const bool selects = std::any_of(selected->selected_by.begin(), selected->selected_by.end(),
                                         [&](const DbcSelectorRange& range) {
                                             return range.first <= value && value <= range.last;
                                         });
        if (!selects) {
            return false;
        }
        selected = &selector;
    }
    return !selected->page_unknown;
}

}  // namespace tribus
