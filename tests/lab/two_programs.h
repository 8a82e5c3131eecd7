#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/lab/guest.h"
#include "tests/loopback/loopback.h"

/// The main job with a link in between: one program reads an i.Bus receiver and sends on CAN or
/// UDP, another one reads that and drives SBUS servos.
namespace tribus::test {

/// Configuration of the two sides. The times are long enough for an emulated machine on a busy
/// host.
struct BusJob {
    std::string sender_interface = "vcan0";  ///< none if empty, like the reader's
    std::string reader_interface = "vcan0";
    std::string format = "protocol = \"can\"";  ///< lines of both sides
    std::string sender_lines{};                 ///< lines of the sender's output
    std::string reader_lines{};                 ///< lines of the reader's input
    std::string sender_tables{};                ///< further tables of the sender
    std::string reader_tables{};                ///< further tables of the reader
};

inline std::ostream& operator<<(std::ostream& out, const BusJob& job) {
    return out << job.format;
}

class TwoPrograms : public Loopback {
  protected:
    static constexpr std::chrono::milliseconds kTimeout{400};
    static constexpr std::chrono::milliseconds kHold{300};
    static constexpr std::chrono::milliseconds kRecover{300};

    FarEnd& receiver() { return receiver_; }
    ServoBank& servos() { return bank_; }
    /// How often the machine stopped this receiver nearly as long as the timeout. The programs may
    /// tell as many losses.
    std::size_t outages() const { return outages_; }

    static std::string sender_text(const BusJob& job);
    static std::string reader_text(const BusJob& job);
    Program& start_sender(const BusJob& job);
    Program& start_reader(const BusJob& job);

    /// Every change of the sticks in the capture of an 18-channel receiver comes out exactly.
    void expect_recorded_sticks(const Program& sender, const Program& reader);

    /// Sends i.Bus frames at a receiver's rate and reads what the servos see until `done` returns
    /// true for a frame. Returns false when kPatience is over.
    bool carry_until(const std::function<bool(const SbusSight&)>& done);
    bool carry_until_control();
    bool carry_until_failsafe();
    /// Goes on for this time and returns all that the servos saw.
    std::vector<SbusSight> carry_for(std::chrono::milliseconds time);

    /// Effects of a fault at the servos, measured from the fault and from its end.
    struct Outcome {
        std::chrono::milliseconds to_frame_lost{};
        std::chrono::milliseconds to_failsafe{};
        std::chrono::milliseconds to_control{};
    };
    /// Causes the fault, waits for failsafe, ends the fault and waits for control. The test fails
    /// if a good frame has other sticks than the receiver's. Adds a line to the table.
    Outcome expect_failsafe_and_recovery(const std::string& name,
                                         const std::function<void()>& fault,
                                         const std::function<void()>& end_of_fault);
    /// Checks that nothing happens earlier than configured. The table shows how much later it
    /// happens; there is no limit, because an emulated machine stalls now and then.
    static void expect_times(const Outcome& outcome);
    /// Checks the time from the last sent frame to the servos' failsafe: timeout plus hold, minus
    /// at most the periods for which the frames on the way count. A stalled emulated machine may
    /// add seconds.
    static void expect_failsafe_time(Clock::duration since_last_frame,
                                     std::chrono::milliseconds periods);

  private:
    void send_if_due();

    FarEnd& receiver_ = device("receiver");
    FarEnd& servo_wire_ = device("servos");
    ServoBank bank_{servo_wire_};
    Repeater repeater_{receiver_, ibus_bytes(sticks_with_first(1234))};
    std::size_t outages_ = 0;
};

}  // namespace tribus::test
