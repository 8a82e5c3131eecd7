#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "transports/codecs/dbc/file.h"

namespace tribus {

/// Position and meaning of the bits of one signal. "Bits" are the raw value as in the frame,
/// right-aligned, with zeros above. Pure and reentrant; no heap.
class DbcLayout {
  public:
    /// `signal` as from parse_dbc(): 1 to 64 bits, 32 or 64 if it is a float.
    explicit DbcLayout(const DbcSignal& signal);

    /// Least length of a frame that holds the whole signal, in bytes.
    std::size_t needed_bytes() const { return needed_bytes_; }

    /// `data` must have needed_bytes().
    std::uint64_t raw_bits(std::span<const std::uint8_t> data) const;
    /// `data` must have needed_bytes(). Its other bits stay; higher bits of `bits` are ignored.
    void set_raw_bits(std::span<std::uint8_t> data, std::uint64_t bits) const;

    /// raw * factor + offset. Infinite or not a number if a float signal is.
    double physical(std::uint64_t bits) const;
    /// The nearest raw value, halves away from zero, limited to the range of the signal; for floats
    /// to finite numbers. Not-a-number gives zero bits, which mean the offset. Inverse of
    /// physical() for raw values that a double holds, up to 2^53.
    std::uint64_t bits_from_physical(double physical) const;

    /// The raw value as a number, as in value texts. For a float: the bits.
    std::int64_t raw_value(std::uint64_t bits) const;
    /// The bits of a raw value; nothing if the signal cannot hold it. Inverse of raw_value().
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
    /// The byte with the least significant bit, and the position of that bit in it.
    std::size_t lowest_byte_;
    unsigned shift_;
    unsigned byte_count_;
    std::size_t needed_bytes_;
    std::uint64_t mask_;
    double factor_;
    double offset_;
};

/// The greatest raw bits of a J1939 signal that are a number. SAE J1939-71 uses higher ones for
/// codes: in signals of whole bytes those with a highest byte of 0xFB or more, in other signals the
/// two greatest ("error" and "not available"). Nothing if the signal has no codes: one bit, signed,
/// or a float.
std::optional<std::uint64_t> most_j1939_bits(const DbcSignal& signal);
/// The bits that mean "not available" in J1939: all ones, which are no number in a float either.
/// Nothing if all ones are a number: one bit, or signed.
std::optional<std::uint64_t> j1939_not_available(const DbcSignal& signal);

/// Whether a frame holds the signal: `data` is long enough, and all selectors on which the signal
/// depends have selecting values. `signal` must be one of `message`. Pure and reentrant; no heap.
bool present(const DbcMessage& message, const DbcSignal& signal,
             std::span<const std::uint8_t> data);

}  // namespace tribus
