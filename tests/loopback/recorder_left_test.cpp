#include <sys/stat.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "tests/loopback/recorded.h"

/// A daemon that crashed or was killed leaves rings and a plan for its next recorder.
namespace tribus::test::recorder_left_test {
namespace {

namespace fs = std::filesystem;

TEST_F(Recorded, WhatAKilledProcessKnewIsWrittenByTheNext) {
    const std::string config = config_with("");
    Program& killed = run_service(config);
    ASSERT_TRUE(drive({1234}));
    killed.signal(SIGKILL);
    killed.end();
    EXPECT_TRUE(found().empty());
    Program& next = run_service(config);
    EXPECT_TRUE(next.says("recorder: wrote")) << next.errors();
    ASSERT_EQ(found().size(), 1U);
    EXPECT_TRUE(found().front().string().ends_with("Z-crash")) << found().front();
    EXPECT_FALSE(timed_lines(found().front() / "input-receiver.txt").empty());
    EXPECT_FALSE(timed_lines(found().front() / "output-servos.txt").empty());
    EXPECT_NE(content(found().front() / "config.toml").find("[input.receiver]"), std::string::npos);
    expect_clean_end(next);
    EXPECT_FALSE(fs::exists(runtime_.path() / "recorder"));
    EXPECT_FALSE(fs::exists(runtime_.path() / "recorder-left"));
}

/// The byte count of each piece in the first port's ring exceeds a piece: it is byte 21 of 64.
TEST_F(Recorded, ADamagedRingStopsNoStart) {
    const std::string config = config_with("");
    Program& killed = run_service(config);
    ASSERT_TRUE(drive({1234}));
    killed.signal(SIGKILL);
    killed.end();
    const fs::path ring = runtime_.path() / "recorder" / "0.ring";
    {
        std::fstream file(ring, std::ios::in | std::ios::out | std::ios::binary);
        for (std::size_t piece = 0; 64 * (piece + 2) <= fs::file_size(ring); ++piece) {
            file.seekp(static_cast<std::streamoff>(64 * (piece + 1) + 21));
            file.put('\xFF');
        }
    }
    Program& next = run_service(config);
    EXPECT_TRUE(next.says("recorder: ")) << next.errors();
    EXPECT_TRUE(drive({1345})) << next.errors();
    expect_clean_end(next);
    EXPECT_FALSE(fs::exists(runtime_.path() / "recorder-left"));
}

/// The plan of a former run is read beside the outputs: the log tells of the start before it tells
/// what came of the plan.
TEST_F(Recorded, AHugePlanThatWasLeftDelaysNoFrame) {
    for (const std::size_t megabytes : {15U, 50U}) {
        fs::create_directory(runtime_.path() / "recorder");
        std::ofstream(runtime_.path() / "recorder" / "plan.json")
            << "{\"lacks\":[" << std::string(megabytes * 500'000, '[') << "\n"
            << std::string(megabytes * 500'000, '1');
        Program& program = run_service(config_with(""));
        EXPECT_TRUE(drive({1234})) << program.errors();
        EXPECT_TRUE(program.says("nothing of it is written")) << program.errors();
        const std::string log = program.errors();
        EXPECT_LT(log.find("info started"), log.find("nothing of it is written")) << log;
        expect_clean_end(program);
    }
}

/// The program would wait for a FIFO in place of the plan. A FIFO in the recorder's folder is worse
/// than any other file.
TEST_F(Recorded, AFifoThatWasLeftStopsNoStart) {
    fs::create_directory(runtime_.path() / "recorder");
    ASSERT_EQ(::mkfifo((runtime_.path() / "recorder" / "plan.json").c_str(), 0600), 0);
    Program& first = run_service(config_with(""));
    EXPECT_TRUE(drive({1234})) << first.errors();
    EXPECT_TRUE(first.says("nothing of it is written")) << first.errors();
    expect_clean_end(first);
    ASSERT_EQ(::mkfifo((runtime_.path() / "recorder").c_str(), 0600), 0);
    Program& second = run_service(config_with(""));
    EXPECT_TRUE(drive({1234})) << second.errors();
    expect_clean_end(second);
}

/// A process that ended while it read a file may have crashed because of the file.
TEST_F(Recorded, WhatAProcessHadBegunToReadIsNotReadAgain) {
    const std::string config = config_with("");
    Program& killed = run_service(config);
    ASSERT_TRUE(drive({1234}));
    killed.signal(SIGKILL);
    killed.end();
    fs::rename(runtime_.path() / "recorder", runtime_.path() / "recorder-taken");
    Program& next = run_service(config);
    EXPECT_TRUE(next.says("that recording is lost")) << next.errors();
    expect_clean_end(next);
    EXPECT_TRUE(found().empty());
    EXPECT_FALSE(fs::exists(runtime_.path() / "recorder-taken"));
}

}  // namespace
}  // namespace tribus::test::recorder_left_test
