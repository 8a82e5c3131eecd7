#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/lab/guest.h"
#include "tests/loopback/loopback.h"

/// The main job with a bus in between: one program reads an i.Bus receiver and sends on CAN, a
/// second one reads CAN and drives SBUS servos.
namespace tribus::test {

/// How the two sides are set up. Times are long enough for an emulated machine that another
/// program keeps busy.
struct BusJob {
    std::string sender_interface = "vcan0";
    std::string reader_interface = "vcan0";
    std::string format = "protocol = \"can\"";  ///< lines that both sides have
    std::string sender_lines{};                 ///< of the sender's output alone
    std::string sender_tables{};                ///< tables that the sender has besides
    std::string reader_tables{};                ///< and the reader
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

    static std::string sender_text(const BusJob& job);
    static std::string reader_text(const BusJob& job);
    Program& start_sender(const BusJob& job);
    Program& start_reader(const BusJob& job);

    /// Sends i.Bus frames at a receiver's rate, and collects what the servos see, until `done` says
    /// so of a frame; false if patience ends first.
    bool carry_until(const std::function<bool(const SbusSight&)>& done);
    bool carry_until_control();
    bool carry_until_failsafe();
    /// Goes on for so long and gives all that the servos saw.
    std::vector<SbusSight> carry_for(std::chrono::milliseconds time);

    /// What a fault did to the servos, from the moment of the fault on, and of its end.
    struct Outcome {
        std::chrono::milliseconds to_frame_lost{};
        std::chrono::milliseconds to_failsafe{};
        std::chrono::milliseconds to_control{};
    };
    /// Brings the fault about, waits for the failsafe, ends it, waits for control. A frame
    /// that passes as good with other sticks than the receiver's fails the test. Adds a line to the
    /// table.
    Outcome expect_failsafe_and_recovery(const std::string& name,
                                         const std::function<void()>& fault,
                                         const std::function<void()>& end_of_fault);
    /// Not sooner than the times that are set; how much later is told by the table, for an emulated
    /// machine stands still now and then.
    static void expect_times(const Outcome& outcome);
    /// From the last frame that was sent to the servos' failsafe: timeout and hold, and not sooner
    /// than the periods for which the frames on the way speak. An emulated machine that stands
    /// still may add seconds.
    static void expect_failsafe_time(Clock::duration since_last_frame,
                                     std::chrono::milliseconds periods);

  private:
    FarEnd& receiver_ = device("receiver");
    FarEnd& servo_wire_ = device("servos");
    ServoBank bank_{servo_wire_};
    Repeater repeater_{receiver_, ibus_bytes(sticks_with_first(1234))};
};

}  // namespace tribus::test
