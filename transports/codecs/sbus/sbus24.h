#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

/// FrSky's SBUS with 24 channels: frames of 36 bytes, of which no decoder reads the channels
/// (docs/protocols/sbus.md, "24 channels").
namespace tribus {

inline constexpr std::size_t kSbus24FrameLength = 36;

/// What to tell people who have it.
inline constexpr std::string_view kSbus24Text =
    "FrSky's SBUS with 24 channels (36 bytes), which tribus does not read; set the receiver to 16 "
    "channels";

/// Whether the bytes are a frame: header 0F, 24 channels of 11 bits, flags, footer 00.
inline bool is_sbus24_frame(std::span<const std::uint8_t, kSbus24FrameLength> bytes) {
    constexpr std::uint8_t kFirstByte = 0x0F;
    constexpr std::uint8_t kMostFlags = 0x0F;
    return bytes.front() == kFirstByte && bytes[kSbus24FrameLength - 2] <= kMostFlags &&
           bytes.back() == 0;
}

/// Counts such frames on a line by content: two in a row prove each other. Thread-bound.
class Sbus24Watch {
  public:
    void take(std::span<const std::uint8_t> bytes) {
        for (const std::uint8_t byte : bytes) {
            std::rotate(latest_.begin(), latest_.begin() + 1, latest_.end());
            latest_.back() = byte;
            const std::span<const std::uint8_t, 2 * kSbus24FrameLength> both(latest_);
            if (is_sbus24_frame(both.first<kSbus24FrameLength>()) &&
                is_sbus24_frame(both.last<kSbus24FrameLength>())) {
                frames_ += frames_ == 0 ? 2 : 1;
            }
        }
    }
    std::uint64_t frames() const { return frames_; }

  private:
    std::array<std::uint8_t, 2 * kSbus24FrameLength> latest_{};
    std::uint64_t frames_ = 0;
};

}  // namespace tribus
