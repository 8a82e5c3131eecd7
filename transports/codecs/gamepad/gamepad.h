#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/time.h"
#include "transports/codecs/framed_decoder.h"
#include "transports/codecs/protocol.h"

/// Gamepads and joysticks in a hand (docs/protocols/gamepad.md).
namespace tribus {

extern const Protocol kGamepadProtocol;

struct GamepadAxis {
    std::uint16_t code = 0;  ///< of Linux: ABS_X is 0
    std::size_t channel = 0;
    bool reverse = false;
};
struct GamepadButton {
    std::uint16_t code = 0;
    std::size_t channel = 0;
    bool toggles = false;  ///< each press changes the channel
};

struct GamepadSettings {
    std::vector<GamepadAxis> axes;
    std::vector<GamepadButton> buttons;
    /// The link counts only while this button is pressed.
    std::optional<std::uint16_t> dead_man{};
    /// The link is lost if nothing moved for so long.
    std::optional<Duration> activity_timeout{};
};

/// Reads the reports of core/gamepad_report.h. An axis is 1000 to 2000 us, a button 1000 or 2000
/// us. Frames are marked failsafe when the device is gone; after its return, and after `reset`,
/// until all sticks are at rest and then a button was pressed; while the dead man's button is not
/// pressed; after `activity_timeout`. No heap after construction.
class GamepadDecoder final : public FramedDecoder {
  public:
    explicit GamepadDecoder(GamepadSettings settings);
    void reset() override;

  private:
    std::size_t needed_bytes(std::span<const std::uint8_t> bytes) const override;
    bool check_holds(std::span<const std::uint8_t> frame) const override;
    bool read(std::span<const std::uint8_t> frame, ChannelFrame& channels) override;

    /// After a return.
    enum class Trust : std::uint8_t { full, waits_for_rest, waits_for_press };
    void set_axes(std::span<const std::uint8_t> frame, ChannelFrame& channels) const;
    void set_buttons(std::span<const std::uint8_t> frame, ChannelFrame& channels);
    bool is_at_rest(std::span<const std::uint8_t> frame) const;
    bool is_active(bool changed, Instant received);
    void judge_trust(std::span<const std::uint8_t> frame);

    GamepadSettings settings_;
    std::vector<bool> toggled_;
    /// Whether each of `settings_.buttons` was pressed in the report before.
    std::vector<bool> pressed_;
    std::size_t pressed_before_ = 0;  ///< how many of all buttons
    Trust trust_ = Trust::full;
    std::optional<Instant> changed_at_;
};

}  // namespace tribus
