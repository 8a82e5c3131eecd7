#include <algorithm>
#include <cstdint>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "tests/loopback/loopback.h"

namespace tribus::test::main_job_test {
namespace {

enum class Sending : std::uint8_t { once, again_and_again };

/// Sends `bytes` and returns what the servos see until a good frame has these channels. One frame
/// alone gives no control at the start.
std::vector<SbusSight> send_and_collect(FarEnd& receiver, const Bytes& bytes, ServoBank& servos,
                                        const SbusSight& wanted,
                                        Sending sending = Sending::again_and_again) {
    std::vector<SbusSight> seen;
    Repeater repeater(receiver, bytes);
    repeater.send_if_due();
    EXPECT_TRUE(eventually([&] {
        if (sending == Sending::again_and_again) {
            repeater.send_if_due();
        }
        for (const SbusSight& sight : servos.listen()) {
            seen.push_back(sight);
        }
        return std::any_of(seen.begin(), seen.end(), [&](const SbusSight& sight) {
            return sight.good() && same_channels(sight, wanted);
        });
    }));
    return seen;
}

TEST_F(Loopback, EighteenIbusChannelsComeOutAsExactSbusValues) {
    FarEnd& receiver = device("receiver");
    ServoBank servos(device("servos"));
    Program& program = run(write_config(main_job(kPatientInput)));
    const Sticks sticks{880,  885,  988,  1000, 1012, 1100, 1250, 1499, 1500,
                        1501, 1750, 1900, 2000, 2012, 2100, 2159, 2000, 1000};
    SbusSight expected;
    // Each value is the nearest to (us - 880) * 8 / 5, calculated by hand (docs/protocols/sbus.md,
    // "Scales").
    expected.raw = {0,   8,   173,  192,  211,  352,  592,  990,
                    992, 994, 1392, 1632, 1792, 1811, 1952, 2046};
    expected.channel_17 = true;
    send_and_collect(receiver, ibus_bytes(sticks), servos, expected);
    EXPECT_EQ(servos.strays(), 0U);
    expect_clean_end(program);
}

/// Bytes with a meaning for a terminal: interrupt, end of file, line ends, XON and XOFF, erase, and
/// 0xFF, which the kernel doubles if it marks parity errors.
TEST_F(Loopback, BytesThatMeanSomethingToATerminalPassUnchanged) {
    FarEnd& receiver = device("receiver");
    ServoBank servos(device("servos"));
    Program& program = run(write_config(main_job("timeout = \"5s\"\nplausible = [0, 4095]")));
    const std::vector<Sticks> all{
        {0x503, 0x504, 0x50A, 0x50D, 0x511, 0x513, 0x51A, 0x51C, 0x57F, 0x500, 0x512, 0x516, 0x515,
         0x50F},
        {0x5FF, 0x6FF, 0x4FF, 0x7FF, 0x5FF, 0x6FF, 0x4FF, 0x7FF, 0x5FF, 0x6FF, 0x4FF, 0x7FF, 0x5FF,
         0x6FF},
        // Slot 1 is ff ff and slot 2 is ff d0: 0xFF after 0xFF, and before a zero nibble.
        {0xFFF, 0x0FF, 1500, 1500, 1500, 1500, 1500, 1500, 1500, 1500, 1500, 1500, 1500, 1500,
         0x5DF, 1600, 2000, 1000},
    };
    for (const Sticks& sticks : all) {
        send_and_collect(receiver, ibus_bytes(sticks), servos, sbus_sight_of(sticks));
    }
    EXPECT_EQ(servos.strays(), 0U);
    expect_clean_end(program);
}

TEST_F(Loopback, EveryFrameSentAfterTheOneBeforeItCameOutComesOutInOrder) {
    FarEnd& receiver = device("receiver");
    ServoBank servos(device("servos"));
    Program& program = run(write_config(main_job(kPatientInput)));
    std::vector<SbusSight> sent;
    std::vector<SbusSight> changes;
    for (int number = 0; number < 60; ++number) {
        Sticks sticks;
        for (int channel = 0; channel < 18; ++channel) {
            sticks.push_back(880 + (number * 20 + channel * 37) % 1280);
        }
        sent.push_back(sbus_sight_of(sticks));
        for (const SbusSight& sight :
             send_and_collect(receiver, ibus_bytes(sticks), servos, sent.back())) {
            if (sight.good() && (changes.empty() || !same_channels(changes.back(), sight))) {
                changes.push_back(sight);
            }
        }
    }
    EXPECT_TRUE(std::equal(changes.begin(), changes.end(), sent.begin(), sent.end(), same_channels))
        << changes.size() << " different frames came out, perhaps in another order";
    EXPECT_EQ(servos.strays(), 0U);
    expect_clean_end(program);
}

TEST_F(Loopback, NewestFrameOfABurstComesOutAndNoneIsQueued) {
    FarEnd& receiver = device("receiver");
    ServoBank servos(device("servos"));
    Program& program = run(write_config(main_job(kPatientInput)));
    send_and_collect(receiver, ibus_bytes(sticks_with_first(1000)), servos,
                     sbus_sight_of(sticks_with_first(1000)));
    Bytes burst;
    for (const int first : {1100, 1200, 1300, 1400, 1600}) {
        const Bytes frame = ibus_bytes(sticks_with_first(first));
        burst.insert(burst.end(), frame.begin(), frame.end());
    }
    const std::vector<SbusSight> seen = send_and_collect(
        receiver, burst, servos, sbus_sight_of(sticks_with_first(1600)), Sending::once);
    std::set<int> older;
    for (const SbusSight& sight : seen) {
        older.insert(sight.raw[0]);
    }
    older.erase(sbus_raw(1000));
    older.erase(sbus_raw(1600));
    // The kernel may deliver the burst in two parts.
    EXPECT_LE(older.size(), 1U);
    std::vector<SbusSight> later;
    eventually([&] {
        for (const SbusSight& sight : servos.listen()) {
            later.push_back(sight);
        }
        return later.size() >= 10;
    });
    EXPECT_TRUE(std::all_of(later.begin(), later.end(),
                            [](const SbusSight& sight) { return sight.raw[0] == sbus_raw(1600); }));
    expect_clean_end(program);
}

TEST_F(Loopback, SbusComesOutAsExactIbusValues) {
    FarEnd& receiver = device("receiver");
    FarEnd& controller = device("controller");
    IbusReader reader(controller);
    Program& program = run(write_config(R"(
[input.receiver]
protocol = "sbus"
device   = "@receiver"
timeout  = "5s"

[output.controller]
protocol = "ibus"
device   = "@controller"
channels = 18

[pipeline.main]
from = "receiver"
to   = "controller"
)"));
    SbusSight sight;
    sight.raw = {0,   172,  192,  208,  656,  661,  667,  670,
                 992, 1024, 1631, 1792, 1811, 2000, 2046, 2047};
    sight.channel_18 = true;
    // 880 + raw * 5 / 8, rounded; 1290 to 1299 have the low bytes 0a, 0d, 11, 13.
    const Sticks expected{880,  988,  1000, 1010, 1290, 1293, 1297, 1299, 1500,
                          1520, 1899, 2000, 2012, 2130, 2159, 2159, 1000, 2000};
    Repeater repeater(receiver, sbus_bytes(sight));
    std::vector<Sticks> seen;
    EXPECT_TRUE(eventually([&] {
        repeater.send_if_due();
        seen = reader.listen();
        return !seen.empty();
    }));
    ASSERT_FALSE(seen.empty());
    EXPECT_EQ(seen.back(), expected);
    EXPECT_EQ(reader.strays(), 0U);
    expect_clean_end(program);
}

TEST_F(Loopback, OneDeviceServesAnInputAndAnOutput) {
    FarEnd& port = device("port");
    Program& program = run(write_config(R"(
[input.receiver]
protocol = "ibus"
device   = "@port"
timeout  = "5s"

[output.controller]
protocol = "ibus"
device   = "@port"

[pipeline.main]
from = "receiver"
to   = "controller"

[pipeline.main.channels]
1 = 2
2 = 1
)"));
    IbusReader reader(port);
    Sticks sticks = sticks_with_first(1100, 14);
    sticks[1] = 1900;
    Sticks swapped = sticks;
    std::swap(swapped[0], swapped[1]);
    Repeater repeater(port, ibus_bytes(sticks));
    std::vector<Sticks> seen;
    EXPECT_TRUE(eventually([&] {
        repeater.send_if_due();
        for (const Sticks& frame : reader.listen()) {
            seen.push_back(frame);
        }
        return seen.size() >= 20;
    }));
    // Only its own frames, no echo of the input.
    EXPECT_EQ(std::count(seen.begin(), seen.end(), swapped), std::ssize(seen));
    EXPECT_EQ(reader.strays(), 0U);
    expect_clean_end(program);
}

TEST_F(Loopback, OneInputFeedsTwoPipelines) {
    FarEnd& receiver = device("receiver");
    ServoBank servos(device("servos"));
    IbusReader reader(device("controller"));
    Program& program = run(write_config(main_job(kPatientInput) + R"(
[output.controller]
protocol = "ibus"
device   = "@controller"

[pipeline.second]
from = "receiver"
to   = "controller"

[pipeline.second.channels]
1 = { from = 1, reverse = true }
)"));
    Repeater repeater(receiver, ibus_bytes(sticks_with_first(1100)));
    std::vector<SbusSight> sbus;
    std::vector<Sticks> ibus;
    EXPECT_TRUE(eventually([&] {
        repeater.send_if_due();
        for (const SbusSight& sight : servos.listen()) {
            if (sight.good()) {
                sbus.push_back(sight);
            }
        }
        for (const Sticks& frame : reader.listen()) {
            ibus.push_back(frame);
        }
        return sbus.size() >= 5 && ibus.size() >= 5;
    }));
    ASSERT_FALSE(sbus.empty());
    ASSERT_FALSE(ibus.empty());
    EXPECT_EQ(sbus.back().raw[0], sbus_raw(1100));
    EXPECT_EQ(ibus.back(), sticks_with_first(1900, 14));
    expect_clean_end(program);
}

/// A tty echoes what arrives before a program sets it up, and keeps it for the first reader.
TEST_F(Loopback, BytesFromBeforeTheStartAreNeitherDecodedNorSentBack) {
    FarEnd& receiver = device("receiver");
    ServoBank servos(device("servos"));
    const Bytes stale = ibus_bytes(sticks_with_first(1900));
    for (int i = 0; i < 10; ++i) {
        receiver.send(stale);
    }
    Program& program = run(write_config(main_job(kPatientInput)));
    receiver.receive();
    std::vector<SbusSight> seen;
    EXPECT_TRUE(eventually([&] {
        for (const SbusSight& sight : servos.listen()) {
            seen.push_back(sight);
        }
        return seen.size() >= 20;
    }));
    EXPECT_TRUE(std::all_of(seen.begin(), seen.end(),
                            [](const SbusSight& sight) { return sight.failsafe; }));
    send_and_collect(receiver, ibus_bytes(sticks_with_first(1100)), servos,
                     sbus_sight_of(sticks_with_first(1100)));
    EXPECT_EQ(receiver.receive().size(), 0U) << "echoed to the receiver";
    expect_clean_end(program);
}

}  // namespace
}  // namespace tribus::test::main_job_test
