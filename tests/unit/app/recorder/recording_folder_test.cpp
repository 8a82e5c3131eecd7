#include "app/recorder/recording_folder.h"

#include <sys/resource.h>

#include <array>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "app/recorder/recording_plan.h"
#include "tests/support/temporary_folder.h"
#include "transports/recordings/recording.h"

namespace tribus::test::recording_folder_test {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

/// 2026-11-22 12:00:05 UTC
constexpr Duration kEvent = 1'795'348'805s;

class RecordingFolder : public testing::Test {
  protected:
    RecordingFolder() {
        for (std::uint8_t i = 0; i < 10; ++i) {
            ring_.record(std::vector<std::uint8_t>(25, i), Instant(1ms * i));
        }
    }
    RecordingOrder order() const {
        RecordingOrder order;
        order.directory = folder_.path() / "recordings";
        order.kind = "failsafe";
        order.reason = "failsafe of output servos";
        order.zero_wall = kEvent - 1s;
        order.event_wall = kEvent;
        order.ports.push_back({.ring = &ring_,
                               .can = false,
                               .device = "/dev/ttyAMA3",
                               .byte_time = 120us,
                               .read_file = "",
                               .written_file = "output-servos.txt",
                               .ring_file = ""});
        order.files.push_back({"config.toml", "# the configuration\n"});
        order.replay = "tribus simulate config.toml --out servos=simulated-servos.txt";
        order.keep = 20;
        order.space = 1'000'000;
        return order;
    }
    std::vector<std::string> found() const {
        std::vector<std::string> names;
        for (const auto& entry : fs::directory_iterator(folder_.path() / "recordings")) {
            names.push_back(entry.path().filename());
        }
        std::sort(names.begin(), names.end());
        return names;
    }
    static std::string content(const fs::path& path) {
        std::ifstream file(path);
        return {std::istreambuf_iterator<char>(file), {}};
    }

    struct alignas(64) Line {
        std::array<std::byte, 64> bytes{};
    };
    TemporaryFolder folder_;
    std::vector<Line> memory_ = std::vector<Line>(65);
    CaptureRing ring_ = CaptureRing::create(std::as_writable_bytes(std::span(memory_)));
};

TEST_F(RecordingFolder, IsNamedByTimeAndKind) {
    const auto written = write_recording(order());
    ASSERT_TRUE(written) << written.error();
    EXPECT_EQ(written->filename(), "2026-11-22T12-00-05Z-failsafe");
}

TEST_F(RecordingFolder, HasWhatPassedAndTheConfiguration) {
    const auto written = write_recording(order());
    ASSERT_TRUE(written) << written.error();
    const auto recording =
        parse_recording(content(*written / "output-servos.txt"), "output-servos.txt");
    ASSERT_TRUE(recording) << recording.error();
    EXPECT_EQ(recording->bursts.size(), 10U);
    EXPECT_EQ(content(*written / "config.toml"), "# the configuration\n");
    const std::string told = content(*written / "README.txt");
    EXPECT_NE(told.find("failsafe of output servos, 2026-11-22 12:00:05 UTC"), std::string::npos)
        << told;
    EXPECT_NE(told.find("  tribus simulate config.toml"), std::string::npos) << told;
}

TEST_F(RecordingFolder, GivesANumberToARecordingOfTheSameSecond) {
    ASSERT_TRUE(write_recording(order()));
    const auto second = write_recording(order());
    ASSERT_TRUE(second) << second.error();
    EXPECT_EQ(second->filename(), "2026-11-22T12-00-05Z-failsafe-2");
}

TEST_F(RecordingFolder, BeyondTheNumberToKeepIsRemovedTheOldestFirst) {
    RecordingOrder next = order();
    next.keep = 2;
    for (int i = 0; i < 4; ++i) {
        next.event_wall = kEvent + 1s * i;
        ASSERT_TRUE(write_recording(next));
    }
    EXPECT_EQ(found(), (std::vector<std::string>{"2026-11-22T12-00-07Z-failsafe",
                                                 "2026-11-22T12-00-08Z-failsafe"}));
}

TEST_F(RecordingFolder, RemovesRecordingsOfOneSecondInTheirOrderToo) {
    RecordingOrder next = order();
    next.keep = 2;
    for (int i = 0; i < 12; ++i) {
        ASSERT_TRUE(write_recording(next));
    }
    EXPECT_EQ(found(), (std::vector<std::string>{"2026-11-22T12-00-05Z-failsafe-11",
                                                 "2026-11-22T12-00-05Z-failsafe-12"}));
}

TEST_F(RecordingFolder, BeyondTheSpaceIsRemovedButNeverTheNewest) {
    RecordingOrder next = order();
    next.space = 1;
    for (int i = 0; i < 3; ++i) {
        next.event_wall = kEvent + 1s * i;
        ASSERT_TRUE(write_recording(next));
    }
    EXPECT_EQ(found(), std::vector<std::string>{"2026-11-22T12-00-07Z-failsafe"});
}

TEST_F(RecordingFolder, LeavesOtherFilesAlone) {
    const fs::path other = folder_.path() / "recordings" / "notes.unfinished";
    fs::create_directories(other);
    RecordingOrder next = order();
    next.keep = 1;
    ASSERT_TRUE(write_recording(next));
    remove_unfinished_recordings(next.directory);
    EXPECT_TRUE(fs::exists(other));
}

TEST_F(RecordingFolder, ThatWasNotFinishedIsClearedAway) {
    const fs::path unfinished =
        folder_.path() / "recordings" / "2026-11-22T12-00-05Z-failsafe.unfinished";
    fs::create_directories(unfinished);
    remove_unfinished_recordings(folder_.path() / "recordings");
    EXPECT_FALSE(fs::exists(unfinished));
}

/// A limit of file sizes takes the place of a full disk.
TEST_F(RecordingFolder, LeavesNothingWhereTheDiskIsFull) {
    rlimit before{};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
    const rlimit small{.rlim_cur = 100, .rlim_max = before.rlim_max};
    auto* handler = std::signal(SIGXFSZ, SIG_IGN);
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    const auto written = write_recording(order());
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
    std::signal(SIGXFSZ, handler);
    ASSERT_FALSE(written);
    EXPECT_NE(written.error().find("output-servos.txt: File too large"), std::string::npos)
        << written.error();
    EXPECT_TRUE(found().empty());
}

TEST_F(RecordingFolder, NamesWhatIsNotRecorded) {
    RecordingOrder partly = order();
    partly.lacks = {"/dev/ttyAMA4: cannot get memory: Cannot allocate memory"};
    const auto written = write_recording(partly);
    ASSERT_TRUE(written) << written.error();
    const std::string told = content(*written / "README.txt");
    EXPECT_NE(
        told.find("  not recorded: /dev/ttyAMA4: cannot get memory: Cannot allocate memory\n"),
        std::string::npos)
        << told;
}

TEST_F(RecordingFolder, SaysHowMuchOfItWasDamaged) {
    // The byte count of the third piece.
    memory_[3].bytes[21] = std::byte{200};
    const auto written = write_recording(order());
    ASSERT_TRUE(written) << written.error();
    const std::string told = content(*written / "README.txt");
    EXPECT_NE(told.find("  damaged pieces of /dev/ttyAMA3, left out: 1\n"), std::string::npos)
        << told;
}

TEST_F(RecordingFolder, DoesNotCountATimeThatIsYetToComeAsTheLatest) {
    ASSERT_TRUE(write_recording(order()));
    EXPECT_FALSE(age_of_latest(folder_.path() / "recordings", "failsafe", Duration(1h)));
}

TEST_F(RecordingFolder, ThatCannotBeMadeSaysWhere) {
    RecordingOrder impossible = order();
    impossible.directory = "/proc/nothing";
    const auto written = write_recording(impossible);
    ASSERT_FALSE(written);
    EXPECT_EQ(written.error().find("/proc/nothing: "), 0U) << written.error();
}

TEST(RecordingPlan, IsTheSameForTheProcessThatComesAfter) {
    RecordingPlan plan;
    plan.begin = Instant(3s);
    plan.replay = "tribus simulate config.toml";
    plan.ports.push_back({.ring = nullptr,
                          .can = true,
                          .device = "can0",
                          .byte_time = 0ns,
                          .read_file = "can0-in.log",
                          .written_file = "can0-out.log",
                          .ring_file = "0.ring"});
    plan.lacks = {"/dev/ttyAMA3: no memory for it"};
    plan.files.push_back({"config.toml", "a = \"\\u00e4\"\n"});
    const auto after = plan_from_text(plan_to_text(plan));
    ASSERT_TRUE(after);
    EXPECT_EQ(after->begin, plan.begin);
    EXPECT_EQ(after->replay, plan.replay);
    EXPECT_EQ(after->ports.at(0).read_file, "can0-in.log");
    EXPECT_TRUE(after->ports.at(0).can);
    EXPECT_EQ(after->ports.at(0).ring_file, "0.ring");
    EXPECT_EQ(after->lacks, plan.lacks);
    EXPECT_EQ(after->files.at(0).content, plan.files[0].content);
}

TEST(RecordingPlan, ThatIsDamagedIsNone) {
    EXPECT_FALSE(plan_from_text("{\"begin_ns\": 1"));
    EXPECT_FALSE(plan_from_text("{\"begin_ns\": \"soon\"}"));
}

}  // namespace
}  // namespace tribus::test::recording_folder_test
