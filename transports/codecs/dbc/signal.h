#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "transports/codecs/dbc/file.h"

namespace tribus {

/// Where the bits of one signal are and what they mean, worked out once. "Bits" are the raw value
/// as it stands in the frame, right-aligned, with zeros above. Pure and reentrant; no heap.
class DbcLayout {
  public:
    /// Of a signal as parse_dbc() gives them: 1 to 64 bits, 32 or 64 if it is a float.
    explicit DbcLayout(const DbcSignal& signal);

    /// The least length of a frame that holds the whole signal.
    std::size_t needed_bytes() const { return needed_bytes_; }

    /// `data` has needed_bytes() or more.
    std::uint64_t raw_bits(std::span<const std::uint8_t> data) const;
    /// `data` has needed_bytes() or more. Other bits of it stay; of `bits` only the low ones count.
    void set_raw_bits(std::span<std::uint8_t> data, std::uint64_t bits) const;

    /// raw * factor + offset. Infinite or not a number if a float signal is.
    double physical(std::uint64_t bits) const;
    /// The nearest raw value, halves away from zero; the least or the greatest one if that is
    /// beyond what the signal can hold, for floats the greatest finite one. Not-a-number becomes
    /// bits of zero, so the offset. Gives back what physical() was given, as far as a double
    /// tells: raw values up to 2^53.
    std::uint64_t bits_from_physical(double physical) const;

    /// The raw value as a number, as value texts have it; the bits themselves if it is a float.
    std::int64_t raw_value(std::uint64_t bits) const;
    /// The bits of a raw value; nothing if the signal cannot hold it. The inverse of raw_value().
    std::optional<std::uint64_t> bits_from_raw(std::int64_t raw) const;

  private:
    std::size_t byte_index(unsigned significance) const {
        return motorola_ ? lowest_byte_ - significance : lowest_byte_ + significance;
    }
    double number(std::uint64_t bits) const;
    std::uint64_t bits_from_integer(double raw) const;

    DbcValueKind kind_;
    bool is_signed_;
    bool motorola_;
    unsigned bit_length_;
    /// The byte with the least significant bit, which is that many bits up in it.
    std::size_t lowest_byte_;
    unsigned shift_;
    unsigned byte_count_;
    std::size_t needed_bytes_;
    std::uint64_t mask_;
    double factor_;
    double offset_;
};

/// The greatest raw bits of a J1939 signal that are a number: SAE J1939-71 keeps what is above for
/// codes, of whole bytes all from 0xFB in the highest one on, of other lengths the two greatest
/// ("error" and "not available"). Nothing where it has no codes: of one bit, signed, or a float.
std::optional<std::uint64_t> most_j1939_bits(const DbcSignal& signal);
/// The bits that say "not available" there: all ones, which are no number of a float either.
/// Nothing where all ones are a number: of one bit, or signed.
std::optional<std::uint64_t> j1939_not_available(const DbcSignal& signal);

/// Whether this frame holds the signal: all the selectors that it depends on, through all levels,
/// have a value that selects it, and `data` is long enough. `signal` is one of `message`. Pure and
/// reentrant; no heap.
bool present(const DbcMessage& message, const DbcSignal& signal,
             std::span<const std::uint8_t> data);

}  // namespace tribus
