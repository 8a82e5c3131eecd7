#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/joystick_report.h"
#include "core/pulse.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/protocol.h"

/// A USB joystick as radios are one, towards simulators (docs/protocols/joystick.md).
namespace tribus {

extern const Protocol kJoystickProtocol;

/// A button is pressed while its channel is beyond a limit, or between two, ends included.
struct JoystickButton {
    std::size_t button = 0;  ///< 0 is button 1
    std::size_t channel = 0;
    std::optional<Pulse> above{};
    std::optional<Pulse> below{};
    std::optional<std::pair<Pulse, Pulse>> between{};

    bool is_pressed(Pulse pulse) const {
        return (above && pulse > *above) || (below && pulse < *below) ||
               (between && pulse >= between->first && pulse <= between->second);
    }
};

struct JoystickSettings {
    /// The channel of each axis, in the order of kJoystickAxes.
    std::array<std::optional<std::size_t>, kJoystickAxes.size()> axes{};
    std::vector<JoystickButton> buttons;
    /// The channel whose axis goes to its lowest in silence; the others go to their centre.
    std::optional<std::size_t> throttle;
};

/// Reports of kJoystickReportBytes. An axis is 0 at 988 us and 2047 at 2011.5 us, two steps a
/// microsecond. Readers of a joystick keep its last state for ever, so in silence a report with
/// sticks at rest and no button pressed is sent.
class JoystickEncoder final : public ByteEncoder {
  public:
    explicit JoystickEncoder(JoystickSettings settings) : settings_(std::move(settings)) {}
    bool marks_frame_lost() const override { return false; }
    std::uint32_t needed_channels(const ChannelFrame& frame) const override;
    std::size_t write(const ChannelFrame& frame, std::span<std::uint8_t, kLongestSerialFrame> wire,
                      Instant now) override;
    std::size_t write_silence(std::span<std::uint8_t, kLongestSerialFrame> wire,
                              Instant now) override;

  private:
    JoystickSettings settings_;
};

}  // namespace tribus
