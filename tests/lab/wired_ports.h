#pragma once

#include <algorithm>
#include <chrono>
#include <string>

#include "tests/lab/uart.h"
#include "tests/loopback/loopback.h"

namespace tribus::test {

/// The built program at serial ports with real drivers, whose far ends are in the test's hand.
class WiredPorts : public Loopback {
  protected:
    /// A configuration with i.Bus in at `receiver` and SBUS out at `servos`.
    std::string config(const std::string& receiver, const std::string& servos) {
        return write_config("[input.receiver]\nprotocol = \"ibus\"\ntimeout = \"5s\"\ndevice = \"" +
                            receiver + "\"\n[output.servos]\nprotocol = \"sbus\"\ndevice = \"" +
                            servos + "\"\n[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n");
    }

    /// Sends an i.Bus frame every few milliseconds until the SBUS frame with its channels has come.
    static bool passes(Uart& receiver, Uart& servos, const Sticks& sticks) {
        const Bytes ibus = ibus_bytes(sticks);
        const Bytes sbus = sbus_bytes(sbus_sight_of(sticks));
        Bytes seen;
        auto latest = Clock::time_point{};
        return eventually([&] {
            if (Clock::now() - latest > std::chrono::milliseconds(7)) {
                latest = Clock::now();
                receiver.send(ibus);
            }
            const Bytes more = servos.receive();
            seen.insert(seen.end(), more.begin(), more.end());
            return std::search(seen.begin(), seen.end(), sbus.begin(), sbus.end()) != seen.end();
        });
    }

    /// What `tribus doctor` says of `device` while `sender` repeats a frame; it has to end with
    /// `status`.
    std::string said_of(const std::string& device, Uart& sender, const Bytes& frame, int status) {
        // Else the kernel echoes what comes before the program has set the port.
        { const Uart raw(device, kIbus); }
        Program& program = start({"doctor", device, "--for", "1s"});
        auto latest = Clock::time_point{};
        EXPECT_TRUE(eventually([&] {
            if (Clock::now() - latest > std::chrono::milliseconds(7)) {
                latest = Clock::now();
                sender.send(frame);
            }
            return !program.runs();
        }));
        EXPECT_EQ(program.end(), status) << program.output();
        return program.output();
    }

    static bool has(const std::string& text, const std::string& part) {
        return text.find(part) != std::string::npos;
    }
};

}  // namespace tribus::test
