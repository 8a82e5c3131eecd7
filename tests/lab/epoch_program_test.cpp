#include <algorithm>
#include <csignal>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "tests/lab/link_jobs.h"

/// Boxes on a bus whose readers do not answer, and the disk on which they keep their numbers.
namespace tribus::test::epoch_program_test {
namespace {

/// A bus with a sender, a reader and a second reader on another port.
class BroadcastLink : public TwoPrograms, public testing::WithParamInterface<BusJob> {
  protected:
    BroadcastLink() { write_key("boat.key", '7'); }

    VirtualBus bus_;
};

INSTANTIATE_TEST_SUITE_P(Links, BroadcastLink,
                         testing::Values(with_epoch(kFdBus), with_epoch(kClassicBus)));

TEST_P(BroadcastLink, OneSenderMovesTheServosOfTwoReaders) {
    BusJob second_job = GetParam();
    second_job.reader_lines = "epoch = \"@second.epoch\"";
    FarEnd& second_wire = device("servos2");
    ServoBank second_servos(second_wire);
    Program& reader = start_reader(GetParam());
    std::string second_text = reader_text(second_job);
    second_text.replace(second_text.find("@servos"), 7, "@servos2");
    Program& second = run(write_config(second_text, "second.toml"));
    Program& sender = start_sender(GetParam());
    ASSERT_TRUE(carry_until_control()) << sender.errors() << reader.errors();
    EXPECT_TRUE(carry_until([&](const SbusSight& /*sight*/) {
        const auto sights = second_servos.listen();
        return std::ranges::any_of(sights, [](const SbusSight& sight) {
            return sight.good() && sight.raw[0] == sbus_raw(1234);
        });
    })) << second.errors();
    expect_clean_end(sender);
    expect_clean_end(second);
    expect_clean_end(reader);
}

/// A disk of its own for the numbers of both ends.
class EpochDisk : public TwoPrograms {
  protected:
    EpochDisk() {
        write_key("boat.key", '7');
        std::filesystem::create_directory(disk());
        mount("-o size=16k tmpfs");
    }
    ~EpochDisk() override { run_shell("umount " + disk()); }

    std::string disk() const { return (folder() / "disk").string(); }
    void mount(const std::string& options) const {
        shell("mount -t tmpfs " + options + " " + disk());
    }
    void fill() const { run_shell("cat /dev/zero > " + disk() + "/filled 2>/dev/null"); }
    void empty() const { shell("rm " + disk() + "/filled"); }
    BusJob job() const { return with_epoch(kFdBus, disk() + "/"); }

    VirtualBus bus_;
};

TEST_F(EpochDisk, ReadOnlyOrFullIsRefusedAtTheStart) {
    const std::string config = write_config(sender_text(job()), "sender.toml");
    const auto refused = [&](const std::string& why) {
        Program& program = start({"run", config});
        EXPECT_EQ(program.end(), 1);
        EXPECT_NE(program.errors().find("[output.bus] epoch: cannot write " + disk()),
                  std::string::npos)
            << program.errors();
        EXPECT_NE(program.errors().find(why), std::string::npos) << program.errors();
    };
    shell("mount -o remount,ro " + disk());
    refused("Read-only file system");
    shell("mount -o remount,rw " + disk());
    fill();
    refused("No space left on device");
    empty();
    Program& sender = start_sender(job());
    EXPECT_TRUE(sender.says("is in memory: after a start of this machine")) << sender.errors();
    expect_clean_end(sender);
}

/// The reader needs new numbers each ten seconds.
TEST_F(EpochDisk, ThatFillsUpIsToldAndEndsTheLinkAndIsUsedAgainWhenThereIsRoom) {
    Program& reader = start_reader(job());
    Program& sender = start_sender(job());
    ASSERT_TRUE(carry_until_control()) << sender.errors() << reader.errors();
    fill();
    bool failsafe = false;
    for (int i = 0; i < 4 && !failsafe; ++i) {
        failsafe = carry_until_failsafe();
    }
    EXPECT_TRUE(failsafe) << reader.errors();
    EXPECT_TRUE(reader.says("reader.epoch: No space left on device")) << reader.errors();
    empty();
    EXPECT_TRUE(carry_until_control()) << reader.errors();
    EXPECT_TRUE(reader.says("is written again")) << reader.errors();
    expect_clean_end(sender);
    expect_clean_end(reader);
}

/// A reader that is killed does not know what it took, and may be deaf for 20 s.
TEST_F(EpochDisk, ReaderThatWasKilledComesBackWithoutAHand) {
    Program& sender = start_sender(job());
    Program* reader = &start_reader(job());
    ASSERT_TRUE(carry_until_control()) << sender.errors() << reader->errors();
    reader->signal(SIGKILL);
    reader->end();
    reader = &start_reader(job());
    bool controlled = false;
    for (int i = 0; i < 3 && !controlled; ++i) {
        controlled = carry_until_control();
    }
    EXPECT_TRUE(controlled) << sender.errors() << reader->errors();
    expect_clean_end(sender);
    expect_clean_end(*reader);
}

}  // namespace
}  // namespace tribus::test::epoch_program_test
