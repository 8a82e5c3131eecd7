#include <csignal>

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/lab/two_programs.h"

/// Two built programs with a bus between them, and faults of the bus.
namespace tribus::test::can_program_test {
namespace {

using std::chrono::milliseconds;

class Carrying : public TwoPrograms, public testing::WithParamInterface<BusJob> {
  protected:
    VirtualBus bus_;
    BusJob job_ = GetParam();
};

INSTANTIATE_TEST_SUITE_P(
    Formats, Carrying,
    testing::Values(BusJob{}, BusJob{.format = "protocol = \"can\"\nfd = true"},
                    BusJob{.format = "protocol = \"can\"\ncrc = \"p01\"\nid = 0x1234500\n"
                                     "extended = true"},
                    BusJob{.format = "protocol = \"dronecan\"", .sender_lines = "node_id = 42"},
                    BusJob{.format = "protocol = \"dronecan\"\nfd = true",
                           .sender_lines = "node_id = 42"}));

TEST_P(Carrying, EverySticksOfTheCaptureComesOutExactly) {
    Program& sender = start_sender(job_);
    Program& reader = start_reader(job_);
    ASSERT_TRUE(carry_until_control()) << sender.errors() << reader.errors();
    expect_recorded_sticks(sender, reader);
    expect_clean_end(sender);
    expect_clean_end(reader);
}

class BusFault : public TwoPrograms {};

TEST_F(BusFault, KilledSenderEndsInFailsafeAndComesBack) {
    const VirtualBus bus;
    Program* sender = &start_sender({});
    Program& reader = start_reader({});
    expect_times(expect_failsafe_and_recovery(
        "sender killed, started again",
        [&] {
            sender->signal(SIGKILL);
            sender->end();
        },
        [&] { sender = &start_sender({}); }));
    expect_clean_end(*sender);
    expect_clean_end(reader);
}

TEST_F(BusFault, KilledReaderIsSilentAndComesBack) {
    const VirtualBus bus;
    Program& sender = start_sender({});
    Program* reader = &start_reader({});
    ASSERT_TRUE(carry_until_control());
    reader->signal(SIGKILL);
    reader->end();
    servos().listen();
    EXPECT_TRUE(carry_for(milliseconds(200)).empty());
    reader = &start_reader({});
    EXPECT_TRUE(carry_until_control());
    expect_clean_end(sender);
    expect_clean_end(*reader);
}

TEST_F(BusFault, InterfaceThatGoesDownEndsInFailsafeAndComesBack) {
    const VirtualBus bus;
    Program& sender = start_sender({});
    Program& reader = start_reader({});
    expect_times(expect_failsafe_and_recovery(
        "interface down, up again", [&] { bus.down(); }, [&] { bus.up(); }));
    EXPECT_TRUE(reader.says("interface vcan0: is down"));
    EXPECT_TRUE(reader.says("interface vcan0: works"));
    expect_clean_end(sender);
    expect_clean_end(reader);
}

TEST_F(BusFault, InterfaceThatVanishesEndsInFailsafeAndComesBack) {
    VirtualBus bus;
    Program& sender = start_sender({});
    Program& reader = start_reader({});
    expect_times(expect_failsafe_and_recovery(
        "interface removed, created again", [&] { bus.remove(); }, [&] { bus.create(); }));
    EXPECT_TRUE(reader.says("vcan0: is back"));
    expect_clean_end(sender);
    expect_clean_end(reader);
}

TEST_F(BusFault, InterfacesThatSwapTheirNamesAreFollowedByName) {
    const VirtualBus one("vcan0");
    const VirtualBus other("vcan1");
    Program& sender = start_sender({});
    Program& reader = start_reader({});
    ASSERT_TRUE(carry_until_control()) << sender.errors() << reader.errors();
    swap_names("vcan0", "vcan1");
    EXPECT_TRUE(reader.says("vcan0: is back")) << reader.errors();
    EXPECT_TRUE(sender.says("vcan0: is back")) << sender.errors();
    RawCan elsewhere("vcan1");
    RawCan meant("vcan0");
    servos().listen();
    EXPECT_TRUE(carry_until_control()) << sender.errors() << reader.errors();
    EXPECT_FALSE(meant.receive_all().empty());
    EXPECT_TRUE(elsewhere.receive_all().empty()) << "it still sends on the bus of before";
    expect_clean_end(sender);
    expect_clean_end(reader);
}

/// A gateway flips a bit in each payload, as a bad controller driver would.
TEST_F(BusFault, CorruptedFramesEndInFailsafeAndComeBack) {
    const VirtualBus near("vcan0");
    const VirtualBus far("vcan1");
    const BusJob job{.reader_interface = "vcan1"};
    shell("modprobe can-gw");
    const std::string route = "cangw -A -s vcan0 -d vcan1 -e";
    shell(route);
    Program& sender = start_sender(job);
    Program& reader = start_reader(job);
    expect_times(expect_failsafe_and_recovery(
        "one bit of each frame wrong, right again",
        [&] {
            shell("cangw -F");
            shell(route + " -m XOR:D:0.0.0000000000040000");
        },
        [&] {
            shell("cangw -F");
            shell(route);
        }));
    shell("cangw -F");
    expect_clean_end(sender);
    expect_clean_end(reader);
}

TEST_F(BusFault, SilentReceiverReachesTheServosAsFailsafe) {
    const VirtualBus bus;
    Program& sender = start_sender({});
    Program& reader = start_reader({});
    ASSERT_TRUE(carry_until_control());
    EXPECT_TRUE(eventually([&] {
        const auto seen = servos().listen();
        return std::ranges::any_of(seen, &SbusSight::failsafe);
    }));
    EXPECT_TRUE(carry_until_control());
    expect_clean_end(sender);
    expect_clean_end(reader);
}

TEST_F(BusFault, ForeignSenderOfTheSameIdsEndsInFailsafeAndIsNamed) {
    const VirtualBus bus;
    Program& sender = start_sender({});
    Program& reader = start_reader({});
    ASSERT_TRUE(carry_until_control());
    RawCan foreign("vcan0");
    const CanFrame frame = make_frame(0x300, {0, 1, 2, 3, 4, 5, 6, 7});
    EXPECT_TRUE(carry_until([&](const SbusSight& sight) {
        foreign.send(frame);
        return sight.failsafe;
    }));
    EXPECT_TRUE(sender.says("another node sends frames with its ids"));
    EXPECT_TRUE(carry_until_control());
    expect_clean_end(sender);
    expect_clean_end(reader);
}

}  // namespace
}  // namespace tribus::test::can_program_test
