#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <random>
#include <string>

#include "tests/loopback/wire.h"
#include "tests/loopback/witness.h"
#include "tests/support/far_end.h"

namespace tribus::test {

/// An i.Bus receiver and SBUS servos with the daemon between them, and a witness that checks the
/// servos' frames.
class SoakLine {
  public:
    /// Creates links in `folder`: "receiver3" and "servos3" for number 3.
    SoakLine(const std::filesystem::path& folder, std::size_t number);

    /// Configuration text: three tables with the paths of the devices.
    std::string configuration() const;
    /// Sends a frame if one is due and the receiver has no trouble.
    void send(Clock::time_point now);
    void listen();

    /// The receiver sends nothing until then.
    void silence(Clock::time_point until) { silent_until_ = until; }
    /// The receiver sends only noise until then, as much as the wire carries.
    void babble(Clock::time_point until);
    void pull_receiver();
    void pull_servos();
    /// Plugs the unplugged devices in again.
    void plug_in();

    const Testimony& testimony() const { return witness_.testimony(); }

  private:
    void send_noise(Clock::time_point now);

    std::size_t line_;
    FarEnd receiver_;
    FarEnd servos_;
    bool receiver_plugged_ = true;
    bool servos_plugged_ = true;
    Witness witness_;
    Clock::time_point due_{};
    Clock::time_point silent_until_{};
    Clock::time_point babbles_until_{};
    Clock::time_point noise_from_{};
    std::minstd_rand noise_{1};
};

}  // namespace tribus::test
