#include <csignal>
#include <cstddef>
#include <optional>
#include <string>
#include <tuple>

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

const auto kKeyedJobs =
    testing::Values(with_key(kFdBus), with_key(kClassicBus), with_key(kUdp), with_epoch(kFdBus),
                    with_epoch(kClassicBus), with_epoch(kUdp));

INSTANTIATE_TEST_SUITE_P(Links, KeyedLink, kKeyedJobs);

TEST_P(KeyedLink, EverySticksOfTheCaptureComesOutExactly) {
    Program& reader = start_reader(job_);
    Program& sender = start_sender(job_);
    expect_recorded_sticks(sender, reader);
    expect_clean_end(sender);
    expect_clean_end(reader);
}

class KeyedLinkOfAReceiver : public TwoPrograms,
                             public testing::WithParamInterface<std::tuple<BusJob, Capture>> {
  protected:
    KeyedLinkOfAReceiver() { write_key("boat.key", '7'); }

    const BusJob& job_ = std::get<BusJob>(GetParam());
    Way way_{job_};
};

INSTANTIATE_TEST_SUITE_P(Links, KeyedLinkOfAReceiver,
                         testing::Combine(kKeyedJobs, testing::ValuesIn(captures())));

/// The capture at its own pace: 18 channels every 4 ms.
TEST_P(KeyedLinkOfAReceiver, MovesTheServosInItsOrderAndItsEndIsFailsafe) {
    const Capture capture = std::get<Capture>(GetParam());
    const auto rows = recorded_sticks(capture);
    Program& reader = start_reader(job_);
    Program& sender = start_sender(job_);
    ASSERT_TRUE(carry_until_control()) << sender.errors() << reader.errors();
    RecordedReceiver recorded(receiver(), capture);
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

}  // namespace
}  // namespace tribus::test::link_program_test
