#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/client/ask_daemon.h"
#include "tests/loopback/first_channel.h"
#include "tests/support/sanitized.h"

namespace tribus::test::reload_test {
namespace {

/// A second output for the receiver's channels.
constexpr std::string_view kTail =
    "[output.tail]\nprotocol = \"sbus\"\ndevice = \"@tail\"\nperiod = \"7ms\"\n"
    "[pipeline.tail]\nfrom = \"receiver\"\nto = \"tail\"\n";

/// Writes a file of many messages with 8 signals each.
void write_large_dbc(const std::filesystem::path& path) {
    constexpr int kMessages = 25'000;
    std::ofstream file(path);
    file << "VERSION \"\"\n\nBU_: A B\n";
    for (int message = 0; message < kMessages; ++message) {
        file << "BO_ " << 0x8000'0000U + static_cast<unsigned>(message) << " M" << message
             << ": 8 A\n";
        for (int signal = 0; signal < 8; ++signal) {
            file << " SG_ S" << signal << " : " << 8 * signal
                 << "|8@1+ (0.1,-40) [0|250] \"unit\" B\n";
        }
    }
}

class Reload : public FirstChannel {
  protected:
    std::string with_channel(const std::string& rule) {
        return main_job(kPatientInput, "", "[pipeline.main.channels]\n1 = " + rule);
    }
};

TEST_F(Reload, TakesANewConfiguration) {
    Program& program = run(write_config(main_job(kPatientInput)));
    expect_first_channel(1100);
    write_config(with_channel("{ from = 1, reverse = true }"));
    program.signal(SIGHUP);
    EXPECT_TRUE(program.says("reloaded"));
    expect_first_channel(1900);
    EXPECT_EQ(count_of("in failsafe", program.errors()), 0U) << "the reload was not seamless";
    EXPECT_EQ(servos_.strays(), 0U);
    expect_clean_end(program);
}

TEST_F(Reload, RefusesAConfigurationWithMistakesAndGoesOn) {
    Program& program = run(write_config(main_job(kPatientInput)));
    expect_first_channel(1100);
    const std::string path = write_config(with_channel("{ form = 1, reverse = true }"));
    program.signal(SIGHUP);
    EXPECT_TRUE(program.says("reload refused"));
    EXPECT_EQ(count_of(path + ":14:7: ", program.errors()), 1U) << program.errors();
    expect_first_channel(1100);
    EXPECT_EQ(count_of("started", program.errors()), 1U);
    EXPECT_EQ(count_of("in failsafe", program.errors()), 0U) << "the refusal was not seamless";
    expect_clean_end(program);
}

TEST_F(Reload, RefusesAConfigurationFileThatIsGoneAndGoesOn) {
    const std::string path = write_config(main_job(kPatientInput));
    Program& program = run(path);
    expect_first_channel(1100);
    std::filesystem::remove(path);
    program.signal(SIGHUP);
    EXPECT_TRUE(program.says("reload refused"));
    expect_first_channel(1100);
    expect_clean_end(program);
}

/// Nobody ever writes to the pipe: a program that reads it would wait for ever.
TEST_F(Reload, RefusesAPipeInThePlaceOfTheFileAndGoesOn) {
    const std::string path = write_config(main_job(kPatientInput));
    Program& program = run(path);
    expect_first_channel(1100);
    std::filesystem::remove(path);
    ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
    program.signal(SIGHUP);
    EXPECT_TRUE(program.says("it is a device or a pipe, not a file")) << program.errors();
    expect_first_channel(1100);
    expect_clean_end(program);
}

/// A loop sends the signal as often as it can.
TEST_F(Reload, AStormOfSignalsKeepsNothingFromItsTurn) {
    Program& program = run(write_config(main_job(kPatientInput)));
    std::atomic<bool> over{false};
    // Up to the end of the program, whose object this thread may not touch.
    std::thread storm([&over, pid = program.pid()] {
        while (!over) {
            ::kill(pid, SIGHUP);
            const timespec pause{.tv_sec = 0, .tv_nsec = 300'000};
            ::nanosleep(&pause, nullptr);
        }
    });
    const auto begin = Clock::now();
    expect_first_channel(1100);
    EXPECT_TRUE(program.says("reloaded", 2));
    const auto seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    EXPECT_LE(static_cast<double>(count_of("reloaded", program.errors())), 2 + 10 * seconds);
    EXPECT_TRUE(ask_daemon(folder() / "control", "status", kPatience));
    receiver_.pull();
    EXPECT_TRUE(program.says("is gone"));
    program.signal(SIGTERM);
    EXPECT_EQ(program.end(), 0);
    over = true;
    storm.join();
}

/// Reading the files takes several seconds: 6 times 11 MB.
TEST_F(Reload, KeepsNothingWaitingWithLargeFiles) {
    Program& program = run(write_config(main_job(kPatientInput)));
    expect_first_channel(1100);
    write_large_dbc(folder() / "large.dbc");
    std::string text = main_job(kPatientInput);
    for (int i = 0; i < 6; ++i) {
        text += "[output.bus" + std::to_string(i) + "]\nprotocol = \"dbc\"\ninterface = \"can" +
                std::to_string(i) +
                "\"\ndbc = \"large.dbc\"\nsignals.M0.S0 = { channel = 1 }\n[pipeline.bus" +
                std::to_string(i) + "]\nfrom = \"receiver\"\nto = \"bus" + std::to_string(i) +
                "\"\n";
    }
    write_config(text);
    program.signal(SIGHUP);
    const auto status = ask_daemon(folder() / "control", "status", kPatience);
    EXPECT_TRUE(status) << status.error();
    expect_first_channel(1100);
    program.signal(SIGTERM);
    EXPECT_EQ(program.end(), 0) << program.errors();
    EXPECT_NE(program.errors().find("stopped"), std::string::npos) << program.errors();
    EXPECT_EQ(program.errors().find("reload refused"), std::string::npos)
        << "the files were read before the answer and the end: this shows nothing\n"
        << program.errors();
}

TEST_F(Reload, RefusesAConfigurationWhoseDeviceIsMissingAndGoesOn) {
    Program& program = run(write_config(main_job(kPatientInput)));
    expect_first_channel(1100);
    std::string text = with_channel("{ from = 1, reverse = true }");
    text.replace(text.find("@receiver"), 9, "@missing");
    write_config(text);
    program.signal(SIGHUP);
    EXPECT_TRUE(program.says("reload refused"));
    EXPECT_TRUE(program.says("missing: there is no such device"));
    expect_first_channel(1100);
    EXPECT_EQ(count_of("in failsafe", program.errors()), 0U) << "the refusal was not seamless";
    expect_clean_end(program);
}

/// A device is unplugged during a reload: the remaining outputs must go on.
TEST_F(Reload, WhileADeviceIsGoneDoesNotEndTheProgram) {
    Program& program = run(write_config(main_job("timeout = \"2s\"")));
    expect_first_channel(1100);
    receiver_.pull();
    EXPECT_TRUE(program.says("is gone"));
    program.signal(SIGHUP);
    EXPECT_TRUE(program.says("reloaded"));
    servos_.listen();
    EXPECT_TRUE(eventually([&] {
        const auto seen = servos_.listen();
        return !seen.empty() && seen.back().failsafe;
    })) << "the output does not say failsafe";
    receiver_.plug_in();
    expect_first_channel(1100);
    EXPECT_TRUE(program.says("is back"));
    expect_clean_end(program);
}

TEST_F(Reload, OpensAndClosesWhatIsNewAndWhatIsGone) {
    ServoBank tail(device("tail"));
    Program& program = run(write_config(main_job(kPatientInput)));
    expect_first_channel(1100);
    const auto descriptors = program.open_descriptors();
    write_config(main_job(kPatientInput) + std::string(kTail));
    program.signal(SIGHUP);
    EXPECT_TRUE(program.says("reloaded"));
    EXPECT_TRUE(eventually([&] {
        repeater_.send_if_due();
        const auto seen = tail.listen();
        return !seen.empty() && seen.back().good() && seen.back().raw[0] == sbus_raw(1100);
    }));
    write_config(main_job(kPatientInput));
    program.signal(SIGHUP);
    EXPECT_TRUE(program.says("reloaded", 2));
    // They may still be on their way through the terminal.
    EXPECT_TRUE(eventually([&] {
        const auto last = tail.listen();
        return !last.empty() && last.back().failsafe;
    })) << "the output's last frames are missing";
    EXPECT_EQ(program.open_descriptors(), descriptors);
    expect_first_channel(1100);
    EXPECT_EQ(count_of("output servos: in failsafe", program.errors()), 0U);
    expect_clean_end(program);
}

/// A device cannot be opened twice, so this port has a gap.
TEST_F(Reload, OpensADeviceAnewWhoseLineSettingsChanged) {
    Program& program = run(write_config(main_job(kPatientInput)));
    expect_first_channel(1100);
    write_config(main_job(kPatientInput, "baud = 200000"));
    program.signal(SIGHUP);
    EXPECT_TRUE(program.says("reloaded"));
    expect_first_channel(1100);
    repeater_.change(ibus_bytes(sticks_with_first(1300)));
    expect_first_channel(1300);
    EXPECT_EQ(count_of("is back", program.errors()), 0U) << "the device was never gone";
    expect_clean_end(program);
}

TEST_F(Reload, WithAStopSaysSoWhereTheSchedulingChanges) {
    Program& program = run(write_config(main_job(kPatientInput)));
    expect_first_channel(1100);
    write_config(main_job(kPatientInput) + "[runtime]\npriority = 70\n");
    program.signal(SIGHUP);
    EXPECT_TRUE(program.says("reload with a stop"));
    EXPECT_TRUE(program.says("started", 2));
    expect_first_channel(1100);
    expect_clean_end(program);
}

/// Half of the time there is a reload about every 60 ms, between two configurations with another
/// map and an output that comes and goes. Half of the time there is none. The two alternate, so
/// that both see the same machine.
class ReloadsUnderLoad : public Reload {
  protected:
    using Gap = std::chrono::nanoseconds;

    /// Feeds the receiver for one turn. Returns the longest time between two frames.
    Gap longest_gap(int reloads_so_far, bool reload) {
        if (reload) {
            const bool with_tail = reloads_so_far % 2 == 1;
            write_config(main_job(kPatientInput, "",
                                  with_tail
                                      ? "[pipeline.main.channels]\n2 = { from = 2, expo = 0.5 }"
                                      : "") +
                         (with_tail ? std::string(kTail) : ""));
            program_->signal(SIGHUP);
        }
        Gap longest{};
        Clock::time_point latest{};
        std::size_t frames = 0;
        bool away = false;
        bool lost = false;
        EXPECT_TRUE(eventually([&] {
            // A machine that stops this test for so long silences the receiver.
            away = away || Clock::now() - repeater_.latest() >= std::chrono::seconds(4);
            repeater_.send_if_due();
            for (const SbusSight& sight : servos_.listen()) {
                const bool fresh = sight.good() && sight.raw[0] == sbus_raw(1100);
                const bool wrong = sight.good() && !fresh;
                marked_ += wrong || (!sight.good() && !away) ? 1U : 0U;
                // The values that did not come while it was silent come again.
                away = away && !(fresh && lost);
                lost = !sight.good();
                longest = frames++ == 0 ? longest : std::max(longest, Gap(sight.seen - latest));
                latest = sight.seen;
            }
            return frames >= 5 && (!reload || count_of("reloaded", program_->errors()) ==
                                                  static_cast<std::size_t>(reloads_so_far));
        }));
        return longest;
    }
    static Gap median(std::vector<Gap> gaps) {
        std::ranges::sort(gaps);
        return gaps[gaps.size() / 2];
    }
    static void tell(const char* what, std::vector<Gap> gaps) {
        std::ranges::sort(gaps);
        const auto us = [](Gap gap) { return static_cast<int>(gap.count() / 1000); };
        std::printf("longest gap of a turn %s: median %d us, p90 %d us, most %d us\n", what,
                    us(gaps[gaps.size() / 2]), us(gaps[gaps.size() * 9 / 10]), us(gaps.back()));
    }

    Program* program_ = nullptr;
    std::size_t marked_ = 0;
};

TEST_F(ReloadsUnderLoad, AHundredInARowDelayNoFrameAndLeakNothing) {
    constexpr int kReloads = 100;
    constexpr int kWarmUp = 20;
    device("tail");
    program_ = &run(write_config(main_job(kPatientInput)));
    expect_first_channel(1100);
    std::vector<Gap> with;
    std::vector<Gap> without;
    std::ptrdiff_t descriptors = 0;
    std::array<long, 2> memory{};
    for (int i = 1; i <= kReloads; ++i) {
        with.push_back(longest_gap(i, true));
        without.push_back(longest_gap(i, false));
        if (i == kWarmUp) {
            descriptors = program_->open_descriptors();
            memory = {program_->memory_kib("RssAnon"), program_->memory_kib("VmData")};
        }
    }
    tell("with a reload", with);
    tell("without", without);
    std::printf("memory after %d and %d reloads: RssAnon %ld and %ld KiB, VmData %ld and %ld KiB\n",
                kWarmUp, kReloads, memory[0], program_->memory_kib("RssAnon"), memory[1],
                program_->memory_kib("VmData"));
    EXPECT_EQ(marked_, 0U) << "some frames were not fresh and in control";
    EXPECT_EQ(servos_.strays(), 0U);
    EXPECT_LT(median(with), 2 * median(without));
    EXPECT_EQ(program_->open_descriptors(), descriptors);
    // A sanitizer keeps freed memory for a while.
    if (!kSanitized) {
        // Memory that it maps for a moment behind a reload is no leak.
        EXPECT_TRUE(eventually([&] {
            return program_->memory_kib("RssAnon") <= memory[0] + 128 &&
                   program_->memory_kib("VmData") <= memory[1] + 128;
        }));
    }
    EXPECT_EQ(count_of("in failsafe", program_->errors()), 0U);
    expect_clean_end(*program_);
}

}  // namespace
}  // namespace tribus::test::reload_test
