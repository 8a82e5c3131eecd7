#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/channel_frame.h"
#include "transports/codecs/wire_words.h"

/// What a DSM frame carries where (docs/protocols/dsm.md, "Frame"): only for its decoder.
namespace tribus {

inline constexpr std::size_t kDsmFrameBytes = 16;
inline constexpr std::size_t kDsmWords = 7;
/// Higher numbers belong to X-Plus and other extensions.
inline constexpr std::size_t kDsmChannels = 12;

using DsmWire = std::span<const std::uint8_t, kDsmFrameBytes>;

/// Bits of a value: 10 or 11. `either` is for settings only.
enum class DsmResolution : std::uint8_t { either, bits_10, bits_11 };

/// The words of a frame without their values: numbers of channels, the mark of the phase, unused
/// words. Frames of one sender have one layout, or two by turns.
class DsmLayout {
  public:
    /// In the place of a channel, for words without one.
    static constexpr std::uint8_t kNoChannel = kChannelCount - 1;
    static_assert(kNoChannel >= kDsmChannels);

    /// No frame has it.
    DsmLayout() = default;
    /// The layout of a plausible frame; else nothing. No frame is plausible in both resolutions.
    static std::optional<DsmLayout> of(DsmWire wire, DsmResolution resolution);

    /// Whether the frame has this layout. It is then plausible.
    bool fits(const std::uint8_t* wire) const {
        return (load_word(wire) & mask_[0]) == fixed_[0] &&
               (load_word(wire + sizeof(std::uint64_t)) & mask_[1]) == fixed_[1];
    }
    /// Whether the layouts differ at most in words of an extension, which now and then take the
    /// places of others.
    bool agrees(const DsmLayout& other) const;

    /// The channel of each word, or kNoChannel.
    const std::array<std::uint8_t, kDsmWords>& words() const { return words_; }
    /// One bit for each channel.
    std::uint32_t channels() const { return channels_; }
    DsmResolution resolution() const { return resolution_; }

  private:
    void fix(std::size_t word, unsigned mask, unsigned value);
    bool add(std::size_t word, unsigned bits);

    // In the order of the wire; the first two bytes do not count.
    std::array<std::uint64_t, 2> mask_{};
    std::array<std::uint64_t, 2> fixed_{1, 0};
    std::array<std::uint8_t, kDsmWords> words_{};
    DsmResolution resolution_ = DsmResolution::bits_11;
    std::uint32_t channels_ = 0;
    /// Words of an extension, one bit each.
    std::uint32_t extensions_ = 0;
};

}  // namespace tribus
