#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

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

TEST_F(Learn, OfARecordingPrintsTheLinesThatRecogniseTheLoss) {
    Program& program = learn(throttle_at(900));
    EXPECT_EQ(program.end(), 0) << program.errors();
    EXPECT_EQ(program.output(), "failsafe_when = [{ channel = 3, below = 950 }]\n");
    EXPECT_NE(program.errors().find("channel 3 is then 900 us, and 1000 to 2000 us"),
              std::string::npos)
        << program.errors();
}

TEST_F(Learn, OfALossThatOnlyStandsStillSaysThatThisIsALastResort) {
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

TEST_F(Learn, OfAnInputThatIsNotThereNamesThoseThatAre) {
    Program& program = start({"learn", write_config(main_job()) + ":reciever"});
    EXPECT_EQ(program.end(), 2);
    EXPECT_NE(program.errors().find("did you mean \"receiver\"?"), std::string::npos)
        << program.errors();
}

TEST_F(Learn, LeadsAPersonThroughSwitchingOffAndOn) {
    FarEnd& receiver = device("receiver");
    device("servos");
    FarEnd terminal(folder() / "terminal");
    Program& program =
        start({"learn", write_config(main_job()) + ":receiver"}, {.terminal = terminal.path()});
    Repeater repeater(receiver, ibus_bytes(moving(0)));
    int step = 0;
    const auto send = [&](auto sticks_of) {
        const auto sent_before = repeater.latest();
        repeater.send_if_due();
        if (repeater.latest() != sent_before) {
            repeater.change(ibus_bytes(sticks_of(++step)));
        }
    };
    const auto send_until = [&](auto sticks_of, const std::string& said) {
        return eventually([&] {
            send(sticks_of);
            return program.errors().find(said) != std::string::npos;
        });
    };
    const auto press_enter = [&] { terminal.send(Bytes{'\n'}); };
    ASSERT_TRUE(send_until(moving, "1/4")) << program.errors();
    constexpr int kFramesOfMoving = 100;
    ASSERT_TRUE(eventually([&, end = step + kFramesOfMoving] {
        send(moving);
        return step >= end;
    }));
    press_enter();
    ASSERT_TRUE(send_until(hands_off, "3/4")) << program.errors();
    press_enter();
    ASSERT_TRUE(send_until([](int) { return throttle_at(885); }, "4/4")) << program.errors();
    press_enter();
    ASSERT_TRUE(send_until(hands_off, "is recognised")) << program.errors();
    EXPECT_EQ(program.end(), 0);
    std::string printed;
    for (const std::uint8_t letter : terminal.receive()) {
        printed += static_cast<char>(letter);
    }
    EXPECT_NE(printed.find("failsafe_when = [{ channel = 3, below = 942 }]"), std::string::npos)
        << printed;
}

}  // namespace
}  // namespace tribus::test::learn_test
