#pragma once

#include <cstdint>
#include <span>
#include <variant>

#include "core/can_frame.h"

namespace tribus {

/// What a codec hands to a link: the bytes of one frame, or CAN frames in sending order. Empty:
/// nothing to send.
class Transmission {
  public:
    Transmission() = default;
    explicit Transmission(std::span<const std::uint8_t> bytes) : content_(bytes) {}
    explicit Transmission(std::span<const CanFrame> frames) : content_(frames) {}

    bool empty() const {
        return std::visit([](const auto& content) { return content.empty(); }, content_);
    }
    /// Empty if it is CAN frames.
    std::span<const std::uint8_t> bytes() const {
        const auto* bytes = std::get_if<std::span<const std::uint8_t>>(&content_);
        return bytes != nullptr ? *bytes : std::span<const std::uint8_t>();
    }
    /// Empty if it is bytes.
    std::span<const CanFrame> can_frames() const {
        const auto* frames = std::get_if<std::span<const CanFrame>>(&content_);
        return frames != nullptr ? *frames : std::span<const CanFrame>();
    }

  private:
    std::variant<std::span<const std::uint8_t>, std::span<const CanFrame>> content_;
};

}  // namespace tribus
