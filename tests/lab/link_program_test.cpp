#include <algorithm>
#include <csignal>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "tests/lab/link_jobs.h"
#include "tests/lab/recorded_receiver.h"

/// Two boxes with a link between them that only the holder of a key can use: over a CAN FD bus, and
/// over UDP with a network that loses, delays, reorders and doubles datagrams.
namespace tribus::test::link_program_test {
namespace {

using std::chrono::milliseconds;

/// A CAN FD bus without loss, or the loopback interface with a bad network in it.
class Way {
  public:
    explicit Way(const BusJob& job) {
        if (job.sender_interface.empty()) {
            shell("modprobe sch_netem; ip link set lo up");
            shell(
                "tc qdisc add dev lo root netem delay 40ms 10ms loss 20% duplicate 10% "
                "reorder 25% 50%");
        } else {
            bus_.emplace();
        }
    }
    Way(const Way&) = delete;
    Way& operator=(const Way&) = delete;
    ~Way() {
        if (!bus_) {
            run_shell("tc qdisc del dev lo root");
        }
    }

  private:
    std::optional<VirtualBus> bus_;
};

class KeyedLink : public TwoPrograms, public testing::WithParamInterface<BusJob> {
  protected:
    KeyedLink() { write_key("boat.key", '7'); }

    const BusJob& job_ = GetParam();
    Way way_{job_};
};

INSTANTIATE_TEST_SUITE_P(Links, KeyedLink,
                         testing::Values(with_key(kFdBus), with_key(kClassicBus), with_key(kUdp),
                                         with_epoch(kFdBus), with_epoch(kClassicBus),
                                         with_epoch(kUdp)));

TEST_P(KeyedLink, EverySticksOfTheCaptureComesOutExactly) {
    Program& reader = start_reader(job_);
    Program& sender = start_sender(job_);
    expect_recorded_sticks(sender, reader);
    expect_clean_end(sender);
    expect_clean_end(reader);
}

/// The capture at its own pace: 18 channels every 4 ms.
TEST_P(KeyedLink, RecordedReceiverMovesTheServosInItsOrderAndItsEndIsFailsafe) {
    const auto rows = recorded_sticks();
    ASSERT_FALSE(rows.empty()) << "the captures are not there";
    Program& reader = start_reader(job_);
    Program& sender = start_sender(job_);
    ASSERT_TRUE(carry_until_control()) << sender.errors() << reader.errors();
    RecordedReceiver recorded(receiver());
    recorded.start();
    std::size_t row = 0;
    std::size_t rows_seen = 0;
    const auto is_row = [&](const SbusSight& sight, std::size_t at) {
        return same_channels(sight, sbus_sight_of(rows[at]));
    };
    const SbusSight before = sbus_sight_of(sticks_with_first(1234));
    std::optional<SbusSight> failsafe;
    ASSERT_TRUE(eventually([&] {
        recorded.send_due();
        for (const SbusSight& sight : servos().listen()) {
            if (!sight.good()) {
                failsafe = sight.failsafe ? std::optional(sight) : failsafe;
                continue;
            }
            std::size_t next = row;
            while (next < rows.size() && !is_row(sight, next)) {
                ++next;
            }
            if (next == rows.size()) {
                EXPECT_TRUE(rows_seen == 0 && same_channels(sight, before)) << "invented sticks";
            } else {
                rows_seen += next > row ? 1 : 0;
                row = next;
            }
        }
        return recorded.ended() && failsafe;
    })) << sender.errors()
        << reader.errors();
    EXPECT_GT(rows_seen, 20U);
    // The sender's failsafe comes through, and the servos get the preset of their own box.
    EXPECT_TRUE(eventually([&] {
        for (const SbusSight& sight : servos().listen()) {
            failsafe = sight.failsafe ? sight : failsafe;
        }
        return failsafe->raw[0] == sbus_raw(1000) && failsafe->raw[1] == sbus_raw(1500) &&
               failsafe->raw[2] == sbus_raw(988);
    }));
    expect_clean_end(sender);
    expect_clean_end(reader);
}

TEST_P(KeyedLink, KilledSenderEndsInFailsafeAndComesBackWithoutAHand) {
    Program& reader = start_reader(job_);
    Program* sender = &start_sender(job_);
    expect_times(expect_failsafe_and_recovery(
        "sender with a key killed, started again",
        [&] {
            sender->signal(SIGKILL);
            sender->end();
        },
        [&] { sender = &start_sender(job_); }));
    expect_clean_end(*sender);
    expect_clean_end(reader);
}

class AnsweredLink : public KeyedLink {};

INSTANTIATE_TEST_SUITE_P(Links, AnsweredLink,
                         testing::Values(with_key(kFdBus), with_key(kClassicBus), with_key(kUdp)));

TEST_P(AnsweredLink, KilledReaderIsSilentAndComesBackWithoutAHand) {
    Program& sender = start_sender(job_);
    Program* reader = &start_reader(job_);
    ASSERT_TRUE(carry_until_control()) << sender.errors() << reader->errors();
    reader->signal(SIGKILL);
    reader->end();
    servos().listen();
    EXPECT_TRUE(carry_for(milliseconds(200)).empty());
    EXPECT_TRUE(sender.says("cannot send: no receiver with the same key")) << sender.errors();
    reader = &start_reader(job_);
    EXPECT_TRUE(carry_until_control()) << sender.errors() << reader->errors();
    expect_clean_end(sender);
    expect_clean_end(*reader);
}

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

/// A reader that is killed does not know what it took, and may be deaf for 20 s.
TEST_P(BroadcastLink, KilledReaderComesBackWithoutAHand) {
    Program& sender = start_sender(GetParam());
    Program* reader = &start_reader(GetParam());
    ASSERT_TRUE(carry_until_control()) << sender.errors() << reader->errors();
    reader->signal(SIGKILL);
    reader->end();
    reader = &start_reader(GetParam());
    bool controlled = false;
    for (int i = 0; i < 3 && !controlled; ++i) {
        controlled = carry_until_control();
    }
    EXPECT_TRUE(controlled) << sender.errors() << reader->errors();
    expect_clean_end(sender);
    expect_clean_end(*reader);
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

}  // namespace
}  // namespace tribus::test::link_program_test
