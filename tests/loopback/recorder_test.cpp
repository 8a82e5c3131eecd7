#include <sys/stat.h>

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/loopback/loopback.h"
#include "tests/support/shell.h"

namespace tribus::test::recorder_test {
namespace {

namespace fs = std::filesystem;

/// A folder in memory, like the runtime directory of a service.
class RuntimeFolder {
  public:
    RuntimeFolder() {
        std::string name = "/dev/shm/tribus-XXXXXX";
        path_ = ::mkdtemp(name.data());
    }
    RuntimeFolder(const RuntimeFolder&) = delete;
    RuntimeFolder& operator=(const RuntimeFolder&) = delete;
    ~RuntimeFolder() { fs::remove_all(path_); }
    const fs::path& path() const { return path_; }

  private:
    fs::path path_;
};

std::string content(const fs::path& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
}

struct TimedLine {
    std::int64_t at_us = 0;
    std::string bytes;
};

std::vector<TimedLine> timed_lines(const fs::path& path) {
    std::istringstream lines(content(path));
    std::vector<TimedLine> found;
    for (std::string line; std::getline(lines, line);) {
        const std::size_t space = line.find(' ');
        if (line.starts_with('#') || space == std::string::npos) {
            continue;
        }
        found.push_back({std::stoll(line), line.substr(space + 1)});
    }
    return found;
}

/// Returns the lines in order, without a line that equals the one before.
std::vector<std::string> changes_in(const std::vector<TimedLine>& lines) {
    std::vector<std::string> changes;
    for (const TimedLine& line : lines) {
        if (changes.empty() || changes.back() != line.bytes) {
            changes.push_back(line.bytes);
        }
    }
    return changes;
}

class Recorded : public Loopback {
  protected:
    fs::path recordings() const { return folder() / "recordings"; }
    std::string config_with(const std::string& recorder, std::string_view input = kPatientInput) {
        return write_config(main_job(input, "", "[pipeline.main.failsafe]\nrecover = \"0s\"\n") +
                            "[recorder]\ndirectory = \"@recordings\"\n" + recorder);
    }
    Program& run_service(const std::string& config, std::size_t most_file_bytes = 0) {
        Program& program = start({"run", config}, {.most_file_bytes = most_file_bytes,
                                                   .runtime_directory = runtime_.path()});
        EXPECT_TRUE(program.says("started")) << program.errors();
        return program;
    }
    Program& request() {
        return start({"record", "--socket", (runtime_.path() / "control").string()});
    }
    std::vector<fs::path> found() const {
        std::vector<fs::path> folders;
        if (fs::exists(recordings())) {
            for (const auto& entry : fs::directory_iterator(recordings())) {
                folders.push_back(entry.path());
            }
        }
        std::sort(folders.begin(), folders.end());
        return folders;
    }
    /// Sends each value until the servos have it, and then for several of their periods: two values
    /// within one period would leave it to chance which one they get.
    bool drive(const std::vector<int>& firsts) {
        constexpr auto kLeast = std::chrono::milliseconds(40);
        return std::ranges::all_of(firsts, [&](int first) {
            Repeater repeater(receiver_, ibus_bytes(sticks_with_first(first)));
            const auto begin = Clock::now();
            bool seen = false;
            return eventually([&] {
                repeater.send_if_due();
                seen =
                    std::ranges::any_of(servos_.listen(),
                                        [&](const SbusSight& sight) {
                                            return sight.good() && sight.raw[0] == sbus_raw(first);
                                        }) ||
                    seen;
                return seen && Clock::now() - begin > kLeast;
            });
        });
    }

    RuntimeFolder runtime_;
    FarEnd& receiver_ = device("receiver");
    ServoBank servos_{device("servos")};
};

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

/// What a former run left is read beside the outputs: the log tells of the start before it tells
/// what came of that.
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
}  // namespace tribus::test::recorder_test
