#include <linux/input.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/lab/guest.h"
#include "tests/lab/input_devices.h"
#include "tests/lab/recorded_receiver.h"
#include "tests/lab/sdl_joystick.h"
#include "tests/loopback/loopback.h"

/// The built program as a joystick of the kernel (uinput), read as games read one.
namespace tribus::test::input_joystick_test {
namespace {

constexpr std::array kAxisCodes{ABS_X,  ABS_Y,  ABS_Z,        ABS_RX,
                                ABS_RY, ABS_RZ, ABS_THROTTLE, ABS_RUDDER};
constexpr const char* kName = "tribus in the laboratory";
constexpr std::size_t kFrames = 400;

class LabJoystick : public Loopback {
  protected:
    LabJoystick() {
        require_guest();
        shell("modprobe -a uinput evdev joydev");
    }
    std::string config(const std::string& input = "") {
        return write_config("[input.receiver]\nprotocol = \"ibus\"\ndevice = \"@receiver\"\n" +
                            input + "[output.simulator]\nprotocol = \"joystick\"\nname = \"" +
                            kName + "\"\n[pipeline.main]\nfrom = \"receiver\"\n" +
                            "to = \"simulator\"\n[pipeline.main.failsafe]\nhold = \"0s\"\n" +
                            "recover = \"0s\"\n");
    }
};

/// Two steps a microsecond from 988 us on, as EdgeTX has it.
int position_of(int microseconds) {
    return std::clamp(2 * (microseconds - 988), 0, 2047);
}

bool shows(const InputReader& joystick, const Sticks& sticks) {
    for (std::size_t axis = 0; axis < kAxisCodes.size(); ++axis) {
        if (joystick.axis(kAxisCodes[axis]) != position_of(sticks[axis])) {
            return false;
        }
    }
    for (std::size_t channel = 8; channel < sticks.size(); ++channel) {
        if (joystick.pressed(BTN_GAMEPAD + static_cast<int>(channel) - 8) !=
            (sticks[channel] > 1500)) {
            return false;
        }
    }
    return true;
}

TEST_F(LabJoystick, LooksLikeTheJoystickOfARadio) {
    device("receiver");
    Program& program = run(config());
    const InputReader joystick(event_device(kName));
    ASSERT_TRUE(joystick.valid()) << program.errors();
    EXPECT_EQ(joystick.axes(), (std::vector<int>{ABS_X, ABS_Y, ABS_Z, ABS_RX, ABS_RY, ABS_RZ,
                                                 ABS_THROTTLE, ABS_RUDDER}));
    EXPECT_EQ(joystick.buttons().size(), 24U);
    EXPECT_EQ(joystick.buttons().front(), BTN_GAMEPAD);
    EXPECT_EQ(joystick.buttons().back(), BTN_TRIGGER_HAPPY8);
    for (const int axis : kAxisCodes) {
        const input_absinfo range = joystick.range(axis);
        EXPECT_EQ(range.minimum, 0);
        EXPECT_EQ(range.maximum, 2047);
        EXPECT_EQ(range.flat, 0);
        EXPECT_EQ(range.fuzz, 0);
    }
    expect_clean_end(program);
    EXPECT_EQ(event_device(kName), "") << "it vanishes with the program";
}

TEST_F(LabJoystick, FollowsARecordingFrameByFrame) {
    FarEnd& receiver = device("receiver");
    Program& program = run(config("timeout = \"5s\"\n"));
    const InputReader joystick(event_device(kName));
    for (const Capture capture : captures()) {
        const std::vector<Sticks> frames = recorded_sticks(capture);
        ASSERT_GE(frames.size(), kFrames);
        std::size_t changes = 0;
        for (std::size_t i = 0; i < kFrames; ++i) {
            changes += i > 0 && frames[i] != frames[i - 1] ? 1U : 0U;
            receiver.send(ibus_bytes(frames[i]));
            ASSERT_TRUE(eventually([&] { return shows(joystick, frames[i]); }))
                << capture_name(capture) << ", frame " << i << "\n"
                << program.errors();
        }
        EXPECT_GT(changes, kFrames / 5) << "sticks that rest show nothing";
    }
    expect_clean_end(program);
}

TEST_F(LabJoystick, StaysWithSticksAtRestWhenTheLinkIsLost) {
    FarEnd& receiver = device("receiver");
    Program& program = run(config());
    const InputReader joystick(event_device(kName));
    const Sticks held(14, 1900);
    Repeater sticks(receiver, ibus_bytes(held));
    ASSERT_TRUE(eventually([&] {
        sticks.send_if_due();
        return shows(joystick, held);
    }));
    Sticks rest(14, 1500);
    rest[2] = 988;
    EXPECT_TRUE(eventually([&] { return shows(joystick, rest); })) << program.errors();
    EXPECT_NE(event_device(kName), "");
    EXPECT_TRUE(eventually([&] {
        sticks.send_if_due();
        return shows(joystick, held);
    })) << "it comes back";
    expect_clean_end(program);
}

/// How its program stands before it is killed: SIGUSR2 lets the data thread hang.
class StandingJoystick : public LabJoystick, public testing::WithParamInterface<int> {};

TEST_P(StandingJoystick, KeepsItsAxesAndVanishesWithItsProgram) {
    FarEnd& receiver = device("receiver");
    Program& program = start({std::string("LD_PRELOAD=") + TRIBUS_HANG_PRELOAD, TRIBUS_PROGRAM,
                              "run", config("timeout = \"1s\"\n")},
                             {.executable = "/usr/bin/env"});
    EXPECT_TRUE(program.says("started")) << program.errors();
    const InputReader joystick(event_device(kName));
    const Sticks held(14, 1900);
    Repeater sticks(receiver, ibus_bytes(held));
    ASSERT_TRUE(eventually([&] {
        sticks.send_if_due();
        return shows(joystick, held);
    }));
    program.signal(GetParam());
    shell("sleep 2");
    EXPECT_TRUE(shows(joystick, held)) << "nobody brings the sticks to rest";
    program.signal(SIGKILL);
    program.end();
    EXPECT_TRUE(eventually([] { return event_device(kName).empty(); }));
}

INSTANTIATE_TEST_SUITE_P(Ends, StandingJoystick, testing::Values(SIGUSR2, SIGSTOP),
                         [](const auto& signal) {
                             return std::string(signal.param == SIGSTOP ? "Stopped" : "Hangs");
                         });

TEST_F(LabJoystick, IsReadByEvtestAndBySdl) {
    FarEnd& receiver = device("receiver");
    Program& program = run(config());
    const std::string event = event_device(kName);
    const std::string said = run_shell("timeout 2 evtest " + event + " </dev/null").output;
    EXPECT_NE(said.find(std::string("Input device name: \"") + kName + "\""), std::string::npos)
        << said;
    EXPECT_NE(said.find("(ABS_RUDDER)"), std::string::npos) << said;
    SdlJoystick sdl(event);
    ASSERT_TRUE(sdl.valid()) << sdl.error();
    EXPECT_EQ(sdl.name(), kName);
    EXPECT_EQ(sdl.axes(), 8);
    EXPECT_EQ(sdl.buttons(), 24);
    Sticks sticks{988,  1500, 1756, 1244, 1500, 1500, 1500,
                  2012, 2000, 1000, 2000, 1000, 1000, 1000};
    Repeater repeater(receiver, ibus_bytes(sticks));
    // SDL has -32768 to 32767 for 0 to 2047.
    const auto near = [&sdl](int axis, int wanted) {
        return std::abs(sdl.axis(axis) - wanted) < 40;
    };
    EXPECT_TRUE(eventually([&] {
        repeater.send_if_due();
        sdl.update();
        return near(0, -32768) && near(1, 16) && near(2, 16408) && near(3, -16376) &&
               near(7, 32767) && sdl.button(0) && !sdl.button(1) && sdl.button(2);
    })) << sdl.axis(0)
        << " " << sdl.axis(1) << " " << sdl.axis(2) << " " << sdl.axis(3) << " " << sdl.axis(7);
    expect_clean_end(program);
}

TEST_F(LabJoystick, SaysWhoMayMakeOne) {
    device("receiver");
    shell("chmod 600 /dev/uinput");
    const std::string file = config();
    shell("chmod -R a+rwX " + folder().string());
    const ShellResult result = run_shell(
        "setpriv --reuid nobody --regid nogroup --clear-groups "
        "timeout 5 " TRIBUS_PROGRAM " run " +
        file);
    EXPECT_NE(result.output.find("this user may not use it; the package's udev rule gives it to "
                                 "the group uinput"),
              std::string::npos)
        << result.output;
}

TEST_F(LabJoystick, SaysThatTheKernelHasNoUinput) {
    device("receiver");
    shell("rmmod uinput; rm -f /dev/uinput");
    Program& program = run(config());
    EXPECT_TRUE(program.says("`sudo modprobe uinput` loads it")) << program.errors();
    shell("modprobe uinput");
    EXPECT_TRUE(eventually([&] { return !event_device(kName).empty(); })) << program.errors();
    expect_clean_end(program);
}

}  // namespace
}  // namespace tribus::test::input_joystick_test
