#pragma once

#include <linux/input.h>

#include <cstdint>
#include <string>
#include <vector>

#include "transports/links/unique_fd.h"

/// Input devices of the kernel, without the code of the program.
namespace tribus::test {

/// The path of the input device with that name, or an empty text if there is none.
std::string event_device(const std::string& name);

/// A reader of an input device, as games have one.
class InputReader {
  public:
    explicit InputReader(const std::string& device);
    bool valid() const { return fd_.valid(); }
    /// The position of an axis now.
    int axis(int code) const;
    input_absinfo range(int code) const;
    bool pressed(int code) const;
    /// The codes of its axes, or of its buttons.
    std::vector<int> axes() const;
    std::vector<int> buttons() const;
    /// No other program gets its events any more.
    bool grab() const;

  private:
    UniqueFd fd_;
};

/// A gamepad that the test makes: sticks from -100 to 100, and buttons.
class VirtualGamepad {
  public:
    explicit VirtualGamepad(const std::string& name,
                            const std::vector<int>& buttons = {BTN_SOUTH, BTN_EAST, BTN_TL});
    /// Moves axes or presses buttons, all in one report.
    struct Change {
        int type = 0;
        int code = 0;
        int value = 0;
    };
    void change(const std::vector<Change>& changes) const;
    void move(int axis, int value) const { change({{EV_ABS, axis, value}}); }
    void press(int button) const { change({{EV_KEY, button, 1}}); }
    void release(int button) const { change({{EV_KEY, button, 0}}); }
    const std::string& device() const { return device_; }

  private:
    UniqueFd fd_;
    std::string device_;
};

}  // namespace tribus::test
