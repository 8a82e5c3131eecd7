#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <string_view>

#include "tests/loopback/wire.h"
#include "tests/loopback/witness.h"
#include "tests/support/far_end.h"

namespace tribus::test {

/// A receiver of i.Bus (even numbers, every 7 ms) or SBUS (odd numbers, every 14 ms), its line
/// through the program, and the SBUS servos behind it, with a witness. Every channel moves with
/// every frame.
class WitnessedLine {
  public:
    static constexpr std::chrono::milliseconds kOutputPeriod{7};

    /// An unmarked frame may be as old as `most_age`.
    WitnessedLine(FarEnd& receiver, FarEnd& servos, unsigned number, Clock::duration most_age,
                  MachineStops& stops);

    /// Configuration text: three tables with lines for the input and for failsafe.
    std::string configuration(std::string_view input, std::string_view failsafe) const;

    /// Sends a frame if one is due, and checks what came.
    void turn();
    Witness& witness() { return witness_; }
    bool has_checksum() const { return ibus_; }

    /// This share of the frames loses a byte, gets an extra byte, or loses its beginning or its
    /// end.
    void hurt_frames(double share) { hurt_share_ = share; }
    std::uint64_t hurt() const { return hurt_; }
    void silence(Clock::time_point until) { silent_until_ = until; }
    /// Unplugs the receiver in the middle of a frame.
    void pull_in_a_frame();
    /// Plugs the receiver in, in the middle of another frame. Call `go_on` when the program has
    /// opened it.
    void plug_in();
    void go_on();

  private:
    Bytes frame();
    void send(Bytes frame);
    Bytes damaged(Bytes frame);

    FarEnd& receiver_;
    FarEnd& servos_;
    unsigned number_;
    bool ibus_;
    Witness witness_;
    std::minstd_rand random_;
    Clock::time_point due_;
    Clock::time_point silent_until_{};
    double hurt_share_ = 0;
    std::uint64_t hurt_ = 0;
    bool pulled_ = false;
};

}  // namespace tribus::test
