#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gtest/gtest.h>

#include "tests/lab/can_bus.h"
#include "tests/lab/candump.h"
#include "tests/lab/shell.h"
#include "tests/loopback/loopback.h"
#include "transports/recordings/recording.h"

/// `record` and `replay` on a CAN bus.
namespace tribus::test::can_recorder_test {
namespace {

constexpr const char* kLog =
    "(0000000001.000000) can7 123#11223344\n"
    "(0000000001.000300) can7 12345678#0102030405060708\n"
    "(0000000001.050000) can7 300#R4\n"
    "(0000000001.100000) can7 124#\n";

class CanRecording : public Loopback {
  protected:
    static Recording read(const std::filesystem::path& path) {
        std::ifstream file(path);
        const std::string text(std::istreambuf_iterator<char>(file), {});
        const auto recording = parse_recording(text, path.string());
        EXPECT_TRUE(recording) << recording.error();
        return recording.value_or(Recording{});
    }
    static void expect_same_frames(const Recording& a, const Recording& b) {
        ASSERT_EQ(a.can_frames.size(), b.can_frames.size());
        for (std::size_t i = 0; i < a.can_frames.size(); ++i) {
            EXPECT_EQ(a.can_frames[i].frame, b.can_frames[i].frame) << i;
        }
    }

    VirtualBus bus_;
};

TEST_F(CanRecording, AReplayIsOnTheBusAndRecordedAsItWas) {
    const auto sent = folder() / "sent.log";
    std::ofstream(sent) << kLog;
    const auto got = folder() / "got.log";
    Candump candump(folder(), bus_.name());
    Program& record = start({"record", bus_.name(), "--out", got});
    ASSERT_TRUE(record.says("recording")) << record.errors();
    Program& replay = start({"replay", sent, "--to", bus_.name()});
    EXPECT_EQ(replay.end(), 0) << replay.errors();
    EXPECT_TRUE(eventually([&] { return read(got).can_frames.size() == 4; })) << record.errors();
    record.signal(SIGINT);
    EXPECT_EQ(record.end(), 0) << record.errors();
    expect_same_frames(read(got), read(sent));
    const auto heard = parse_recording(candump.log(), "candump");
    ASSERT_TRUE(heard) << heard.error();
    expect_same_frames(*heard, read(sent));
    EXPECT_GE(heard->can_frames.back().at, std::chrono::milliseconds(90));
}

TEST_F(CanRecording, ALogIsNotSentIntoASerialPort) {
    const auto sent = folder() / "sent.log";
    std::ofstream(sent) << kLog;
    Program& replay = start({"replay", sent, "--to", "pty"});
    EXPECT_EQ(replay.end(), 2);
    EXPECT_NE(replay.errors().find("pty is not a CAN interface"), std::string::npos)
        << replay.errors();
}

TEST_F(CanRecording, AnInterfaceThatIsNotThereIsNamed) {
    Program& record = start({"record", "nocan7", "--out", (folder() / "out.log").string()});
    EXPECT_EQ(record.end(), 1);
    EXPECT_NE(record.errors().find("nocan7: "), std::string::npos) << record.errors();
}

/// A daemon with CAN, and a separate disk for its recordings.
class CanRecorder : public CanRecording {
  protected:
    CanRecorder() { std::filesystem::create_directory(folder() / "recordings"); }
    ~CanRecorder() override { run_shell("umount " + recordings()); }

    std::string recordings() const { return folder() / "recordings"; }
    Program& run_recorder() {
        const std::string bus = "interface = \"" + bus_.name() + "\"\n";
        return run(
            write_config("[input.receiver]\nprotocol = \"ibus\"\ndevice = \"@receiver\"\n"
                         "[output.bus]\nprotocol = \"can\"\n" +
                         bus +
                         "[pipeline.main]\nfrom = \"receiver\"\nto = \"bus\"\n"
                         "[recorder]\ndirectory = \"@recordings\"\n"));
    }
    Program& request() { return start({"record", "--socket", (folder() / "control").string()}); }

    FarEnd& receiver_ = device("receiver");
};

TEST_F(CanRecorder, OnAFullDiskLeavesNothingAndWritesOnceThereIsRoom) {
    require_guest();
    shell("mount -t tmpfs -o size=256k tmpfs " + recordings());
    run_shell("head -c 262144 /dev/zero > " + recordings() + "/full");
    Program& program = run_recorder();
    Program& refused = request();
    EXPECT_EQ(refused.end(), 1);
    EXPECT_NE(refused.errors().find("No space left on device"), std::string::npos)
        << refused.errors();
    EXPECT_EQ(shell("ls " + recordings()), "full\n");
    shell("rm " + recordings() + "/full");
    Program& written = request();
    EXPECT_EQ(written.end(), 0) << written.errors();
    expect_clean_end(program);
}

TEST_F(CanRecorder, OnAReadOnlyDiskGoesOnWithout) {
    require_guest();
    shell("mount -t tmpfs -o ro tmpfs " + recordings());
    Program& program = run_recorder();
    Program& refused = request();
    EXPECT_EQ(refused.end(), 1);
    EXPECT_NE(refused.errors().find("Read-only file system"), std::string::npos)
        << refused.errors();
    EXPECT_EQ(count_of("recorder: cannot write the recording", program.errors()), 1U);
    expect_clean_end(program);
}

/// The recording has what the daemon received and what it sent, in one time scale.
TEST_F(CanRecorder, HasBothDirectionsOfItsInterface) {
    Program& program = run_recorder();
    Repeater repeater(receiver_, ibus_bytes(sticks_with_first(1234)));
    for (int i = 0; i < 100; ++i) {
        repeater.send_if_due();
        const timespec pause{.tv_sec = 0, .tv_nsec = 7'000'000};
        ::nanosleep(&pause, nullptr);
    }
    Program& asking = request();
    EXPECT_EQ(asking.end(), 0) << asking.errors();
    std::string path = asking.output();
    path.pop_back();
    EXPECT_GT(read(path + "/" + bus_.name() + "-out.log").can_frames.size(), 10U);
    EXPECT_TRUE(std::filesystem::exists(path + "/input-receiver.txt"));
    expect_clean_end(program);
}

}  // namespace
}  // namespace tribus::test::can_recorder_test
