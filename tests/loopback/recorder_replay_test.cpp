#include <algorithm>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/loopback/recorded.h"

/// The commands `record` and `replay`.
namespace tribus::test::recorder_replay_test {
namespace {

namespace fs = std::filesystem;

/// `record` writes what `replay` sends, with the same gaps.
TEST_F(Recorded, AReplayIsRecordedAsItWas) {
    const fs::path sent = folder() / "sent.txt";
    {
        std::ofstream file(sent);
        file << "# t_us  bytes\n";
        for (int i = 0; i < 60; ++i) {
            file << 1'000'000 + 14'000 * i << " 20 40 dc 05 " << std::hex << 16 + i << std::dec
                 << "\n";
        }
    }
    const std::string link = folder() / "player";
    Program& replay = start({"replay", sent, "--to", "pty", "--link", link});
    ASSERT_TRUE(eventually([&] { return replay.output() == link + "\n"; })) << replay.errors();
    const fs::path got = folder() / "got.txt";
    Program& record = start({"record", link, "--out", got, "--protocol", "ibus"});
    EXPECT_EQ(replay.end(), 0) << replay.errors();
    record.end();
    const auto expected = timed_lines(sent);
    const auto lines = timed_lines(got);
    const auto all_bytes = [](const auto& bursts) {
        std::string bytes;
        for (const auto& burst : bursts) {
            bytes += burst.bytes + " ";
        }
        return bytes;
    };
    EXPECT_EQ(all_bytes(lines), all_bytes(expected)) << replay.errors() << record.errors();
    // A stall of the machine joins two bursts, and a busy one has several. A `record` that waits
    // for more joins most.
    ASSERT_GE(lines.size(), expected.size() * 3 / 4) << replay.errors() << record.errors();
    std::vector<std::int64_t> gaps;
    for (std::size_t i = 0; i < lines.size(); ++i) {
        gaps.push_back(i == 0 ? 14'000 : lines[i].at_us - lines[i - 1].at_us);
    }
    std::sort(gaps.begin(), gaps.end());
    EXPECT_NEAR(static_cast<double>(gaps[gaps.size() / 2]), 14'000, 1'000);
    EXPECT_FALSE(fs::exists(fs::symlink_status(link)));
}

/// A replay of it still runs when the test ends it.
constexpr std::string_view kForAMinute = "# t_us  bytes\n0 20 40 dc 05\n60000000 20 40 dc 05\n";

/// A mistyped name must not destroy somebody else's link.
TEST_F(Recorded, AReplayLeavesAloneWhatItDidNotMake) {
    const fs::path sent = folder() / "sent.txt";
    std::ofstream(sent) << kForAMinute;
    const fs::path link = folder() / "mine";
    fs::create_symlink("/elsewhere", link);
    Program& refused = start({"replay", sent, "--to", "pty", "--link", link});
    EXPECT_EQ(refused.end(), 1);
    EXPECT_NE(refused.errors().find("exists; remove it"), std::string::npos) << refused.errors();
    EXPECT_EQ(fs::read_symlink(link), "/elsewhere");
    fs::remove(link);
    Program& replay = start({"replay", sent, "--to", "pty", "--link", link});
    ASSERT_TRUE(eventually([&] { return fs::is_symlink(fs::symlink_status(link)); }));
    ASSERT_TRUE(eventually([&] { return !replay.output().empty(); }));
    // The same target under the same name, but made by somebody else.
    const fs::path target = fs::read_symlink(link);
    const fs::path other = folder() / "other";
    fs::create_symlink(target, other);
    fs::rename(other, link);
    replay.signal(SIGTERM);
    replay.end();
    EXPECT_EQ(fs::read_symlink(link), target);
}

/// A new file may get the inode of the removed link.
TEST_F(Recorded, AReplayLeavesAloneAFileThatTookThePlaceOfItsLink) {
    const fs::path sent = folder() / "sent.txt";
    std::ofstream(sent) << kForAMinute;
    const fs::path link = folder() / "mine";
    Program& replay = start({"replay", sent, "--to", "pty", "--link", link});
    ASSERT_TRUE(eventually([&] { return !replay.output().empty(); }));
    fs::remove(link);
    std::ofstream(link) << "precious";
    replay.signal(SIGTERM);
    replay.end();
    EXPECT_EQ(content(link), "precious");
}

TEST_F(Recorded, AFileThatIsThereIsNotOverwritten) {
    const std::string file = folder() / "precious.txt";
    std::ofstream(file) << "precious";
    Program& record = start({"record", device("port").path(), "--out", file, "--protocol", "ibus"});
    EXPECT_EQ(record.end(), 1);
    EXPECT_NE(record.errors().find("exists; --force overwrites it"), std::string::npos)
        << record.errors();
    EXPECT_EQ(content(file), "precious");
}

TEST_F(Recorded, ASerialDeviceNeedsItsProtocol) {
    Program& record =
        start({"record", device("port").path(), "--out", (folder() / "out.txt").string()});
    EXPECT_EQ(record.end(), 2);
    EXPECT_NE(record.errors().find("a serial device needs --protocol"), std::string::npos)
        << record.errors();
}

TEST_F(Recorded, ARecordingWithoutTimesNeedsAPeriod) {
    const std::string file = folder() / "untimed.txt";
    std::ofstream(file) << "20 40 dc 05\n20 40 dc 06\n";
    Program& replay = start({"replay", file, "--to", "pty"});
    EXPECT_EQ(replay.end(), 2);
    EXPECT_NE(replay.errors().find("--period 7ms"), std::string::npos) << replay.errors();
}

}  // namespace
}  // namespace tribus::test::recorder_replay_test
