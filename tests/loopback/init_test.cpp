#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/loopback/loopback.h"

namespace tribus::test::init_test {
namespace {

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

class Init : public Loopback {
  protected:
    std::string file() const { return folder() / "rc.toml"; }
    std::string written() const {
        std::ifstream stream(file());
        return {std::istreambuf_iterator<char>(stream), {}};
    }
    /// A device on whose wire a receiver can send before the program has opened it.
    FarEnd& receiver(const std::string& name = "receiver") {
        FarEnd& wire = device(name);
        // Otherwise the kernel echoes what arrives before the program has opened the device.
        EXPECT_EQ(std::system(("stty -F " + wire.path() + " raw -echo").c_str()), 0);
        return wire;
    }
    /// Waits for the end of the program and calls `meanwhile` repeatedly. Returns the exit status.
    static int end_of(Program& program, const std::function<void()>& meanwhile) {
        EXPECT_TRUE(eventually([&] {
            meanwhile();
            return !program.runs();
        })) << program.errors();
        return program.end().value_or(-1);
    }
    Program& init(std::vector<std::string> arguments, const ProgramSettings& settings = {}) {
        arguments.insert(arguments.begin(), "init");
        return start(arguments, settings);
    }
    /// Runs `init` for these places while the frame is repeated on `wire`.
    Program& init_hearing(FarEnd& wire, const Bytes& frame, const std::string& in,
                          const std::string& out) {
        Repeater repeater(wire, frame);
        Program& program = init({file(), "--in", in, "--out", out, "--listen", "1s"});
        EXPECT_EQ(end_of(program, [&] { repeater.send_if_due(); }), 0) << program.errors();
        return program;
    }
    void expect_checked() {
        Program& check = start({"check", file()});
        EXPECT_EQ(check.end(), 0) << check.errors() << written();
        EXPECT_EQ(check.errors(), "");
    }
};

TEST_F(Init, WritesTheHeardProtocolAndRunTranslatesWithTheFile) {
    FarEnd& wire = receiver();
    FarEnd& servos = device("servos");
    const Bytes frame = ibus_bytes(sticks_with_first(1300));
    Program& program = init_hearing(wire, frame, wire.path(), servos.path());
    EXPECT_EQ(wire.receive(), Bytes{}) << "init wrote to the wire";
    EXPECT_EQ(servos.receive(), Bytes{}) << "init wrote to the wire";
    EXPECT_EQ(program.output(), "");
    EXPECT_TRUE(has(written(), "# Heard: i.Bus, 18 channels, 115200 baud 8N1")) << written();
    EXPECT_TRUE(has(written(), "protocol = \"ibus\"\n")) << written();
    EXPECT_TRUE(has(written(), "device   = \"" + wire.path() + "\"\n")) << written();
    for (const std::string next : {"tribus check ", "tribus run ", "tribus learn "}) {
        EXPECT_TRUE(has(program.errors(), "\n  " + next + file())) << program.errors();
    }
    EXPECT_TRUE(has(program.errors(), "systemctl enable --now tribus@rc\n")) << program.errors();
    expect_checked();

    Program& running = run(file());
    ServoBank bank(servos);
    Repeater repeater(wire, frame);
    EXPECT_TRUE(eventually([&] {
        repeater.send_if_due();
        const auto seen = bank.listen();
        return !seen.empty() && seen.back().good() && seen.back().raw[0] == sbus_raw(1300);
    })) << running.errors();
    expect_clean_end(running);
}

TEST_F(Init, HearsSbusForAnOutputOfAnotherProtocol) {
    FarEnd& wire = receiver();
    FarEnd& reader = device("reader");
    init_hearing(wire, sbus_bytes(sbus_sight_of(sticks_with_first(1200))), wire.path(),
                 reader.path() + "=ibus");
    EXPECT_TRUE(has(written(), "# Heard: SBUS, 16 channels and 2 switches")) << written();
    EXPECT_TRUE(has(written(), "action  = \"silence\"\n")) << written();
    expect_checked();
}

TEST_F(Init, WritesNothingAfterSilenceUnlessTheProtocolIsNamed) {
    FarEnd& wire = receiver();
    FarEnd& servos = device("servos");
    Program& unnamed =
        init({file(), "--in", wire.path(), "--out", servos.path(), "--listen", "1s"});
    EXPECT_EQ(unnamed.end(), 1);
    EXPECT_TRUE(has(unnamed.errors(), "[line.silence]")) << unnamed.errors();
    EXPECT_TRUE(has(unnamed.errors(),
                    "To write the file nevertheless, name the protocol, --in PLACE=PROTOCOL:\n"
                    "ibus "))
        << unnamed.errors();
    EXPECT_TRUE(unnamed.errors().ends_with("tribus: --in " + wire.path() + ": nothing was heard\n"))
        << unnamed.errors();
    EXPECT_EQ(count_of(wire.path(), unnamed.errors()), 1U) << unnamed.errors();
    EXPECT_FALSE(std::filesystem::exists(file()));
    Program& named =
        init({file(), "--in", wire.path() + "=sbus", "--out", servos.path(), "--listen", "1s"});
    EXPECT_EQ(named.end(), 0) << named.errors();
    EXPECT_TRUE(has(named.errors(), "[line.silence]")) << named.errors();
    expect_checked();
}

TEST_F(Init, PrintsInsteadOfWriting) {
    Program& program = init({"-", "--in", "can0=can", "--out", "/dev/ttyAMA3", "--listen", "0"});
    EXPECT_EQ(program.end(), 0) << program.errors();
    EXPECT_TRUE(has(program.output(), "[input.bus]\nprotocol  = \"can\"\ninterface = \"can0\"\n"))
        << program.output();
    const std::string config = write_config(program.output());
    Program& check = start({"check", config});
    EXPECT_EQ(check.end(), 0) << check.errors();
}

TEST_F(Init, TakesSeveralInputsAndOutputs) {
    Program& program =
        init({file(), "--in", "/dev/ttyAMA5=ibus", "--in", "/dev/ttyAMA4=sbus", "--out",
              "/dev/ttyAMA3", "--out", "tribus-no-can", "--out", "can1=dronecan", "--listen", "0"});
    // A name that nothing has is accepted only with a protocol of CAN.
    EXPECT_EQ(program.end(), 1) << program.errors();
    Program& named =
        init({"--in", "/dev/ttyAMA5=ibus", "--in", "/dev/ttyAMA4=sbus", "--out", "/dev/ttyAMA3",
              "--out", "can0=can", "--out", "can1=dronecan", "--listen", "0", file()});
    EXPECT_EQ(named.end(), 0) << named.errors();
    EXPECT_TRUE(has(written(), "from = [\"receiver\", \"receiver2\"]\n")) << written();
    EXPECT_TRUE(has(written(), "to   = [\"servos\", \"bus\", \"bus2\"]\n")) << written();
    expect_checked();
}

TEST_F(Init, DoesNotReplaceAFileUnlessForced) {
    std::ofstream(file()) << "mine\n";
    const std::vector<std::string> arguments{
        file(), "--in", "/dev/ttyAMA5=ibus", "--out", "/dev/ttyAMA3", "--listen", "0"};
    Program& refused = init(arguments);
    EXPECT_EQ(refused.end(), 1);
    EXPECT_EQ(refused.errors(), "tribus: " + file() + " exists; --force replaces it\n");
    EXPECT_EQ(written(), "mine\n");
    std::vector<std::string> forced = arguments;
    forced.emplace_back("--force");
    Program& replaced = init(forced);
    EXPECT_EQ(replaced.end(), 0) << replaced.errors();
    expect_checked();
}

TEST_F(Init, DoesNotOpenAPortThatIsInUse) {
    FarEnd& wire = receiver();
    FarEnd& servos = device("servos");
    Program& running = run(write_config(main_job(kPatientInput)));
    Program& program =
        init({file(), "--in", wire.path(), "--out", servos.path(), "--listen", "1s"});
    EXPECT_EQ(program.end(), 1);
    EXPECT_TRUE(has(program.errors(), "it is in use by tribus (process ")) << program.errors();
    EXPECT_TRUE(has(program.errors(), "tribus: --in " + wire.path() + ": it is in use by tribus"))
        << program.errors();
    ServoBank bank(servos);
    Repeater repeater(wire, ibus_bytes(sticks_with_first(1300)));
    EXPECT_TRUE(eventually([&] {
        repeater.send_if_due();
        const auto seen = bank.listen();
        return !seen.empty() && seen.back().good();
    }));
    expect_clean_end(running);
}

TEST_F(Init, RefusesWrongUse) {
    struct Use {
        std::vector<std::string> arguments;
        std::string says;
    };
    const std::vector<Use> uses{
        {{"--in", "/dev/ttyAMA5", "--out", "x", "--listen", "0"},
         "--in /dev/ttyAMA5: with --listen 0 the protocol must be named, --in PLACE=PROTOCOL; "
         "allowed: ibus, sbus, "},
        {{"--in", "a", "--out", "b", "--listen", "90s"},
         "--listen \"90s\": must be a time from 1s"},
        {{"--in", "a=ibuz", "--out", "b"},
         "--in \"a=ibuz\": there is no protocol \"ibuz\"; did you mean"},
        {{"--in", "/dev/ttyAMA5=can", "--out", "b", "--listen", "0"},
         "--in /dev/ttyAMA5: can runs on a CAN interface, such as can0; this is a serial device"},
        {{"--in", "/dev/ttyAMA5=ibus", "--out", "/dev/ttyAMA3=dronecan", "--listen", "0"},
         "--out /dev/ttyAMA3: dronecan runs on a CAN interface, such as can0"},
        {{"--in", "a", "--out", "b=dbc"}, "dbc needs the keys dbc and signals"},
        {{"--in", "/dev/ttyAMA5=ibus", "--out", "/dev/ttyAMA5", "--listen", "0"},
         "a port has one rate and parity"},
        {{"--in", "can0=can", "--out", "can0=can", "--listen", "0"},
         "`tribus check` would refuse it: on \"can0\" the id 0x300"},
        {{"--in", "a", "--out", "b", "--throttle", "100"}, "--throttle"},
    };
    for (const Use& use : uses) {
        std::vector<std::string> arguments{file()};
        arguments.insert(arguments.end(), use.arguments.begin(), use.arguments.end());
        Program& program = init(arguments);
        EXPECT_EQ(program.end(), 2) << use.says;
        EXPECT_TRUE(has(program.errors(), use.says)) << program.errors();
        EXPECT_FALSE(std::filesystem::exists(file())) << use.says;
    }
}

TEST_F(Init, ReadsAnswersFromAPipe) {
    FarEnd& wire = receiver();
    FarEnd& servos = device("servos");
    const std::string answers =
        write_config("nowhere\n" + wire.path() + "\n" + servos.path() + "\nibus\n", "answers");
    Repeater repeater(wire, ibus_bytes(sticks_with_first(1300)));
    Program& program = init({file(), "--listen", "1s"}, {.input = answers});
    EXPECT_EQ(end_of(program, [&] { repeater.send_if_due(); }), 0) << program.errors();
    // No terminal shows the answers, so init does.
    EXPECT_TRUE(has(program.errors(), "\n> nowhere\n")) << program.errors();
    EXPECT_TRUE(has(written(), "action  = \"silence\"\n")) << written();
    expect_checked();
}

TEST_F(Init, WithoutATerminalAndOptionsNamesTheOptions) {
    const auto refused = [&](const std::vector<std::string>& arguments) {
        Program& program = init(arguments);
        EXPECT_EQ(program.end(), 2) << program.errors();
        EXPECT_TRUE(
            has(program.errors(), "such as tribus init --in /dev/ttyUSB0 --out /dev/ttyUSB1\n"))
            << program.errors();
        EXPECT_FALSE(std::filesystem::exists(file()));
    };
    refused({file()});
    refused({file(), "--in", "/dev/ttyAMA5=ibus", "--listen", "0"});
}

TEST_F(Init, RefusesWhatCanNeverBeAPort) {
    const auto refused = [&](const std::string& place, const std::string& says) {
        Program& program = init({file(), "--in", place, "--out", "/dev/ttyAMA3", "--listen", "1s"});
        EXPECT_EQ(program.end(), 1) << place;
        EXPECT_TRUE(has(program.errors(), says)) << program.errors();
        EXPECT_FALSE(std::filesystem::exists(file())) << place;
    };
    refused("/dev/null=ibus", "not a serial device");
    refused(folder().string() + "=ibus", "not a serial device");
    refused("tribus-no-device", "there is no CAN interface and no serial device of this name");
    refused("/dev/input/by-id/usb-Pad-event-joystick",
            "--in /dev/input/by-id/usb-Pad-event-joystick: this is an input device; `tribus learn "
            "/dev/input/by-id/usb-Pad-event-joystick` prints the lines of a gamepad\n");
    refused("pwmchip0", "--in pwmchip0: this is a PWM chip; which channel goes to which of its");
    // It may be plugged in later, but then its protocol must be named.
    refused(folder() / "nothing", "To write the file nevertheless, name the protocol");
    refused(folder() / "nothing",
            "tribus: --in " + (folder() / "nothing").string() + ": there is no such device\n");
}

TEST_F(Init, SaysANameThatNothingHasOnce) {
    Program& program = init({file(), "--in", "BAD", "--out", "/dev/ttyAMA3"});
    EXPECT_EQ(program.end(), 1);
    EXPECT_EQ(program.errors(),
              "tribus: --in BAD: there is no CAN interface and no serial device of this name; a "
              "serial device is a path, such as /dev/ttyUSB0\n");
}

TEST_F(Init, AdvisesToLearnHowTheReceiverLosesItsLinkBeforeItIsRun) {
    Program& program =
        init({file(), "--in", "/dev/ttyAMA5=ibus", "--out", "/dev/ttyAMA3=sbus", "--listen", "0"});
    EXPECT_EQ(program.end(), 0) << program.errors();
    const std::string errors = program.errors();
    const std::size_t learn = errors.find("  tribus learn " + file() + ":receiver\n");
    EXPECT_NE(learn, std::string::npos) << errors;
    EXPECT_LT(learn, errors.find("  tribus run " + file() + "\n")) << errors;
}

TEST_F(Init, NeedsAFolderThatItCanWriteTo) {
    std::filesystem::create_directory(folder() / "closed");
    std::filesystem::permissions(folder() / "closed", std::filesystem::perms(0555));
    const std::string path = folder() / "closed/rc.toml";
    Program& program =
        init({path, "--in", "can0=can", "--out", "can1=can", "--listen", "0"}, of_ordinary_user());
    EXPECT_EQ(program.end(), 1);
    EXPECT_EQ(program.errors(), "tribus: " + path + " cannot be written: " +
                                    (folder() / "closed").string() + ": Permission denied\n");
}

TEST_F(Init, AsksInATerminal) {
    FarEnd& wire = receiver();
    FarEnd& servos = device("servos");
    FarEnd terminal(folder() / "terminal");
    Program& program = init({file(), "--listen", "1s"}, {.terminal = terminal.path()});
    const auto type = [&](const std::string& answer) {
        const std::string line = answer + "\n";
        terminal.send(Bytes(line.begin(), line.end()));
    };
    Repeater repeater(wire, ibus_bytes(sticks_with_first(1300)));
    const auto asked = [&](const std::string& question) {
        return eventually([&] {
            repeater.send_if_due();
            return has(program.errors(), question);
        });
    };
    ASSERT_TRUE(asked("Which port is the receiver at")) << program.errors();
    type(wire.path());
    ASSERT_TRUE(asked("Which port are the servos at")) << program.errors();
    EXPECT_TRUE(has(program.errors(), "Heard: i.Bus, 18 channels")) << program.errors();
    type(servos.path());
    ASSERT_TRUE(asked("Which protocol does it read?")) << program.errors();
    type("sbus");
    ASSERT_TRUE(asked("when the signal is lost?")) << program.errors();
    type("2");
    EXPECT_EQ(program.end(), 0) << program.errors();
    EXPECT_TRUE(has(written(), "preset  = { 3 = 1500, other = 1500 }\n")) << written();
    expect_checked();
}

TEST_F(Init, LeavesNothingBehindIfItIsInterrupted) {
    FarEnd terminal(folder() / "terminal");
    const auto asking = [&]() -> Program& {
        Program& program = init({file()}, {.terminal = terminal.path()});
        EXPECT_TRUE(program.says("Which port is the receiver at")) << program.errors();
        return program;
    };
    constexpr std::uint8_t kCtrlC = 3;
    constexpr std::uint8_t kCtrlD = 4;
    Program& interrupted = asking();
    terminal.send(Bytes{kCtrlC});
    EXPECT_EQ(interrupted.end(), 128 + SIGINT);
    Program& ended = asking();
    terminal.send(Bytes{kCtrlD});
    EXPECT_EQ(ended.end(), 1);
    EXPECT_TRUE(has(ended.errors(), "the answers ended before the questions; nothing is written\n"))
        << ended.errors();
    for (const auto& entry : std::filesystem::directory_iterator(folder())) {
        EXPECT_FALSE(has(entry.path().filename(), "rc.toml")) << entry.path();
    }
}

}  // namespace
}  // namespace tribus::test::init_test
