#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/bench/ppm.h"
#include "tests/lab/gpio_bank.h"
#include "tests/lab/ppm_player.h"
#include "tests/lab/recorded_receiver.h"
#include "tests/lab/shell.h"
#include "tests/lab/spi_butterfly.h"
#include "tests/loopback/few_descriptors.h"
#include "tests/loopback/loopback.h"

/// The built program with PPM: in by a line of a simulated chip (gpio-sim), out by an SPI port that
/// the driver spi-butterfly makes of the emulator's parallel port, whose every write is traced. The
/// guest's clock counts its instructions, so times may be judged.
namespace tribus::test::ppm_program_test {
namespace {

using namespace std::chrono_literals;
using Channels = std::vector<double>;

constexpr std::size_t kChannels = 8;
/// A pulse is at most so far off in this guest: its interrupts came up to 19 us late. An edge that
/// is lost or too many moves a channel by hundreds; ppm_line_test.cpp judges each distance by the
/// player's own clock.
constexpr double kSlackMicroseconds = 40;

Channels us_of(const SbusSight& sight) {
    Channels channels;
    for (std::size_t channel = 0; channel < kChannels; ++channel) {
        channels.push_back(sight.raw.at(channel) * 0.625 + 880);
    }
    return channels;
}

bool near(const Channels& a, const Channels& b) {
    for (std::size_t channel = 0; channel < kChannels; ++channel) {
        if (std::abs(a.at(channel) - b.at(channel)) > kSlackMicroseconds) {
            return false;
        }
    }
    return true;
}

/// The first channels of a recording of real sticks and of its twin, so many frames of each.
std::vector<Channels> recorded_channels(std::size_t count) {
    std::vector<Channels> frames;
    for (const Capture capture : captures()) {
        const std::vector<Sticks> all = recorded_sticks(capture);
        EXPECT_GE(all.size(), count);
        for (const Sticks& sticks : std::span(all).first(std::min(count, all.size()))) {
            frames.emplace_back(sticks.begin(), sticks.begin() + kChannels);
        }
    }
    return frames;
}

class LabPpmProgram : public Loopback {
  protected:
    LabPpmProgram() { require_guest(); }

    std::string from_line(const std::string& input = "") {
        return write_config("[input.trainer]\nprotocol = \"ppm\"\nline = \"PPM\"\n" + input +
                            "[output.servos]\nprotocol = \"sbus\"\ndevice = \"@servos\"\n"
                            "period = \"20ms\"\n"
                            "[pipeline.main]\nfrom = \"trainer\"\nto = \"servos\"\n"
                            "[pipeline.main.failsafe]\nhold = \"0s\"\nrecover = \"0s\"\n");
    }
    /// Plays the frame until the servos show it, at most ten times. Every frame that says it is
    /// good must be this one or the one before.
    bool arrives(PpmPlayer& player, const Channels& channels, const Channels& before) {
        for (int played = 0; played < 10; ++played) {
            player.play(channels, 8000);
            for (const SbusSight& sight : servos_.listen()) {
                const Channels seen = us_of(sight);
                if (sight.good() && near(seen, channels)) {
                    return true;
                }
                EXPECT_TRUE(!sight.good() || near(seen, before)) << testing::PrintToString(seen);
            }
        }
        return false;
    }

    GpioBank bank_{{.names = {{3, "PPM"}}}};
    FarEnd& receiver_ = device("receiver");
    FarEnd& servo_wire_ = device("servos");
    ServoBank servos_{servo_wire_};
};

TEST_F(LabPpmProgram, ARecordingArrivesFrameByFrame) {
    Program& program = run(from_line());
    PpmPlayer player(bank_, 3);
    Channels before(kChannels, 1500);
    for (const Channels& channels : recorded_channels(100)) {
        ASSERT_TRUE(arrives(player, channels, before)) << testing::PrintToString(channels);
        before = channels;
    }
    expect_clean_end(program);
}

TEST_F(LabPpmProgram, IsInFailsafeWhenThePulsesEndAndComesBack) {
    Program& program = run(from_line());
    PpmPlayer player(bank_, 3);
    const Channels rest(kChannels, 1500);
    const Channels moved(kChannels, 1700);
    EXPECT_TRUE(arrives(player, rest, rest));
    EXPECT_TRUE(arrives(player, moved, rest));
    const auto ended = Clock::now();
    EXPECT_TRUE(eventually([&] {
        const auto heard = servos_.listen();
        return !heard.empty() && heard.back().failsafe;
    }));
    // The timeout of 150 ms, one period and the test's own rhythm.
    EXPECT_LT(Clock::now() - ended, 250ms);
    EXPECT_TRUE(arrives(player, rest, moved));
    expect_clean_end(program);
}

TEST_F(LabPpmProgram, NoiseOnTheLineIsNoControl) {
    Program& program = run(from_line());
    PpmPlayer player(bank_, 3);
    for (const double distance_us : {400.0, 1500.0, 3000.0}) {
        player.play_noise(40, distance_us);
    }
    for (const SbusSight& sight : servos_.listen()) {
        EXPECT_FALSE(sight.good());
    }
    expect_clean_end(program);
}

TEST_F(LabPpmProgram, OpensItsLineAgainWhenTheChipIsBack) {
    Program& program = run(from_line());
    const Channels rest(kChannels, 1500);
    {
        PpmPlayer player(bank_, 3);
        EXPECT_TRUE(arrives(player, rest, rest));
    }
    bank_.remove();
    EXPECT_TRUE(eventually([&] {
        const auto heard = servos_.listen();
        return !heard.empty() && heard.back().failsafe;
    }));
    bank_.put_back();
    EXPECT_TRUE(program.says("line PPM: is back")) << program.errors();
    PpmPlayer player(bank_, 3);
    EXPECT_TRUE(arrives(player, rest, rest)) << program.errors();
    expect_clean_end(program);
}

TEST_F(LabPpmProgram, JitterOfALineIsMeasured) {
    tl::expected<bench::PpmResult, std::string> jitter;
    std::thread reader([&] { jitter = bench::measure_ppm("PPM", 3s); });
    PpmPlayer player(bank_, 3);
    const Channels rest{1500, 1500, 1000, 1500, 1200, 1800, 1500, 1500};
    for (int frame = 0; frame < 40; ++frame) {
        player.play(rest, 8000);
    }
    reader.join();
    ASSERT_TRUE(jitter) << jitter.error();
    EXPECT_EQ(jitter->channels, kChannels);
    for (const double percent : {50.0, 90.0, 99.0}) {
        std::cout << "p" << percent << ": " << jitter->stamped.percentile(percent).count()
                  << " ns, by the reader's clock " << jitter->bare.percentile(percent).count()
                  << " ns\n";
    }
}

TEST_F(LabPpmProgram, JitterOfALineWithoutPulsesIsRefused) {
    const auto jitter = bench::measure_ppm("PPM", 1s);
    ASSERT_FALSE(jitter);
    EXPECT_EQ(jitter.error().rfind("PPM: no PPM came", 0), 0U) << jitter.error();
}

TEST_F(LabPpmProgram, SaysWhoMayUseALine) {
    const std::string file = from_line();
    shell("chmod -R a+rwX " + folder().string());
    const ShellResult result = run_shell(
        "setpriv --reuid nobody --regid nogroup --clear-groups timeout 5 " TRIBUS_PROGRAM " run " +
        file);
    EXPECT_NE(result.output.find("no permission to open it; GPIO chips"), std::string::npos)
        << result.output;
}

TEST_F(LabPpmProgram, DoctorSaysWhetherALineIsFree) {
    Program& free = start({"doctor", "PPM"});
    EXPECT_EQ(free.end(), 0) << free.errors();
    EXPECT_NE(free.output().find("line   3  PPM                  free\n"), std::string::npos)
        << free.output();
    EXPECT_NE(free.output().find("    line     = \"PPM\"\n"), std::string::npos);
    Program& program = run(from_line());
    EXPECT_TRUE(program.says("started")) << program.errors();
    Program& used = start({"doctor", "PPM"});
    EXPECT_EQ(used.end(), 1);
    EXPECT_NE(used.output().find("in use by \"tribus\""), std::string::npos) << used.output();
    Program& all = start({"doctor"});
    all.end();
    EXPECT_NE(all.output().find("GPIO chip with 8 lines, 1 of them in use"), std::string::npos)
        << all.output();
    expect_clean_end(program);
}

/// Where pulses begin among the bits that an SPI port sent.
class SentPulses {
  public:
    /// The frames that became whole with these bits: where each pulse begins, by the bits since the
    /// first pulse of its frame.
    std::vector<std::vector<std::size_t>> frames(const std::vector<bool>& bits) {
        std::vector<std::vector<std::size_t>> whole;
        for (const bool up : bits) {
            ++bits_;
            if (up && !up_) {
                frame_.push_back(bits_);
            }
            up_ = up;
            // Longer than any channel, shorter than every pause.
            if (!frame_.empty() && bits_ - frame_.back() == 2500) {
                const std::size_t first = frame_.front();
                for (std::size_t& bit : frame_) {
                    bit -= first;
                }
                whole.push_back(std::exchange(frame_, {}));
            }
        }
        return whole;
    }

  private:
    std::size_t bits_ = 0;
    bool up_ = false;
    std::vector<std::size_t> frame_;
};

Channels distances(const std::vector<std::size_t>& pulses) {
    Channels channels;
    for (std::size_t pulse = 1; pulse < pulses.size(); ++pulse) {
        channels.push_back(static_cast<double>(pulses[pulse] - pulses[pulse - 1]));
    }
    return channels;
}

class LabPpmSpi : public LabPpmProgram {
  protected:
    std::string to_spi() const {
        return "[input.receiver]\nprotocol = \"ibus\"\ndevice = \"@receiver\"\ntimeout = "
               "\"200ms\"\n"
               "[output.trainer]\nprotocol = \"ppm\"\nline = \"" +
               port() +
               "\"\nperiod = \"100ms\"\n[pipeline.out]\nfrom = \"receiver\"\nto = \"trainer\"\n"
               "[pipeline.out.failsafe]\nhold = \"0s\"\nrecover = \"0s\"\n";
    }
    /// Sends the sticks until a frame on the wire has them. The period is long, because this driver
    /// makes each bit with the guest's only processor.
    bool leaves(const Sticks& sticks) {
        Repeater repeater(receiver_, ibus_bytes(sticks));
        const Channels wanted(sticks.begin(), sticks.begin() + kChannels);
        return eventually([&] {
            repeater.send_if_due();
            for (const auto& pulses : pulses_.frames(port_.sent_bits())) {
                if (distances(pulses) == wanted) {
                    return true;
                }
            }
            return false;
        });
    }
    /// The trace has what was sent since the start of the guest.
    void forget_what_was_sent() { port_.sent_bits(); }
    bool nothing_was_sent() { return port_.sent_bits().empty(); }
    const std::string& port() const { return port_.device(); }

  private:
    SpiButterfly port_;
    SentPulses pulses_;
};

TEST_F(LabPpmSpi, EachFrameOnTheWireHasTheChannelsToTheMicrosecond) {
    Program& program = run(write_config(to_spi()));
    int number = 0;
    for (const Channels& channels : recorded_channels(400)) {
        if (++number % 80 != 0) {
            continue;
        }
        Sticks sticks(channels.begin(), channels.end());
        sticks.resize(18, 1500);
        EXPECT_TRUE(leaves(sticks)) << number;
    }
    expect_clean_end(program);
}

// i.Bus in, pulses out by the SPI port; what was on its wire goes to the GPIO line, SBUS out.
TEST_F(LabPpmSpi, PulsesGoRound) {
    Program& program =
        run(write_config(to_spi() +
                         "[input.trainer]\nprotocol = \"ppm\"\nline = "
                         "\"PPM\"\n[output.servos]\nprotocol = \"sbus\"\ndevice = \"@servos\"\n"
                         "[pipeline.in]\nfrom = \"trainer\"\nto = \"servos\"\n"
                         "[pipeline.in.failsafe]\nhold = \"0s\"\nrecover = \"0s\"\n"));
    PpmPlayer player(bank_, 3);
    Channels before(kChannels, 1500);
    for (const int first : {1100, 1900}) {
        const Sticks sticks = sticks_with_first(first);
        ASSERT_TRUE(leaves(sticks)) << first;
        const Channels on_the_wire(sticks.begin(), sticks.begin() + kChannels);
        EXPECT_TRUE(arrives(player, on_the_wire, before)) << first;
        before = on_the_wire;
    }
    expect_clean_end(program);
}

TEST_F(LabPpmSpi, DoctorTriesAPortAndSendsNothing) {
    forget_what_was_sent();
    Program& doctor = start({"doctor", port()});
    EXPECT_EQ(doctor.end(), 0) << doctor.output();
    EXPECT_NE(doctor.output().find("spi      = \"" + port() + "\"\n"), std::string::npos)
        << doctor.output();
    EXPECT_TRUE(nothing_was_sent());
    const ShellResult other = run_shell(
        "setpriv --reuid nobody --regid nogroup --clear-groups " TRIBUS_PROGRAM " doctor " +
        port());
    EXPECT_EQ(other.status, 1);
    EXPECT_NE(other.output.find("[spi.permission]"), std::string::npos) << other.output;
}

TEST_F(LabPpmSpi, SaysWhoMayUseAPort) {
    const std::string file = write_config(to_spi());
    shell("chmod -R a+rwX " + folder().string());
    const ShellResult result = run_shell(
        "setpriv --reuid nobody --regid nogroup --clear-groups timeout 5 " TRIBUS_PROGRAM " run " +
        file);
    EXPECT_NE(result.output.find(port() + ": this user may not use it"), std::string::npos)
        << result.output;
}

TEST_F(LabPpmSpi, WithTooFewDescriptorsTheProgramEndsAndSaysSo) {
    const std::string file = write_config(
        "[input.trainer]\nprotocol = \"ppm\"\nline = \"PPM\"\n"
        "[output.trainer]\nprotocol = \"ppm\"\nline = \"" +
        port() + "\"\n[pipeline.main]\nfrom = \"trainer\"\nto = \"trainer\"\n");
    const DescriptorTrials trials = run_with_few_descriptors(folder(), file);
    EXPECT_GT(trials.ended, 0);
    EXPECT_GT(trials.ran, 0);
}

}  // namespace
}  // namespace tribus::test::ppm_program_test
