#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "tests/lab/gpio_bank.h"
#include "tests/lab/gpio_trace.h"
#include "tests/loopback/loopback.h"

namespace tribus::test {

/// The built program with a receiver and servos on ptys, and a simulated chip whose lines are named
/// L0 to L7. The output period is 20 ms, because a guest is slow.
class GpioProgram : public Loopback {
  protected:
    /// The main job with `input` lines for its input, and further tables.
    std::string config(const std::string& tables, const std::string& input = "timeout = \"5s\"",
                       const std::string& name = "tribus.toml") {
        return write_config("[input.receiver]\nprotocol = \"ibus\"\ndevice = \"@receiver\"\n" +
                                input +
                                "\n[output.servos]\nprotocol = \"sbus\"\ndevice = "
                                "\"@servos\"\nperiod = \"20ms\"\n" +
                                "[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n" + tables,
                            name);
    }
    static std::string line(const std::string& name, int number, const std::string& role,
                            const std::string& more = "") {
        return "[gpio." + name + "]\nline = \"L" + std::to_string(number) + "\"\nrole = \"" + role +
               "\"\n" + more + "\n";
    }

    /// Starts the program with a library that can make one of its threads hang (hang_preload.cpp).
    Program start_to_hang(const std::string& file) {
        return Program(
            folder(),
            {std::string("LD_PRELOAD=") + TRIBUS_HANG_PRELOAD, TRIBUS_PROGRAM, "run", file},
            {.executable = "/usr/bin/env"});
    }
    /// Returns whether a thread of the program uses the processor all the time.
    static bool spins(const Program& program) {
        const auto used_before = program.used_time();
        return eventually(
            [&] { return program.used_time() - used_before > std::chrono::milliseconds(300); });
    }

    /// Sends frames to the program until `done` returns true.
    bool while_sending(const std::function<bool()>& done) {
        return eventually([&] {
            repeater_.send_if_due();
            return done();
        });
    }
    bool is(int number, const std::string& level) const {
        return bank_.level(static_cast<unsigned>(number)) == level;
    }
    /// Reads the servos' frames. Returns whether the latest one is as wanted.
    bool latest(const std::function<bool(const SbusSight&)>& wanted) {
        for (const SbusSight& sight : servos_.listen()) {
            latest_ = sight;
            heard_ = true;
        }
        return heard_ && wanted(latest_);
    }
    bool gains_control() {
        return while_sending([&] { return latest([](const SbusSight& s) { return s.good(); }); });
    }
    bool is_in_failsafe() {
        return while_sending([&] { return latest([](const SbusSight& s) { return s.failsafe; }); });
    }

    GpioBank bank_{{.names = {{0, "L0"},
                              {1, "L1"},
                              {2, "L2"},
                              {3, "L3"},
                              {4, "L4"},
                              {5, "L5"},
                              {6, "L6"},
                              {7, "L7"}}}};
    FarEnd& receiver_ = device("receiver");
    FarEnd& servo_wire_ = device("servos");
    ServoBank servos_{servo_wire_};
    Repeater repeater_{receiver_, ibus_bytes(sticks_with_first(1250))};
    SbusSight latest_;
    bool heard_ = false;
};

}  // namespace tribus::test
