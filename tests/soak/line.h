#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <random>
#include <string>

#include "tests/loopback/wire.h"
#include "tests/support/far_end.h"

namespace tribus::test {

/// What one line's servos have got so far.
struct LineCounts {
    std::uint64_t good = 0;
    std::uint64_t marked = 0;   ///< frame-lost or failsafe
    std::uint64_t foreign = 0;  ///< good, with values that its receiver never sent
    std::uint64_t old = 0;      ///< good, with values of long ago
    std::uint64_t strays = 0;   ///< bytes of no frame
};

/// A receiver of i.Bus and a bank of SBUS servos, with the daemon between them. Every frame has the
/// line's number and its own in it.
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

    const LineCounts& counts() const { return counts_; }

  private:
    static constexpr std::size_t kRemembered = 4096;

    void send_noise(Clock::time_point now);
    Sticks sticks(std::uint32_t number) const;
    /// The number of the frame whose values these are.
    std::optional<std::uint32_t> number_of(const SbusSight& sight) const;

    std::size_t line_;
    FarEnd receiver_;
    FarEnd servos_;
    bool receiver_plugged_ = true;
    bool servos_plugged_ = true;
    std::optional<ServoBank> bank_;
    std::uint64_t strays_before_ = 0;
    Clock::time_point due_{};
    Clock::time_point listened_{};
    Clock::time_point silent_until_{};
    Clock::time_point babbles_until_{};
    Clock::time_point noise_from_{};
    std::minstd_rand noise_{1};
    std::uint32_t next_ = 0;
    std::array<Clock::time_point, kRemembered> sent_{};
    LineCounts counts_;
};

}  // namespace tribus::test
