#include <algorithm>
#include <chrono>
#include <csignal>
#include <regex>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "tests/lab/gpio_program_bench.h"
#include "tests/lab/shell.h"

/// Lines as inputs and outputs of the built program.
namespace tribus::test::gpio_program_test {
namespace {

TEST_F(GpioProgram, LampAndAlarmFollowTheLink) {
    Program& program = run(config(line("lamp", 0, "link") + line("alarm", 1, "failsafe") +
                                      "[pipeline.main.failsafe]\nhold = \"0s\"\n",
                                  "timeout = \"300ms\""));
    EXPECT_TRUE(eventually([&] { return is(0, "0") && is(1, "1"); })) << "at the start";
    EXPECT_TRUE(while_sending([&] { return is(0, "1") && is(1, "0"); })) << "in control";
    EXPECT_TRUE(eventually([&] { return is(0, "0") && is(1, "1"); })) << "after a loss";
    EXPECT_TRUE(while_sending([&] { return is(0, "1") && is(1, "0"); })) << "back";
    expect_clean_end(program);
}

TEST_F(GpioProgram, LampBlinksWhileValuesAreHeld) {
    Program& program =
        run(config(line("lamp", 0, "link") + "[pipeline.main.failsafe]\nhold = \"10s\"\n",
                   "timeout = \"300ms\""));
    EXPECT_TRUE(while_sending([&] { return is(0, "1"); }));
    for (const std::string level : {"0", "1", "0"}) {
        EXPECT_TRUE(eventually([&] { return is(0, level); })) << level;
    }
    EXPECT_TRUE(latest([](const SbusSight& sight) { return sight.frame_lost && !sight.failsafe; }));
    expect_clean_end(program);
}

TEST_F(GpioProgram, TellsInItsStatusWhichLinesAreActive) {
    Program& program = run(config(line("lamp", 0, "link") +
                                  line("stop", 1, "force_failsafe", "bias = \"pull_down\"")));
    const auto tells = [&](const std::string& lamp, const std::string& stop) {
        return while_sending([&] {
            Program& monitor = start({"monitor", "--format", "json", "--once"});
            monitor.end();
            return std::regex_search(monitor.output(),
                                     std::regex("\"lamp\"[^}]*\"active\":" + lamp +
                                                "\\},.\"name\":\"stop\"[^}]*\"active\":" + stop));
        });
    };
    EXPECT_TRUE(tells("true", "false"));
    bank_.pull(1, true);
    EXPECT_TRUE(tells("false", "true"));
    bank_.pull(1, false);
    expect_clean_end(program);
}

TEST_F(GpioProgram, ForcesFailsafeWithinOneFrame) {
    Program& program =
        run(config(line("stop", 0, "force_failsafe", "debounce = \"0s\"\nbias = \"pull_down\"") +
                   "[pipeline.main.failsafe]\nrecover = \"0s\"\n"));
    EXPECT_TRUE(gains_control()) << program.errors();
    // No frame may be on its way when the line changes.
    program.signal(SIGSTOP);
    EXPECT_TRUE(eventually([&] { return servos_.listen().empty(); }));
    bank_.pull(0, true);
    program.signal(SIGCONT);
    std::size_t good = 0;
    EXPECT_TRUE(eventually([&] {
        for (const SbusSight& sight : servos_.listen()) {
            good += sight.good() ? 1U : 0U;
            if (sight.failsafe) {
                return true;
            }
        }
        return false;
    }));
    EXPECT_LE(good, 2U) << "more than the frame that was due and one period";
    EXPECT_TRUE(program.says("output servos: in failsafe; waits for the GPIO line"));
    bank_.pull(0, false);
    heard_ = false;
    EXPECT_TRUE(gains_control()) << program.errors();
    expect_clean_end(program);
}

TEST_F(GpioProgram, ForcesFailsafeAlthoughItsMainThreadHangs) {
    Program program = start_to_hang(config(line("stop", 0, "force_failsafe")));
    EXPECT_TRUE(program.says("started")) << program.errors();
    EXPECT_TRUE(gains_control()) << program.errors();
    program.signal(SIGUSR1);
    EXPECT_TRUE(spins(program));
    heard_ = false;
    EXPECT_TRUE(gains_control()) << "still";
    bank_.pull(0, true);
    EXPECT_TRUE(is_in_failsafe());
    EXPECT_EQ(count_of("in failsafe; waits for the GPIO line", program.errors()), 0U)
        << "the main thread, which logs this, does not hang";
}

TEST_F(GpioProgram, IsInFailsafeFromTheFirstFrameIfThatIsForcedAtTheStart) {
    bank_.pull(0, true);
    Program& program = run(
        config(line("stop", 0, "force_failsafe") + "[pipeline.main.failsafe]\nrecover = \"0s\"\n"));
    std::size_t frames = 0;
    EXPECT_TRUE(while_sending([&] {
        for (const SbusSight& sight : servos_.listen()) {
            EXPECT_TRUE(sight.failsafe);
            ++frames;
        }
        return frames >= 25;
    }));
    expect_clean_end(program);
}

TEST_F(GpioProgram, TakesAStopLineThatIsGoneForOneThatIsActive) {
    Program& program = run(
        config(line("stop", 0, "force_failsafe") + "[pipeline.main.failsafe]\nrecover = \"0s\"\n"));
    EXPECT_TRUE(gains_control()) << program.errors();
    bank_.remove();
    EXPECT_TRUE(is_in_failsafe());
    EXPECT_TRUE(program.says("line stop (L0): is gone; waiting for it"));
    bank_.put_back();
    EXPECT_TRUE(program.says("line stop (L0): is back"));
    EXPECT_TRUE(gains_control()) << program.errors();
    expect_clean_end(program);
}

TEST_F(GpioProgram, TakesAStopLineThatNobodyReadsForOneThatIsActive) {
    Program program = start_to_hang(
        config(line("stop", 0, "force_failsafe") + "[pipeline.main.failsafe]\nrecover = \"0s\"\n"));
    EXPECT_TRUE(program.says("started")) << program.errors();
    EXPECT_TRUE(gains_control()) << program.errors();
    program.signal(SIGURG);
    EXPECT_TRUE(is_in_failsafe());
    EXPECT_TRUE(program.says("output servos: in failsafe; waits for the GPIO line"));
    EXPECT_TRUE(program.says("line stop (L0): is gone; waiting for it"));
    program.signal(SIGHUP);
    EXPECT_TRUE(program.says("reloaded"));
    std::this_thread::sleep_for(std::chrono::seconds(1));
    EXPECT_EQ(count_of("line stop (L0)", program.errors()), 1U) << "a reload changes nothing";
    EXPECT_TRUE(is_in_failsafe());
    program.signal(SIGURG);
    EXPECT_TRUE(program.says("line stop (L0): is back"));
    EXPECT_TRUE(gains_control()) << program.errors();
    program.signal(SIGTERM);
    EXPECT_EQ(program.end(), 0);
}

TEST_F(GpioProgram, PicksAnInputWhileALineIsActive) {
    FarEnd& spare = device("spare");
    Repeater backup(spare, ibus_bytes(sticks_with_first(1750)));
    const std::string file = write_config(
        "[input.receiver]\nprotocol = \"ibus\"\ndevice = \"@receiver\"\ntimeout = \"5s\"\n"
        "[input.spare]\nprotocol = \"ibus\"\ndevice = \"@spare\"\ntimeout = \"5s\"\n"
        "[output.servos]\nprotocol = \"sbus\"\ndevice = \"@servos\"\nperiod = \"20ms\"\n"
        "[pipeline.main]\nfrom = [\"receiver\", \"spare\"]\nto = \"servos\"\n" +
        line("pick", 0, "select", "input = \"spare\""));
    Program& program = run(file);
    const auto says_first = [&](int microseconds) {
        return while_sending([&] {
            backup.send_if_due();
            return latest([&](const SbusSight& sight) {
                return sight.good() && sight.raw[0] == sbus_raw(microseconds);
            });
        });
    };
    EXPECT_TRUE(says_first(1250));
    bank_.pull(0, true);
    EXPECT_TRUE(says_first(1750));
    bank_.pull(0, false);
    EXPECT_TRUE(says_first(1250));
    expect_clean_end(program);
}

TEST_F(GpioProgram, MakesAChannelFromAButton) {
    Program& program = run(config("[pipeline.main.channels]\n12 = { line = \"bind\" }\n" +
                                  line("bind", 0, "button", "bias = \"pull_up\"")));
    const auto twelve_is = [&](int microseconds) {
        return while_sending([&] {
            return latest([&](const SbusSight& sight) {
                return sight.good() && sight.raw[11] == sbus_raw(microseconds);
            });
        });
    };
    bank_.pull(0, false);
    EXPECT_TRUE(twelve_is(1000));
    bank_.pull(0, true);
    EXPECT_TRUE(twelve_is(2000));
    bank_.pull(0, false);
    EXPECT_TRUE(twelve_is(1000));
    expect_clean_end(program);
}

TEST_F(GpioProgram, SwitchesALineByAChannelAsItIsSent) {
    Program& program =
        run(config(line("light", 0, "switch", "output = \"servos\"\nchannel = 1\nabove = 1700") +
                   line("inverse", 1, "switch",
                        "output = \"servos\"\nchannel = 1\nabove = 1700\nactive_low = true")));
    EXPECT_TRUE(gains_control());
    EXPECT_TRUE(while_sending([&] { return is(0, "0") && is(1, "1"); }));
    repeater_.change(ibus_bytes(sticks_with_first(1800)));
    EXPECT_TRUE(while_sending([&] { return is(0, "1") && is(1, "0"); }));
    repeater_.change(ibus_bytes(sticks_with_first(1250)));
    EXPECT_TRUE(while_sending([&] { return is(0, "0") && is(1, "1"); }));
    expect_clean_end(program);
}

TEST_F(GpioProgram, HoldsTheInverterFromStartToEnd) {
    const LevelTrace trace;
    Program& program = run(config(line("inverter", 3, "inverter")));
    EXPECT_TRUE(is(3, "1"));
    EXPECT_TRUE(gains_control());
    expect_clean_end(program);
    const auto levels = trace.levels();
    EXPECT_FALSE(levels.empty());
    EXPECT_EQ(std::count(levels.begin(), levels.end(), "0"), 0);
    EXPECT_TRUE(is(3, "0")) << "the line was not released";
}

TEST_F(GpioProgram, GoesOnWithALampThatWasPulledOutAndPutBack) {
    Program& program = run(config(line("lamp", 0, "link")));
    EXPECT_TRUE(while_sending([&] { return is(0, "1"); }));
    bank_.remove();
    EXPECT_TRUE(program.says("line lamp (L0): is gone; waiting for it")) << program.errors();
    EXPECT_TRUE(gains_control()) << "no control without the lamp";
    bank_.put_back();
    EXPECT_TRUE(program.says("line lamp (L0): is back")) << program.errors();
    EXPECT_TRUE(while_sending([&] { return is(0, "1"); }));
    EXPECT_EQ(count_of("line lamp", program.errors()), 2U) << program.errors();
    expect_clean_end(program);
}

TEST_F(GpioProgram, NamesThePlaceOfALineThatIsNotThere) {
    const std::string file = config(line("lamp", 9, "link"));
    Program& program = start({"run", file});
    EXPECT_EQ(program.end(), 1);
    EXPECT_NE(program.errors().find(file + ":13:8: L9: no "), std::string::npos)
        << program.errors();
}

TEST_F(GpioProgram, KeepsItsLinesInAThreadJustBehindTheDataThread) {
    Program& program = run(config(line("lamp", 0, "link")));
    const std::string threads = shell("ps -eLo comm,cls,rtprio");
    EXPECT_TRUE(std::regex_search(threads, std::regex("tribus-data +FF +80"))) << threads;
    EXPECT_TRUE(std::regex_search(threads, std::regex("tribus-gpio +FF +79"))) << threads;
    expect_clean_end(program);
}

TEST_F(GpioProgram, TakesOtherLinesAtAReload) {
    Program& program = run(config(line("lamp", 0, "link")));
    EXPECT_TRUE(while_sending([&] { return is(0, "1"); }));
    config(line("lamp", 2, "link"));
    program.signal(SIGHUP);
    EXPECT_TRUE(program.says("started", 2)) << program.errors();
    EXPECT_TRUE(while_sending([&] { return is(2, "1") && is(0, "0"); }));
    expect_clean_end(program);
}

}  // namespace
}  // namespace tribus::test::gpio_program_test
