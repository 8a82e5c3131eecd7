#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/lab/guest.h"
#include "tests/loopback/loopback.h"

/// The shipped DBC examples, with only the names of the devices changed. A gateway in the kernel
/// carries what they send on can0 to can1, where they read it.
namespace tribus::test::can_examples_test {
namespace {

using std::chrono::milliseconds;

/// A value in two bytes of a frame, low byte first.
struct Mark {
    std::uint32_t id = 0;
    std::size_t byte = 0;
    unsigned mask = 0;
    unsigned value = 0;
};

struct DbcExample {
    std::string name;
    /// SBUS channels, counted from 0, and how many SBUS steps (0.625 us) they may be off: half a
    /// step of the format plus the rounding to SBUS.
    std::map<std::size_t, int> sticks;
    /// SBUS channels, counted from 0, that are on or off.
    std::vector<std::size_t> switches;
    /// Mark in the frames while there is no receiver. If absent, no frames are sent then.
    std::optional<Mark> failsafe;
};

std::map<std::size_t, int> first_channels(std::size_t count, int most_off) {
    std::map<std::size_t, int> all;
    for (std::size_t channel = 0; channel < count; ++channel) {
        all[channel] = most_off;
    }
    return all;
}

constexpr int kOff = 192;  // 1000 us
constexpr int kOn = 1792;  // 2000 us

std::string replaced(std::string text, const std::string& part, const std::string& by) {
    EXPECT_NE(text.find(part), std::string::npos) << part;
    for (std::size_t at = text.find(part); at != std::string::npos;
         at = text.find(part, at + by.size())) {
        text.replace(at, part.size(), by);
    }
    return text;
}

class DbcExampleRuns : public Loopback, public testing::WithParamInterface<DbcExample> {
  protected:
    DbcExampleRuns() {
        shell("modprobe can-gw");
        shell("cangw -A -s vcan0 -d vcan1 -e");
    }
    ~DbcExampleRuns() override { shell("cangw -F"); }

    Program& run_example() {
        const std::filesystem::path examples =
            std::filesystem::path(TRIBUS_SOURCE_DIR) / "config" / "examples";
        const std::string& name = GetParam().name;
        std::filesystem::copy_file(examples / (name + ".dbc"), folder() / (name + ".dbc"));
        std::string text = read_file(examples / (name + ".toml"));
        text = replaced(text, "\"/dev/ttyAMA5\"", "\"" + receiver_.path() + "\"");
        text = replaced(text, "\"/dev/ttyAMA3\"", "\"" + wire_.path() + "\"");
        text = replaced(text, "\"can0\"", "\"vcan0\"");
        text = replaced(text, "\"can1\"", "\"vcan1\"");
        std::ofstream(folder() / (name + ".toml")) << text;
        return run(folder() / (name + ".toml"));
    }

    /// Returns sticks and switches over their whole range, different for each number.
    static SbusSight position(int number) {
        SbusSight sight;
        for (const auto& [channel, most_off] : GetParam().sticks) {
            const int travel = number * 657 + static_cast<int>(channel) * 397;
            sight.raw[channel] = kOff + travel % (kOn - kOff + 1);
        }
        for (const std::size_t channel : GetParam().switches) {
            sight.raw[channel] = (number + static_cast<int>(channel)) % 2 == 0 ? kOn : kOff;
        }
        return sight;
    }
    static bool same(const SbusSight& seen, const SbusSight& sent) {
        bool same = true;
        for (const auto& [channel, most_off] : GetParam().sticks) {
            same = same && std::abs(seen.raw[channel] - sent.raw[channel]) <= most_off;
        }
        for (const std::size_t channel : GetParam().switches) {
            same = same && seen.raw[channel] == sent.raw[channel];
        }
        return same;
    }
    /// Sends the position until the servos have it.
    testing::AssertionResult arrives(const SbusSight& sent) {
        Repeater repeater(receiver_, sbus_bytes(sent));
        SbusSight latest;
        const bool done = eventually([&] {
            repeater.send_if_due();
            bool found = false;
            for (const SbusSight& sight : bank_.listen()) {
                latest = sight;
                found = found || (sight.good() && same(sight, sent));
            }
            return found;
        });
        return done ? testing::AssertionSuccess()
                    : testing::AssertionFailure()
                          << "sent " << testing::PrintToString(sent.raw) << ", servos have "
                          << testing::PrintToString(latest.raw) << " lost " << latest.frame_lost
                          << " failsafe " << latest.failsafe;
    }
    bool servos_see_failsafe() {
        return eventually([&] {
            bool seen = false;
            for (const SbusSight& sight : bank_.listen()) {
                seen = sight.failsafe;
            }
            return seen;
        });
    }
    /// Returns whether the bus is silent for a while, or its frames are marked failsafe.
    bool bus_says_failsafe() {
        const auto& mark = GetParam().failsafe;
        if (!mark) {
            return eventually([&] {
                watcher_.receive_all();
                return !watcher_.receive(milliseconds(500));
            });
        }
        return eventually([&] {
            bool said = false;
            for (const CanSight& sight : watcher_.receive_all()) {
                const unsigned low = sight.frame.data[mark->byte];
                const unsigned high = sight.frame.data[mark->byte + 1];
                const unsigned word = low | high << 8U;
                said = said || (sight.frame.id == mark->id && (word & mark->mask) == mark->value);
            }
            return said;
        });
    }

    VirtualBus near_{"vcan0"};
    VirtualBus far_{"vcan1"};
    RawCan watcher_{"vcan0"};
    FarEnd& receiver_ = device("receiver");
    FarEnd& wire_ = device("servos");
    ServoBank bank_{wire_};
};

INSTANTIATE_TEST_SUITE_P(
    Shipped, DbcExampleRuns,
    testing::Values(DbcExample{"rc-box", first_channels(16, 1), {}, std::nullopt},
                    // XPosition of BJM1, bits 6 to 15, is 1022: error.
                    DbcExample{"j1939-joystick",
                               first_channels(4, 1),
                               {4, 5, 6, 7},
                               Mark{0x0CFDD633, 0, 0xFFC0, 1022 << 6}},
                    // LinkGood, bit 48 of the second PDO, is 0.
                    DbcExample{"canopen-pdo", first_channels(7, 0), {7}, Mark{0x305, 6, 1, 0}},
                    // 1 % of the travel is 5 us.
                    DbcExample{"rover-command", {{0, 4}, {2, 4}}, {}, std::nullopt}),
    [](const auto& test) {
        std::string name = test.param.name;
        std::erase(name, '-');
        return name;
    });

TEST_P(DbcExampleRuns, CarriesSticksThereAndBackAndTellsTheLossOfTheReceiver) {
    Program& program = run_example();
    for (int number = 0; number < 8; ++number) {
        ASSERT_TRUE(arrives(position(number))) << program.errors();
    }
    EXPECT_TRUE(servos_see_failsafe()) << program.errors();
    EXPECT_TRUE(bus_says_failsafe()) << program.errors();
    EXPECT_TRUE(arrives(position(8))) << program.errors();
    expect_clean_end(program);
}

TEST_P(DbcExampleRuns, EndsInFailsafeWhenTheBusIsCutAndComesBack) {
    Program& program = run_example();
    ASSERT_TRUE(arrives(position(1))) << program.errors();
    shell("cangw -F");
    Repeater repeater(receiver_, sbus_bytes(position(1)));
    EXPECT_TRUE(eventually([&] {
        repeater.send_if_due();
        bool failsafe = false;
        for (const SbusSight& sight : bank_.listen()) {
            failsafe = failsafe || sight.failsafe;
        }
        return failsafe;
    })) << program.errors();
    shell("cangw -A -s vcan0 -d vcan1 -e");
    EXPECT_TRUE(arrives(position(2))) << program.errors();
    expect_clean_end(program);
}

}  // namespace
}  // namespace tribus::test::can_examples_test
