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

/// A receiver of i.Bus and a bank of SBUS servos, with the daemon between them and a witness beside
/// it.
class SoakLine {
  public:
    /// Links in `folder`, "receiver3" and "servos3" for number 3.
    SoakLine(const std::filesystem::path& folder, std::size_t number);

    /// Its three tables, with the devices' paths.
    std::string configuration() const;
    /// Sends a frame if one is due and nothing is wrong with the receiver.
    void send(Clock::time_point now);
    void listen();

    /// Its receiver sends nothing until then.
    void silence(Clock::time_point until) { silent_until_ = until; }
    /// Its receiver sends nothing but noise, as much as the wire carries, until then.
    void babble(Clock::time_point until);
    void pull_receiver();
    void pull_servos();
    /// Plugs in what was pulled.
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
