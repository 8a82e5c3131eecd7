#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/time.h"
#include "transports/codecs/gamepad/gamepad.h"

/// How a person shows which stick and button of a gamepad is which channel. Pure; time is an
/// argument.
namespace tribus {

/// The state of a gamepad at one instant.
struct PadSight {
    struct Axis {
        std::uint16_t code = 0;
        int position = 0;  ///< from -kFullDeflection to kFullDeflection (core/gamepad_report.h)
    };
    std::vector<Axis> axes;  ///< of one device always the same, in the same order
    std::vector<std::uint16_t> pressed;
    bool gone = false;
};

/// A whole report of the link to an input device; nothing if it is none.
std::optional<PadSight> pad_sight_of(std::span<const std::uint8_t> report);

enum class PadStep : std::uint8_t { rest, channel, dead_man, done };

/// Asks for one control after the other: hands off; channels 1 to 4, which are axes; further
/// channels, which are axes or buttons, until one is left out; a dead man's button.
class PadLesson {
  public:
    PadStep step() const { return step_; }
    /// The order to the person.
    std::string prompt() const;
    /// Who leaves the step out by going on does that: "that channel is left out".
    std::string left_out() const;

    void see(const PadSight& sight, Instant now);
    /// The control of this step was shown and let go.
    bool is_complete(Instant now) const;
    /// When something moved last; the beginning of the step if nothing did.
    Instant moved_at() const { return moved_at_; }
    /// Ends the step: takes the control that was shown, or leaves it out. Repeats a step in which
    /// something was shown that cannot be taken.
    void next(Instant now);
    /// A remark on the controls that were shown since the call before; may be empty.
    std::string take_remark();

    const GamepadSettings& learned() const { return learned_; }

  private:
    struct ShownButton {
        std::uint16_t code = 0;
        Instant since{};
        std::optional<Duration> held{};  ///< empty while it is pressed
    };

    void begin(PadStep step, Instant now);
    void remark(const std::string& text);
    /// Says why a control that was shown cannot be taken.
    void refuse(const std::string& text);
    void see_axes(const PadSight& sight);
    void see_buttons(const PadSight& sight, Instant now);
    void see_press(std::uint16_t code, Instant now);
    void see_release(std::uint16_t code, Instant now);
    bool has_moved(const PadSight& sight) const;
    bool is_let_go() const;
    void say_why_not();
    std::optional<GamepadAxis> shown_axis() const;
    std::optional<std::size_t> channel_of_axis(std::uint16_t code) const;
    std::optional<std::size_t> channel_of_button(std::uint16_t code) const;
    void leave_rest(Instant now);
    void leave_channel(Instant now);

    PadStep step_ = PadStep::rest;
    std::size_t channel_ = 0;
    GamepadSettings learned_;
    std::string remark_;
    bool has_seen_ = false;
    bool refused_ = false;  ///< something was shown in this step that cannot be taken
    PadSight latest_;
    PadSight at_begin_;      ///< of this step
    PadSight before_moved_;  ///< when something moved last
    Instant moved_at_{};
    std::vector<int> travel_;  ///< of each axis, the furthest from its place at the beginning
    std::optional<ShownButton> button_;
};

/// Lines for [input.NAME]: axes, buttons, dead_man.
std::vector<std::string> pad_lines(const GamepadSettings& learned);

/// A button that the device has and no channel uses, where a thumb or finger rests on it; empty if
/// there is none.
std::string dead_man_for(const GamepadSettings& learned, std::span<const std::uint16_t> buttons);

}  // namespace tribus
