#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include <tl/expected.hpp>

#include "transports/links/evdev/evdev_state.h"
#include "transports/links/link.h"
#include "transports/links/unique_fd.h"

namespace tribus {

/// A gamepad or joystick at /dev/input. Each read is one report (core/gamepad_report.h): after each
/// change, and every 20 ms, because the kernel is silent while nothing moves. Thread-bound. No heap
/// after `open`.
class EvdevLink final : public ByteLink {
  public:
    /// `grab`: no other program gets its events meanwhile. The error begins with the device and
    /// says what to do.
    static tl::expected<std::unique_ptr<EvdevLink>, std::string> open(const std::string& device,
                                                                      bool grab);

    /// When the device vanishes, a last report says so; then `lost`.
    ReadStatus read(Reception& reception) override;
    /// Nothing can be written.
    WriteStatus write(std::span<const std::uint8_t> frame) override;
    void discard_unread() override;
    int descriptor() const override { return fd_.get(); }
    int second_descriptor() const override { return timer_.get(); }

  private:
    EvdevLink(UniqueFd fd, UniqueFd timer) : fd_(std::move(fd)), timer_(std::move(timer)) {}
    void find_axes();
    void read_whole_state();
    struct Taken {
        bool any = false;   ///< an event
        bool gone = false;  ///< the device
    };
    Taken take_events();

    UniqueFd fd_;
    UniqueFd timer_;
    EvdevState state_;
    bool gone_ = false;
};

}  // namespace tribus
