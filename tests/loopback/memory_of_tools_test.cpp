#include <csignal>
#include <fstream>
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

/// They compute for seconds, and on a busy machine for minutes.
constexpr std::chrono::seconds kLong{250};

class MemoryOfTools : public Loopback {
  protected:
    void SetUp() override {
        if (kSanitized) {
            GTEST_SKIP() << "the sanitizer takes memory of its own";
        }
    }
    /// It reads enough, or refuses with that text; its memory is bounded meanwhile.
    void expect_bounded(const std::vector<std::string>& arguments, const std::string& refusal,
                        const std::string& input = "") {
        Program& program = start(arguments, {.input = input});
        bool enough = false;
        ASSERT_TRUE(eventually(
            [&] {
                enough = enough || read_by(program) > kEnoughBytes;
                return !program.runs() || enough;
            },
            kLong))
            << "neither ended nor read enough: " << read_by(program);
        if (enough) {
            program.signal(SIGKILL);
            program.end();
        } else {
            EXPECT_EQ(program.end(), 1);
            ASSERT_FALSE(refusal.empty()) << "it must read on: " << program.errors();
            EXPECT_NE(program.errors().find(refusal), std::string::npos) << program.errors();
        }
        EXPECT_GT(program.peak_kib(), 0);
        EXPECT_LT(program.peak_kib(), kMostKib);
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
        SCOPED_TRACE(input);
        const std::string no_end = "standard input: more than 8 MiB, and no end";
        expect_bounded({"decode"}, no_end, input);
        expect_bounded({"decode", "--input-format", "hex"}, no_end, input);
        expect_bounded({"decode", "--protocol", "sbus"}, "", input);
    }
}

TEST_F(MemoryOfTools, IsBoundedForALineOfHex) {
    const std::string line = many("line.txt", "20 40 dc 05 dc 05 ", 3'000'000);
    const std::string too_long = "line.txt:1:1: a line of more than 1048576 characters";
    expect_bounded({"decode", line}, too_long);
    expect_bounded({"decode", "--input-format", "timed", line}, too_long);
}

TEST_F(MemoryOfTools, IsBoundedForALongRecordingToLearnFrom) {
    // An i.Bus frame with 14 channels of 1500 us.
    std::string frame = "20 40 ";
    for (int channel = 0; channel < 14; ++channel) {
        frame += "dc 05 ";
    }
    const std::string frames = many("frames.txt", frame + "51 f3\n", 300'000);
    const std::string config = write_config(main_job());
    expect_bounded(
        {"learn", config + ":receiver", "--recording", frames, "--off-at", "5s", "--back-at", "9s"},
        "frames.txt: more than 100000 frames");
}

}  // namespace
}  // namespace tribus::test::memory_of_tools_test
