#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/loopback/loopback.h"

namespace tribus::test::learn_test {
namespace {

constexpr int kThrottle = 2;

/// Moves every stick from one end to the other.
Sticks moving(int step) {
    Sticks sticks(14, 1500);
    for (std::size_t stick = 0; stick < 4; ++stick) {
        sticks[stick] = 1000 + (step * 37 + static_cast<int>(stick) * 250) % 1001;
    }
    return sticks;
}
Sticks hands_off(int step) {
    Sticks sticks(14, 1500);
    sticks[kThrottle] = 1000 + step % 2;
    return sticks;
}
Sticks throttle_at(int us) {
    Sticks sticks(14, 1500);
    sticks[kThrottle] = us;
    return sticks;
}

class Learn : public Loopback {
  protected:
    /// 4 s of movement, 2 s still, 4 s without the transmitter, 2 s with it; one frame every 10 ms.
    std::string recording(const Sticks& lost) {
        std::string text = "# t_us bytes\n";
        for (int step = 0; step < 1200; ++step) {
            const bool off = step >= 600 && step < 1000;
            const Sticks sticks = step < 400 ? moving(step) : off ? lost : hands_off(step);
            text += std::to_string(step * 10'000);
            for (const std::uint8_t byte : ibus_bytes(sticks)) {
                text += fmt::format(" {:02x}", byte);
            }
            text += "\n";
        }
        const std::filesystem::path path = folder() / "recording.txt";
        std::ofstream(path) << text;
        return path.string();
    }
    Program& learn(const Sticks& lost, const std::string& off_at = "6s") {
        return start({"learn", write_config(main_job()) + ":receiver", "--recording",
                      recording(lost), "--off-at", off_at, "--back-at", "10s"});
    }
};

TEST_F(Learn, PrintsTheLinesThatRecogniseTheLossInARecording) {
    Program& program = learn(throttle_at(900));
    EXPECT_EQ(program.end(), 0) << program.errors();
    EXPECT_EQ(program.output(), "failsafe_when = [{ channel = 3, below = 950 }]\n");
    EXPECT_NE(program.errors().find("channel 3 is then 900 us, and\n  1000 to 2000 us"),
              std::string::npos)
        << program.errors();
}

TEST_F(Learn, SaysThatALossThatOnlyStandsStillIsALastResort) {
    Program& program = learn(throttle_at(1000));
    EXPECT_EQ(program.end(), 0) << program.errors();
    EXPECT_EQ(program.output(), "frozen = \"2s\"\n");
    EXPECT_NE(program.errors().find("last resort"), std::string::npos) << program.errors();
}

TEST_F(Learn, WithTimesInTheWrongOrderIsRefused) {
    Program& program = learn(throttle_at(900), "11s");
    EXPECT_EQ(program.end(), 1);
    EXPECT_NE(program.errors().find("--off-at must be earlier than --back-at"), std::string::npos)
        << program.errors();
}

TEST_F(Learn, WithoutAPersonWantsARecording) {
    device("receiver");
    Program& program = start({"learn", write_config(main_job()) + ":receiver"});
    EXPECT_EQ(program.end(), 1);
    EXPECT_NE(program.errors().find("--recording FILE --off-at 12s --back-at 20s"),
              std::string::npos)
        << program.errors();
}

TEST_F(Learn, NamesTheInputsThatAreThereForOneThatIsNot) {
    Program& program = start({"learn", write_config(main_job()) + ":reciever"});
    EXPECT_EQ(program.end(), 2);
    EXPECT_NE(program.errors().find("did you mean \"receiver\"?"), std::string::npos)
        << program.errors();
}

/// This machine need not have a gamepad; the laboratory has one.
class LearnPad : public Loopback {
  protected:
    void refuses(const std::vector<std::string>& words, int status, const std::string& why) {
        Program& program = start(words);
        EXPECT_EQ(program.end(), status) << program.errors();
        EXPECT_NE(program.errors().find(why), std::string::npos) << program.errors();
        EXPECT_EQ(program.output(), "");
    }
};

TEST_F(LearnPad, SaysThatADeviceIsNotThereOrNoGamepad) {
    refuses({"learn", "/dev/input/by-id/none"}, 1,
            "/dev/input/by-id/none: there is no such device");
    refuses({"learn", "/dev/null"}, 1, "/dev/null: this is no input device");
    refuses({"learn", "/dev/input/js0"}, 1, "ends in -event-joystick");
    refuses({"learn", "pad"}, 2, "or a gamepad below /dev/input");
}

TEST_F(LearnPad, RefusesARecording) {
    const std::string file = write_config(
        "[input.pad]\nprotocol = \"gamepad\"\ndevice = \"/dev/input/by-id/none\"\n"
        "[output.servos]\nprotocol = \"sbus\"\ndevice = \"@servos\"\n"
        "[pipeline.main]\nfrom = \"pad\"\nto = \"servos\"\n");
    const std::string why = "--recording is for the loss of receivers";
    for (const std::string& pad : {file + ":pad", std::string("/dev/input/by-id/none")}) {
        refuses({"learn", pad, "--recording", file, "--off-at", "1s", "--back-at", "2s"}, 2, why);
    }
    refuses({"learn", file + ":pad"}, 1, "/dev/input/by-id/none: there is no such device");
}

TEST_F(LearnPad, SaysToAProgramWhyNothingWasLearned) {
    Program& program = start({"learn", "/dev/input/by-id/none", "--format", "json"});
    EXPECT_EQ(program.end(), 1);
    EXPECT_EQ(program.output(),
              R"({"step":"broken","text":"/dev/input/by-id/none: there is no such device",)"
              "\"lines\":[]}\n");
}

/// A person who does what the program says, in a terminal.
class GuidedLearn : public Learn {
  protected:
    /// `prompts`: what it says before the sticks are moved, before off, before on, and at the end.
    /// Returns all that it said.
    std::string guided(const std::vector<std::string>& options,
                       const std::array<std::string, 4>& prompts) {
        FarEnd& receiver = device("receiver");
        device("servos");
        FarEnd terminal(folder() / "terminal");
        std::vector<std::string> words{"learn", write_config(main_job()) + ":receiver"};
        words.insert(words.end(), options.begin(), options.end());
        Program& program = start(words, {.terminal = terminal.path()});
        Repeater repeater(receiver, ibus_bytes(moving(0)));
        std::string printed;
        int step = 0;
        const auto send_until = [&](auto sticks_of, auto done) {
            return eventually([&] {
                const auto sent_before = repeater.latest();
                repeater.send_if_due();
                if (repeater.latest() != sent_before) {
                    repeater.change(ibus_bytes(sticks_of(++step)));
                }
                for (const std::uint8_t letter : terminal.receive()) {
                    printed += static_cast<char>(letter);
                }
                return done();
            });
        };
        const auto says = [&](const std::string& prompt) {
            return [&, prompt] {
                return (program.errors() + printed).find(prompt) != std::string::npos;
            };
        };
        const auto press_enter = [&] { terminal.send(Bytes{'\n'}); };
        EXPECT_TRUE(send_until(moving, says(prompts[0]))) << program.errors() << printed;
        constexpr int kFramesOfMoving = 100;
        EXPECT_TRUE(
            send_until(moving, [&, last = step + kFramesOfMoving] { return step >= last; }));
        press_enter();
        EXPECT_TRUE(send_until(hands_off, says(prompts[1]))) << program.errors() << printed;
        press_enter();
        EXPECT_TRUE(send_until([](int) { return throttle_at(885); }, says(prompts[2])))
            << program.errors() << printed;
        press_enter();
        EXPECT_TRUE(send_until(hands_off, says(prompts[3]))) << program.errors() << printed;
        EXPECT_EQ(program.end(), 0);
        for (const std::uint8_t letter : terminal.receive()) {
            printed += static_cast<char>(letter);
        }
        return printed;
    }
};

TEST_F(GuidedLearn, LeadsAPersonThroughSwitchingOffAndOn) {
    const std::string printed = guided({}, {"1/4", "3/4", "4/4", "is recognised"});
    EXPECT_NE(printed.find("failsafe_when = [{ channel = 3, below = 942 }]"), std::string::npos)
        << printed;
}

/// The page leads the person then.
TEST_F(GuidedLearn, LeadsAProgramThatLeadsThePerson) {
    const std::string printed = guided(
        {"--format", "json"},
        {R"({"step":"waiting",)", R"({"step":"off",)", R"({"step":"on",)", R"({"step":"done",)"});
    // A machine that stood still for a while is a receiver with gaps, and has a timeout besides.
    EXPECT_NE(printed.find(R"("failsafe_when = [{ channel = 3, below = 942 }]")"),
              std::string::npos)
        << printed;
}

TEST_F(GuidedLearn, SaysToAProgramWhyNothingWasLearned) {
    Program& program = start({"learn", write_config(main_job()) + ":receiver", "--format", "json"});
    EXPECT_EQ(program.end(), 1);
    EXPECT_EQ(program.output().rfind(R"({"step":"broken","text":")", 0), 0U) << program.output();
    EXPECT_NE(program.output().find("/receiver"), std::string::npos) << program.output();
}

}  // namespace
}  // namespace tribus::test::learn_test
