#include <csignal>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/loopback/recorded.h"
#include "tests/support/shell.h"

/// Recordings of `tribus run` with [recorder].
namespace tribus::test::recorder_test {
namespace {

namespace fs = std::filesystem;

/// Returns the lines in order, without a line that equals the one before.
std::vector<std::string> changes_in(const std::vector<RecordingLine>& lines) {
    std::vector<std::string> changes;
    for (const RecordingLine& line : lines) {
        if (changes.empty() || changes.back() != line.bytes) {
            changes.push_back(line.bytes);
        }
    }
    return changes;
}

TEST_F(Recorded, AFailsafeIsWrittenAndASimulationOfItSaysTheSame) {
    Program& program = run_service(config_with("after = \"0s\"\n", "timeout = \"1s\""));
    ASSERT_TRUE(eventually([&] { return !servos_.listen().empty(); }));
    ASSERT_TRUE(drive({1100, 1200, 1300, 1400, 1500, 1600, 1700, 1800, 1900}));
    EXPECT_TRUE(program.says("recorder: wrote")) << program.errors();
    ASSERT_EQ(found().size(), 1U);
    const fs::path recording = found().front();
    EXPECT_TRUE(recording.string().ends_with("Z-failsafe")) << recording;
    const std::string told = content(recording / "README.txt");
    const std::size_t command = told.find("tribus simulate");
    ASSERT_NE(command, std::string::npos) << told;
    const Ended simulated = run_in_shell("cd " + recording.string() + " && \"$TRIBUS\"" +
                                         told.substr(command + std::string("tribus").size()));
    EXPECT_EQ(simulated.status, 0) << simulated.output;
    const auto real = changes_in(timed_lines(recording / "output-servos.txt"));
    const auto again = changes_in(timed_lines(recording / "simulated-servos.txt"));
    // Failsafe, nine values, the last one marked frame-lost, failsafe.
    EXPECT_GE(real.size(), 12U);
    ASSERT_LE(real.size(), again.size());
    EXPECT_EQ(real, std::vector<std::string>(
                        again.begin(), again.begin() + static_cast<std::ptrdiff_t>(real.size())));
    expect_clean_end(program);
}

TEST_F(Recorded, ARequestIsAnsweredByTheFolder) {
    Program& program = run_service(config_with(""));
    ASSERT_TRUE(drive({1234}));
    Program& asking = request();
    EXPECT_EQ(asking.end(), 0) << asking.errors();
    ASSERT_EQ(found().size(), 1U);
    EXPECT_EQ(asking.output(), found().front().string() + "\n");
    expect_clean_end(program);
}

TEST_F(Recorded, NoMoreRecordingsAreKeptThanWanted) {
    Program& program = run_service(config_with("keep = 2\n"));
    std::string latest;
    for (int i = 0; i < 4; ++i) {
        Program& asking = request();
        EXPECT_EQ(asking.end(), 0) << asking.errors();
        latest = asking.output();
    }
    ASSERT_EQ(found().size(), 2U);
    EXPECT_TRUE(fs::exists(latest.substr(0, latest.size() - 1))) << latest;
    expect_clean_end(program);
}

TEST_F(Recorded, APlaceThatCannotBeWrittenStopsNothing) {
    Program& program = run_service(
        write_config(main_job(kPatientInput) + "[recorder]\ndirectory = \"/proc/nothing\"\n"));
    Program& asking = request();
    EXPECT_EQ(asking.end(), 1);
    EXPECT_NE(asking.errors().find("nothing was recorded: /proc/nothing: "), std::string::npos)
        << asking.errors();
    EXPECT_EQ(count_of("recorder: cannot write the recording", program.errors()), 1U);
    EXPECT_TRUE(drive({1234}));
    expect_clean_end(program);
}

/// The kernel sends SIGXFSZ, which ends a process that does not expect it. The log and half a
/// second of the servos' frames are shorter and longer than this.
TEST_F(Recorded, ARecordingBeyondTheLimitOfFileSizesStopsNothing) {
    Program& program = run_service(config_with(""), 2048);
    ASSERT_TRUE(drive({1100, 1200, 1300, 1400, 1500, 1600, 1700, 1800, 1900}));
    Program& asking = request();
    EXPECT_EQ(asking.end(), 1);
    EXPECT_NE(asking.errors().find("nothing was recorded: "), std::string::npos);
    EXPECT_NE(asking.errors().find(": File too large"), std::string::npos) << asking.errors();
    EXPECT_TRUE(found().empty());
    EXPECT_TRUE(drive({1345}));
    expect_clean_end(program);
}

TEST_F(Recorded, WithoutAPlaceForRecordingsItDoesNotStart) {
    const std::string config = write_config(main_job() + "[recorder]\n");
    Program& program = start({"run", config});
    EXPECT_EQ(program.end(), 1);
    EXPECT_NE(program.errors().find("[recorder] has no directory for recordings"),
              std::string::npos)
        << program.errors();
}

TEST_F(Recorded, ADaemonWithoutARecorderSaysSo) {
    Program& program = run_service(write_config(main_job(kPatientInput)));
    Program& asking = request();
    EXPECT_EQ(asking.end(), 1);
    EXPECT_NE(asking.errors().find("has no [recorder]"), std::string::npos) << asking.errors();
    expect_clean_end(program);
}

TEST_F(Recorded, AReloadGoesOnRecording) {
    Program& program = run_service(config_with(""));
    ASSERT_TRUE(drive({1234}));
    config_with("keep = 7\n");
    program.signal(SIGHUP);
    EXPECT_TRUE(program.says("reloaded")) << program.errors();
    ASSERT_TRUE(drive({1345}));
    EXPECT_EQ(request().end(), 0);
    ASSERT_EQ(found().size(), 1U);
    // What came before the reload is there too.
    const auto lines = timed_lines(found().front() / "input-receiver.txt");
    ASSERT_FALSE(lines.empty());
    const auto bytes_of = [](int first) {
        std::ostringstream text;
        for (const std::uint8_t byte : ibus_bytes(sticks_with_first(first))) {
            text << (text.tellp() > 0 ? " " : "") << std::hex << (byte < 0x10 ? "0" : "")
                 << static_cast<unsigned>(byte);
        }
        return text.str();
    };
    // On a busy machine a read may bring two frames.
    EXPECT_TRUE(lines.front().bytes.starts_with(bytes_of(1234))) << lines.front().bytes;
    EXPECT_TRUE(lines.back().bytes.ends_with(bytes_of(1345))) << lines.back().bytes;
    expect_clean_end(program);
}

}  // namespace
}  // namespace tribus::test::recorder_test
