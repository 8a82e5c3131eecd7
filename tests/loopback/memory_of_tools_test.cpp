#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/loopback/loopback.h"

/// Memory of the commands that read recordings: whatever they are given.
namespace tribus::test::memory_of_tools_test {
namespace {

constexpr long kMostKib = 30 * 1024;
/// Input that would not fit, if it were kept.
constexpr long kEnoughBytes = 4 * kMostKib * 1024;

/// Bytes that a program has read, from /proc/PID/io; 0 if it has ended.
long read_by(const Program& program) {
    std::ifstream io("/proc/" + std::to_string(program.pid()) + "/io");
    std::string name;
    long bytes = 0;
    io >> name >> bytes;
    return bytes;
}

class MemoryOfTools : public Loopback {
  protected:
    void SetUp() override {
        if (kSanitized) {
            GTEST_SKIP() << "the sanitizer takes memory of its own";
        }
    }
    /// Peak of its memory until it ends or has read enough, at most for some seconds.
    long peak_of(const std::vector<std::string>& arguments, const std::string& input = "") {
        Program& program = start(arguments, {.input = input});
        long peak = 0;
        eventually(
            [&] {
                const bool enough = read_by(program) > kEnoughBytes;
                try {
                    peak = std::max(peak, program.memory_kib("VmHWM"));
                } catch (const std::runtime_error&) {
                    // It has ended.
                }
                return !program.runs() || enough;
            },
            std::chrono::seconds(4));
        program.signal(SIGKILL);
        return peak;
    }
    std::string many(const std::string& name, const std::string& text, int times) {
        std::ofstream file(folder() / name);
        for (int i = 0; i < times; ++i) {
            file << text;
        }
        return folder() / name;
    }
};

TEST_F(MemoryOfTools, IsBoundedForInputWithoutAnEnd) {
    for (const std::string input : {"/dev/zero", "/dev/urandom"}) {
        EXPECT_LT(peak_of({"decode"}, input), kMostKib) << input;
        EXPECT_LT(peak_of({"decode", "--protocol", "sbus"}, input), kMostKib) << input;
        EXPECT_LT(peak_of({"decode", "--input-format", "hex"}, input), kMostKib) << input;
    }
}

TEST_F(MemoryOfTools, IsBoundedForALineOfHex) {
    const std::string line = many("line.txt", "20 40 dc 05 dc 05 ", 3'000'000);
    EXPECT_LT(peak_of({"decode", line}), kMostKib);
    EXPECT_LT(peak_of({"decode", "--input-format", "timed", line}), kMostKib);
}

TEST_F(MemoryOfTools, IsBoundedForALongRecordingToLearnFrom) {
    // An i.Bus frame with 14 channels of 1500 us.
    std::string frame = "20 40 ";
    for (int channel = 0; channel < 14; ++channel) {
        frame += "dc 05 ";
    }
    const std::string frames = many("frames.txt", frame + "51 f3\n", 300'000);
    const std::string config = write_config(main_job());
    EXPECT_LT(peak_of({"learn", config + ":receiver", "--recording", frames, "--off-at", "5s",
                       "--back-at", "9s"}),
              kMostKib);
}

}  // namespace
}  // namespace tribus::test::memory_of_tools_test
