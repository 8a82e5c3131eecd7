#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

namespace tribus {

/// In which order a CRC takes the bits of a byte.
enum class CrcBits : std::uint8_t { highest_first, lowest_first };

/// CRC of 8 or 16 bits without a final XOR, a slice of bytes at a time. With `lowest_first` the
/// polynomial is written in that order, too. The CRC of bytes and their CRC, in the order of its
/// bits, is 0. Pure and reentrant.
template <class Word, Word polynomial, CrcBits order = CrcBits::highest_first>
class Crc {
    static_assert(sizeof(Word) <= 2);

  public:
    /// The CRC of a number of bytes that is known, without loops.
    template <std::size_t count>
    static inline Word of(Word start, std::span<const std::uint8_t, count> bytes) {
        constexpr std::size_t kFirst = (count - 1) % kSlice + 1;
        Word crc = of_bytes<kFirst>(start, bytes.data());
        for (std::size_t at = kFirst; at < count; at += kSlice) {
            crc = of_bytes<kSlice>(crc, bytes.data() + at);
        }
        return crc;
    }

    /// The same byte by byte, the shorter way for a few.
    static Word of_few(Word start, std::span<const std::uint8_t> bytes) {
        for (const std::uint8_t byte : bytes) {
            start = of_byte(start, byte);
        }
        return start;
    }

    static inline Word of(Word start, std::span<const std::uint8_t> bytes) {
        Word crc = start;
        const std::uint8_t* at = bytes.data();
        const std::size_t count = bytes.size();
        for (const std::uint8_t* const end = at + count / kSlice * kSlice; at != end;
             at += kSlice) {
            crc = of_bytes<kSlice>(crc, at);
        }
        if ((count & 4U) != 0) {
            crc = of_bytes<4>(crc, at);
            at += 4;
        }
        if ((count & 2U) != 0) {
            crc = of_bytes<2>(crc, at);
            at += 2;
        }
        return (count & 1U) != 0 ? of_byte(crc, *at) : crc;
    }

    /// The remainder of a number by the polynomial, of a CRC of 8 bits that takes the highest bits
    /// first.
    static inline Word remainder(std::uint64_t number) {
        static_assert(sizeof(Word) == 1 && order == CrcBits::highest_first);
        const auto low = static_cast<std::uint32_t>(number);
        const auto high = static_cast<std::uint32_t>(number >> 32U);
        return static_cast<Word>(low ^ kTables[0][low >> 8U & 0xFFU] ^
                                 kTables[1][low >> 16U & 0xFFU] ^ kTables[2][low >> 24U] ^
                                 kTables[3][high & 0xFFU] ^ kTables[4][high >> 8U & 0xFFU] ^
                                 kTables[5][high >> 16U & 0xFFU] ^ kTables[6][high >> 24U]);
    }

  private:
    static constexpr std::size_t kSlice = 8;
    static constexpr unsigned kBits = 8 * sizeof(Word);
    static constexpr bool kHighestFirst = order == CrcBits::highest_first;
    using Table = std::array<Word, 256>;

    static constexpr Word shifted_by_a_byte(Word crc) {
        unsigned shifted = crc;
        for (int bit = 0; bit < 8; ++bit) {
            const bool out = (shifted >> (kHighestFirst ? kBits - 1 : 0U) & 1U) != 0;
            shifted = static_cast<Word>(kHighestFirst ? shifted << 1U : shifted >> 1U) ^
                      (out ? polynomial : 0U);
        }
        return static_cast<Word>(shifted);
    }

    /// Table `n` has the effect of a byte that `n` further bytes follow, so that a slice of bytes
    /// needs no result of the byte before.
    static constexpr std::array<Table, kSlice> kTables = [] {
        std::array<Table, kSlice> tables{};
        for (std::size_t byte = 0; byte < tables[0].size(); ++byte) {
            auto crc = static_cast<Word>(kHighestFirst ? byte << (kBits - 8) : byte);
            for (Table& table : tables) {
                crc = shifted_by_a_byte(crc);
                table[byte] = crc;
            }
        }
        return tables;
    }();

    /// The part of the CRC so far that the byte at that position of a slice meets.
    template <std::size_t at>
    static unsigned met_by(Word crc) {
        if constexpr (at >= sizeof(Word)) {
            return 0;
        } else {
            return crc >> (kHighestFirst ? kBits - 8 - 8 * at : 8 * at) & 0xFFU;
        }
    }
    template <std::size_t... at>
    static Word of_slice(Word crc, const std::uint8_t* bytes, std::index_sequence<at...>) {
        constexpr std::size_t kLast = sizeof...(at) - 1;
        return static_cast<Word>((... ^ kTables[kLast - at][bytes[at] ^ met_by<at>(crc)]));
    }
    template <std::size_t count>
    static inline Word of_bytes(Word crc, const std::uint8_t* bytes) {
        if constexpr (count < sizeof(Word)) {
            return of_byte(crc, *bytes);
        } else {
            return of_slice(crc, bytes, std::make_index_sequence<count>());
        }
    }
    static Word of_byte(Word crc, std::uint8_t byte) {
        if constexpr (sizeof(Word) == 1) {
            return kTables[0][crc ^ byte];
        } else if constexpr (kHighestFirst) {
            return static_cast<Word>(crc << 8U ^ kTables[0][crc >> (kBits - 8) ^ byte]);
        } else {
            return static_cast<Word>(crc >> 8U ^ kTables[0][(crc ^ byte) & 0xFFU]);
        }
    }
};

}  // namespace tribus
