#include "transports/codecs/dsm/layout.h"

#include <bit>

#include "transports/codecs/big_endian.h"

namespace tribus {
namespace {

constexpr unsigned kUnusedWord = 0xFFFF;
constexpr unsigned kPhaseBit = 0x8000;
/// Senders of 10 bits have seven channels. With at least five of them, two have numbers that differ
/// in the lowest bit only. In 11 bits both are the same number, which is not plausible, so no frame
/// is plausible in both resolutions.
constexpr unsigned kMostChannelOf10Bits = 6;
constexpr int kLeastWordsOf10Bits = 5;
/// Number 12, with any phase: X-Plus channels, settings of a video transmitter.
constexpr unsigned kExtensionMask = 0x7800;
constexpr unsigned kExtension = 12U << 11U;
/// Settings of a video transmitter take two words.
constexpr int kMostExtensions = 2;

constexpr unsigned value_bits(DsmResolution resolution) {
    return resolution == DsmResolution::bits_10 ? 10 : 11;
}

}  // namespace

void DsmLayout::fix(std::size_t word, unsigned mask, unsigned value) {
    const std::size_t at = 2 + 2 * word;
    const std::size_t half = at / sizeof(std::uint64_t);
    // The high byte of a word is first on the wire, so it is the lower one of the two.
    const auto shift = static_cast<unsigned>(8 * (at % sizeof(std::uint64_t)));
    mask_[half] |= std::uint64_t{mask >> 8U | (mask & 0xFFU) << 8U} << shift;
    fixed_[half] |= std::uint64_t{value >> 8U | (value & 0xFFU) << 8U} << shift;
}

/// Returns false if no plausible frame has this word.
bool DsmLayout::add(std::size_t word, unsigned bits) {
    if (bits == kUnusedWord) {
        fix(word, kUnusedWord, bits);
        return true;
    }
    const bool fine = resolution_ == DsmResolution::bits_11;
    if (fine && word != 0 && (bits & kExtensionMask) == kExtension) {
        fix(word, kExtensionMask, kExtension);
        extensions_ |= 1U << word;
        return true;
    }
    const unsigned shift = value_bits(resolution_);
    const unsigned channel = (word == 0 ? bits & ~kPhaseBit : bits) >> shift;
    const unsigned most = fine ? kDsmChannels - 1 : kMostChannelOf10Bits;
    if (channel > most || (channels_ >> channel & 1U) != 0) {
        return false;
    }
    const unsigned mask = kUnusedWord & ~((1U << shift) - 1);
    fix(word, mask, bits & mask);
    channels_ |= 1U << channel;
    words_[word] = static_cast<std::uint8_t>(channel);
    return true;
}

std::optional<DsmLayout> DsmLayout::of(DsmWire wire, DsmResolution resolution) {
    if (resolution == DsmResolution::either) {
        const auto fine = of(wire, DsmResolution::bits_11);
        return fine ? fine : of(wire, DsmResolution::bits_10);
    }
    DsmLayout layout;
    layout.fixed_ = {};
    layout.words_.fill(kNoChannel);
    layout.resolution_ = resolution;
    for (std::size_t word = 0; word < kDsmWords; ++word) {
        if (!layout.add(word, big_endian_at(wire, 2 + 2 * word))) {
            return std::nullopt;
        }
    }
    const int least = resolution == DsmResolution::bits_10 ? kLeastWordsOf10Bits : 1;
    if (std::popcount(layout.channels_) < least ||
        std::popcount(layout.extensions_) > kMostExtensions) {
        return std::nullopt;
    }
    return layout;
}

bool DsmLayout::agrees(const DsmLayout& other) const {
    if (resolution_ != other.resolution_) {
        return false;
    }
    std::array<std::uint64_t, 2> counts{~std::uint64_t{0}, ~std::uint64_t{0}};
    for (std::size_t word = 0; word < kDsmWords; ++word) {
        if (((extensions_ | other.extensions_) >> word & 1U) != 0) {
            const std::size_t at = 2 + 2 * word;
            counts[at / sizeof(std::uint64_t)] &=
                ~(std::uint64_t{0xFFFF} << 8 * (at % sizeof(std::uint64_t)));
        }
    }
    for (std::size_t half = 0; half < counts.size(); ++half) {
        if (((mask_[half] ^ other.mask_[half]) & counts[half]) != 0 ||
            ((fixed_[half] ^ other.fixed_[half]) & counts[half]) != 0) {
            return false;
        }
    }
    return true;
}

}  // namespace tribus
