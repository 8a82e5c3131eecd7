#include <csignal>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "app/client/ask_daemon.h"
#include "tests/loopback/first_channel.h"

namespace tribus::test::trial_test {
namespace {

constexpr std::string_view kReversed = "[pipeline.main.channels]\n1 = { from = 1, reverse = true }";

/// A new configuration turns the 1100 us into 1900.
class Trial : public FirstChannel {
  protected:
    Program& begin() {
        Program& program = run(write_config(main_job(kPatientInput)));
        expect_first_channel(1100);
        // The status, which `diff` asks for, follows a little later.
        EXPECT_TRUE(program.says("under control of receiver"));
        write_config(main_job(kPatientInput, "", kReversed));
        return program;
    }
    std::string socket() const { return folder() / "control"; }
    /// Runs `tribus reload` to its end while the receiver goes on.
    int reload(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), {"reload", "--socket", socket()});
        Program& asked = start(arguments);
        EXPECT_TRUE(eventually([&] {
            repeater_.send_if_due();
            servos_.listen();
            return !asked.runs();
        }));
        said_ = asked.errors();
        return asked.end().value_or(-1);
    }
    static void expect_seamless_end(Program& program) {
        EXPECT_EQ(count_of("in failsafe", program.errors()), 0U) << "the reload was not seamless";
        expect_clean_end(program);
    }

    std::string said_;
};

TEST_F(Trial, ReloadTakesTheFileAsItIsNow) {
    Program& program = begin();
    EXPECT_EQ(reload({}), 0);
    EXPECT_EQ(said_, "tribus: taken\n");
    expect_first_channel(1900);
    expect_seamless_end(program);
}

TEST_F(Trial, ReloadOfAFileWithMistakesFailsAndNamesThem) {
    Program& program = begin();
    const std::string path = write_config(main_job(kPatientInput, "", "form = 1"));
    EXPECT_EQ(reload({}), 1);
    EXPECT_EQ(said_.find(path + ":13:1: "), 0U) << said_;
    EXPECT_NE(said_.find("tribus: refused; the configuration before stays\n"), std::string::npos);
    expect_first_channel(1100);
    expect_seamless_end(program);
}

TEST_F(Trial, ThatNobodyConfirmsGoesBackByItself) {
    Program& program = begin();
    EXPECT_EQ(reload({"--trial", "1s"}), 0);
    expect_first_channel(1900);
    expect_first_channel(1100);
    EXPECT_TRUE(program.says("the trial was not confirmed"));
    expect_seamless_end(program);
}

TEST_F(Trial, ThatIsConfirmedStays) {
    Program& program = begin();
    EXPECT_EQ(reload({"--trial", "1000s"}), 0);
    EXPECT_EQ(reload({"--confirm"}), 0);
    EXPECT_EQ(said_, "tribus: confirmed\n");
    EXPECT_EQ(reload({"--back"}), 1);
    EXPECT_EQ(said_, "tribus: no configuration is on trial\n");
    expect_first_channel(1900);
    expect_seamless_end(program);
}

TEST_F(Trial, GoesBackAtOnceWhereAsked) {
    Program& program = begin();
    EXPECT_EQ(reload({"--trial", "1000s"}), 0);
    expect_first_channel(1900);
    EXPECT_EQ(reload({"--back"}), 0);
    EXPECT_EQ(said_, "tribus: the configuration before is back\n");
    expect_first_channel(1100);
    expect_seamless_end(program);
}

TEST_F(Trial, AfterATrialGoesBackToWhatWasConfirmedLast) {
    Program& program = begin();
    EXPECT_EQ(reload({"--trial", "1000s"}), 0);
    write_config(main_job(kPatientInput, "", "[pipeline.main.channels]\n1 = { fixed = 1300 }"));
    EXPECT_EQ(reload({"--trial", "1000s"}), 0);
    expect_first_channel(1300);
    EXPECT_EQ(reload({"--back"}), 0);
    expect_first_channel(1100);
    expect_seamless_end(program);
}

TEST_F(Trial, GoesBackAlsoToADeviceThatIsGoneMeanwhile) {
    FarEnd& other = device("other");
    Program& program = begin();
    std::string text = main_job(kPatientInput);
    text.replace(text.find("@receiver"), 9, "@other");
    write_config(text);
    EXPECT_EQ(reload({"--trial", "1000s"}), 0);
    receiver_.pull();
    EXPECT_EQ(reload({"--back"}), 0);
    servos_.listen();
    EXPECT_TRUE(eventually([&] {
        const auto seen = servos_.listen();
        return !seen.empty() && seen.back().failsafe;
    })) << "the output without a receiver does not say failsafe";
    EXPECT_TRUE(program.says("device " + receiver_.path() + ": is gone; waiting for it"));
    receiver_.plug_in();
    expect_first_channel(1100);
    EXPECT_TRUE(other.receive().empty());
    expect_clean_end(program);
}

/// The draft is on trial, and the file stays as it is.
TEST_F(Trial, RunsADraftAndGoesBackToTheFile) {
    const std::string config = write_config(main_job(kPatientInput, "", kReversed));
    std::ifstream reversed(config);
    const std::string text{std::istreambuf_iterator<char>(reversed), {}};
    Program& program = run(write_config(main_job(kPatientInput)));
    expect_first_channel(1100);
    const auto ask = [&](std::string_view request) {
        const auto answer = ask_daemon(socket(), request, kPatience);
        EXPECT_TRUE(answer) << answer.error();
        return answer.value_or(nlohmann::json::object());
    };
    const auto before = ask("status");
    EXPECT_TRUE(before["trial"].is_null());
    const std::string file = ask("draft")["file"];
    std::ofstream(file) << text;
    const auto outcome = ask("reload draft 1000s");
    EXPECT_EQ(outcome["taken"], true) << outcome;
    expect_first_channel(1900);
    const auto trial = ask("status");
    EXPECT_EQ(trial["trial"], outcome["trial"]);
    EXPECT_NE(trial["fingerprint"], before["fingerprint"]);
    EXPECT_EQ(ask("back " + outcome["trial"].dump())["taken"], true);
    expect_first_channel(1100);
    EXPECT_EQ(ask("status")["fingerprint"], before["fingerprint"]);
    expect_seamless_end(program);
}

TEST_F(Trial, ADraftNeedsTheLengthOfATrialAndItsMistakesNameTheRealFile) {
    const std::string config = write_config(main_job(kPatientInput));
    Program& program = run(config);
    expect_first_channel(1100);
    for (const std::string_view request : {"reload draft", "reload draft 0s", "reload draft x"}) {
        const auto refused = ask_daemon(socket(), request, kPatience);
        ASSERT_FALSE(refused) << request;
        EXPECT_NE(refused.error().find("needs it"), std::string::npos) << refused.error();
    }
    const auto folder = ask_daemon(socket(), "draft", kPatience);
    ASSERT_TRUE(folder) << folder.error();
    std::ofstream((*folder)["file"].get<std::string>()) << "[input.a]\nprotocol = \"x\"\n";
    const auto outcome = ask_daemon(socket(), "reload draft 10s", kPatience);
    ASSERT_TRUE(outcome) << outcome.error();
    EXPECT_EQ((*outcome)["taken"], false);
    EXPECT_EQ((*outcome)["lines"][1].get<std::string>().find(config + ":2:12: "), 0U) << *outcome;
    expect_first_channel(1100);
    expect_seamless_end(program);
}

TEST_F(Trial, ShowsHowMuchTimeIsLeft) {
    Program& program = begin();
    const auto left = [&] {
        const auto status = ask_daemon(socket(), "status", kPatience);
        EXPECT_TRUE(status) << status.error();
        return status ? (*status)["trial_left_us"] : nlohmann::json();
    };
    EXPECT_TRUE(left().is_null());
    EXPECT_EQ(reload({"--trial", "1000s"}), 0);
    const auto told = left();
    ASSERT_TRUE(told.is_number());
    EXPECT_LE(told, 1'000'000'000);
    EXPECT_GT(told, 900'000'000);
    expect_seamless_end(program);
}

/// A sender of SIGHUP, such as `systemctl reload`, knows nothing of the trial.
TEST_F(Trial, IsNotConfirmedBySighup) {
    Program& program = begin();
    EXPECT_EQ(reload({"--trial", "3s"}), 0);
    program.signal(SIGHUP);
    EXPECT_TRUE(program.says("still on trial"));
    expect_first_channel(1900);
    expect_first_channel(1100);
    EXPECT_TRUE(program.says("the trial was not confirmed"));
    expect_seamless_end(program);
}

TEST_F(Trial, IsConfirmedByItsOwnNumberOrByNone) {
    Program& program = begin();
    const auto ask = [&](const std::string& request) {
        const auto answer = ask_daemon(socket(), request, kPatience);
        return answer ? answer->value("trial", nlohmann::json()).dump() : answer.error();
    };
    EXPECT_EQ(ask("reload 1000s"), "1");
    EXPECT_EQ(ask("reload 1000s"), "2");
    EXPECT_EQ(ask("confirm 1"), "that trial is over; the present one is number 2");
    EXPECT_EQ(ask("back 1"), "that trial is over; the present one is number 2");
    EXPECT_EQ(ask("confirm 2"), "null");
    EXPECT_EQ(ask("confirm 2"), "no configuration is on trial");
    EXPECT_EQ(ask("reload 1000s"), "3");
    EXPECT_EQ(ask("confirm"), "null");
    EXPECT_EQ(ask("back"), "no configuration is on trial");
    expect_first_channel(1900);
    expect_clean_end(program);
}

TEST_F(Trial, WithoutAPeriodThatMakesSenseIsRefused) {
    Program& program = begin();
    EXPECT_EQ(reload({"--trial", "soon"}), 2);
    EXPECT_EQ(reload({"--trial", "1ms"}), 1);
    EXPECT_NE(said_.find("from \"1s\" to \"3600s\""), std::string::npos) << said_;
    expect_first_channel(1100);
    expect_seamless_end(program);
}

/// A person at a terminal who presses a key.
class TrialInATerminal : public Trial {
  protected:
    int try_and_press(std::uint8_t key) {
        FarEnd& terminal = device("terminal");
        Program& asked = start({"reload", "--socket", socket(), "--trial", "1000s"},
                               {.executable = TRIBUS_PROGRAM, .terminal = terminal.path()});
        bool pressed = false;
        EXPECT_TRUE(eventually([&] {
            repeater_.send_if_due();
            servos_.listen();
            if (!pressed && asked.errors().find("Enter keeps it") != std::string::npos) {
                pressed = terminal.send(Bytes{key});
            }
            return !asked.runs();
        }));
        said_ = asked.errors();
        return asked.end().value_or(-1);
    }
};

/// Somebody else has started another trial meanwhile.
TEST_F(TrialInATerminal, EnterKeepsNoOtherTrial) {
    Program& program = begin();
    FarEnd& terminal = device("terminal");
    Program& asked = start({"reload", "--socket", socket(), "--trial", "1000s"},
                           {.executable = TRIBUS_PROGRAM, .terminal = terminal.path()});
    EXPECT_TRUE(asked.says("Enter keeps it"));
    EXPECT_EQ(reload({"--trial", "1000s"}), 0);
    terminal.send(Bytes{'\n'});
    EXPECT_EQ(asked.end(), 1);
    EXPECT_NE(asked.errors().find("that trial is over"), std::string::npos) << asked.errors();
    const auto status = ask_daemon(socket(), "status", kPatience);
    ASSERT_TRUE(status) << status.error();
    EXPECT_TRUE((*status)["trial_left_us"].is_number()) << "the other trial was ended";
    expect_clean_end(program);
}

TEST_F(TrialInATerminal, EnterKeepsIt) {
    Program& program = begin();
    EXPECT_EQ(try_and_press('\n'), 0);
    EXPECT_NE(said_.find("tribus: confirmed\n"), std::string::npos) << said_;
    expect_first_channel(1900);
    expect_seamless_end(program);
}

TEST_F(TrialInATerminal, CtrlCGoesBack) {
    Program& program = begin();
    EXPECT_EQ(try_and_press(0x03), 0);
    EXPECT_NE(said_.find("tribus: the configuration before is back\n"), std::string::npos) << said_;
    expect_first_channel(1100);
    expect_seamless_end(program);
}

TEST_F(Trial, DiffShowsWhatTheSticksWouldDo) {
    Program& program = begin();
    Program& asked = start({"diff", folder() / "tribus.toml", "--socket", socket()});
    EXPECT_TRUE(eventually([&] {
        repeater_.send_if_due();
        return !asked.runs();
    }));
    EXPECT_EQ(asked.end(), 0) << asked.errors();
    EXPECT_EQ(asked.output(),
              "pipeline main:\n"
              "  channel 1: channel 1 before, now channel 1, reverse\n"
              "  (applies from the next frame of its outputs)\n"
              "with the inputs as they are now (receiver good):\n"
              "output servos:\n"
              "  channel 1: 1100 us now, then 1900 us\n");
    expect_clean_end(program);
}

/// The diff comes true, with a receiver that has more channels than the default of its protocol.
TEST_F(Trial, DiffShowsWhatTheReloadThenDoesWithEighteenChannels) {
    Sticks sticks(18, 1500);
    sticks[0] = 1100;
    sticks[17] = 1900;
    repeater_.change(ibus_bytes(sticks));
    Program& program = run(write_config(main_job(kPatientInput)));
    expect_first_channel(1100);
    EXPECT_TRUE(program.says("under control of receiver"));
    write_config(main_job(kPatientInput, "", "[pipeline.main.channels]\n1 = 18"));
    Program& asked = start({"diff", folder() / "tribus.toml", "--socket", socket()});
    EXPECT_TRUE(eventually([&] {
        repeater_.send_if_due();
        servos_.listen();
        return !asked.runs();
    }));
    EXPECT_EQ(count_of("  channel 1: 1100 us now, then 1900 us\n", asked.output()), 1U)
        << asked.output() << asked.errors();
    EXPECT_EQ(reload({}), 0);
    expect_first_channel(1900);
    expect_seamless_end(program);
}

}  // namespace
}  // namespace tribus::test::trial_test
