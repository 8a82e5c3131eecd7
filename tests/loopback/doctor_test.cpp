#include <cstdlib>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/loopback/loopback.h"

namespace tribus::test::doctor_test {
namespace {

/// Waits for the end of the program and calls `meanwhile` repeatedly. Returns the exit status.
int end_of(Program& program, const std::function<void()>& meanwhile) {
    EXPECT_TRUE(eventually([&] {
        meanwhile();
        return !program.runs();
    }));
    return program.end().value_or(-1);
}

class Doctor : public Loopback {
  protected:
    Program& visit(const FarEnd& wire, const std::string& format = "text") {
        return start({"doctor", wire.path(), "--for", "1s", "--format", format});
    }
    /// Returns what doctor prints about a wire on which this frame is repeated. It must exit with
    /// `status`.
    std::string said_of(const Bytes& frame, int status, const std::string& format = "text") {
        FarEnd& wire = device("port");
        // Otherwise the kernel echoes what arrives before the program has opened the device.
        EXPECT_EQ(std::system(("stty -F " + wire.path() + " raw -echo").c_str()), 0);
        Repeater repeater(wire, frame);
        Program& program = visit(wire, format);
        EXPECT_EQ(end_of(program, [&] { repeater.send_if_due(); }), status) << program.output();
        EXPECT_EQ(wire.receive(), Bytes{}) << "doctor wrote to the wire";
        return program.output();
    }
};

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

TEST_F(Doctor, HearsIbusOf18Channels) {
    const std::string said = said_of(ibus_bytes(sticks_with_first(1200)), 0);
    EXPECT_TRUE(has(said, "hears    i.Bus, 18 channels, 115200 baud 8N1")) << said;
    EXPECT_TRUE(has(said, "    [input.receiver]\n    protocol = \"ibus\"\n")) << said;
}

TEST_F(Doctor, HearsSbus) {
    const std::string said = said_of(sbus_bytes(sbus_sight_of(sticks_with_first(1200))), 0);
    EXPECT_TRUE(has(said, "hears    SBUS, 16 channels and 2 switches, 100000 baud 8E2")) << said;
    EXPECT_TRUE(has(said, "    protocol = \"sbus\"\n")) << said;
}

TEST_F(Doctor, LinesThatItPrintsMakeAConfiguration) {
    const auto json =
        nlohmann::json::parse(said_of(ibus_bytes(sticks_with_first(1200)), 0, "json"));
    std::string text;
    for (const auto& line : json["ports"][0]["configuration"]) {
        text += line.get<std::string>() + "\n";
    }
    const std::string config =
        write_config(text +
                     "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyAMA3\"\n"
                     "[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n");
    Program& check = start({"check", config});
    EXPECT_EQ(check.end(), 0) << check.errors();
}

TEST_F(Doctor, SilenceIsAProblem) {
    Program& program = visit(device("port"));
    EXPECT_EQ(program.end(), 1);
    EXPECT_TRUE(has(program.output(), "[line.silence]")) << program.output();
}

TEST_F(Doctor, GarbageIsAProblem) {
    FarEnd& wire = device("port");
    std::mt19937 random(3);
    Program& program = visit(wire);
    const int status = end_of(program, [&] {
        Bytes bytes(20);
        for (std::uint8_t& byte : bytes) {
            byte = static_cast<std::uint8_t>(random());
        }
        wire.send(bytes);
    });
    EXPECT_EQ(status, 1);
    EXPECT_TRUE(has(program.output(), "[line.unknown]")) << program.output();
}

TEST_F(Doctor, LeavesAPortAloneThatAProgramHasOpen) {
    FarEnd& receiver = device("receiver");
    FarEnd& servos = device("servos");
    Program& running = run(write_config(main_job(kPatientInput)));
    Program& program = visit(receiver);
    EXPECT_EQ(program.end(), 1);
    EXPECT_TRUE(has(program.output(), "it is in use by tribus (process ")) << program.output();
    ServoBank bank(servos);
    Repeater repeater(receiver, ibus_bytes(sticks_with_first(1300)));
    EXPECT_TRUE(eventually([&] {
        repeater.send_if_due();
        const auto seen = bank.listen();
        return !seen.empty() && seen.back().good();
    }));
    expect_clean_end(running);
}

TEST_F(Doctor, PortThatIsPulledMeanwhileIsTold) {
    FarEnd& wire = device("port");
    Repeater repeater(wire, ibus_bytes(sticks_with_first(1200)));
    Program& program = start({"doctor", wire.path(), "--for", "10s"});
    const auto begin = Clock::now();
    bool pulled = false;
    const int status = end_of(program, [&] {
        if (Clock::now() - begin < std::chrono::seconds(1)) {
            repeater.send_if_due();
        } else if (!pulled) {
            wire.pull();
            pulled = true;
        }
    });
    EXPECT_EQ(status, 1);
    EXPECT_TRUE(has(program.output(), "[port.cannot_open]") ||
                has(program.output(), "[port.missing]"))
        << program.output();
}

TEST_F(Doctor, WithoutDevicesLooksAtTheMachineAndOpensNothing) {
    Program& program = start({"doctor"});
    const int status = program.end().value_or(-1);
    EXPECT_TRUE(status == 0 || status == 1);
    EXPECT_TRUE(has(program.output(), "Linux ")) << program.output();
}

TEST_F(Doctor, RefusesTimesThatAreNone) {
    Program& program = start({"doctor", "/dev/ttyAMA5", "--for", "0s"});
    EXPECT_EQ(program.end(), 2);
    EXPECT_TRUE(has(program.errors(), "--for \"0s\": must be a time from 1s to 60s"))
        << program.errors();
}

}  // namespace
}  // namespace tribus::test::doctor_test
