#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "config/build/build.h"
#include "tests/support/fixed_clock.h"
#include "tests/support/ibus_checksum.h"
#include "tests/support/streams.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/config/main_job.h"
#include "tests/unit/transports/codecs/mavlink/mavlink_messages.h"
#include "transports/codecs/mavlink/signature.h"

/// The value engine of a configuration.
namespace tribus::test::values_test {
namespace {

using namespace std::chrono_literals;

constexpr Instant kStart{1000s};

/// The nine lines and more, under way since kStart.
struct Running {
    explicit Running(const Configuration& configuration, const WallClock* clock = nullptr)
        : engine(build_engine(configuration)),
          values(build_value_engine(configuration, *engine, clock)) {
        engine->start(kStart);
        values->start(kStart);
        values->poll(*engine, kStart);
    }
    explicit Running(const std::string& more) : Running(loaded(main_job_with(10, more))) {}

    /// Bytes that a bus sends within a time.
    Bytes sent(std::size_t bus, Instant from, Duration within) {
        for (Instant now = from; now <= from + within; now += 50us) {
            values->poll(*engine, now);
            if (std::ranges::count(values->ran(), bus) > 0) {
                const auto bytes = values->take(bus).bytes();
                return {bytes.begin(), bytes.end()};
            }
        }
        return {};
    }
    /// The answer of a bus to a request.
    Bytes answer(const Bytes& request, std::size_t bus = 0, Duration within = 2ms) {
        const Instant now = kStart + 1s;
        values->receive(bus, with_ibus_checksum(request), now);
        return sent(bus, now, within);
    }
    std::unique_ptr<Engine> engine;
    std::unique_ptr<ValueEngine> values;
};

const std::string kPack = "[values.pack]\nconstant = 12000\nunit = \"mV\"\n";

/// A bus with one sensor of the external voltage, in units of 10 mV.
std::string voltage_sensor(const std::string& more, const std::string& bus = "") {
    return "[sensor_bus.own]\nrole = \"sensor\"\ndevice = \"/dev/ttyT\"\n" + bus +
           "[[sensor_bus.own.sensor]]\ntype = \"external_voltage\"\nvalue = \"pack\"\n" + more;
}

Bytes value_answer(std::uint8_t address, std::uint16_t raw) {
    return with_ibus_checksum({0x06, static_cast<std::uint8_t>(0xA0 | address),
                               static_cast<std::uint8_t>(raw),
                               static_cast<std::uint8_t>(raw >> 8U)});
}

TEST(BuiltSensor, ConvertsItsValueToTheUnitOfItsType) {
    EXPECT_EQ(Running(kPack + voltage_sensor("")).answer({0x04, 0xA1}), value_answer(1, 1200));
    EXPECT_EQ(Running(kPack + voltage_sensor("offset = 1\n")).answer({0x04, 0xA1}),
              value_answer(1, 1300));
}

TEST(BuiltSensor, TakesAScaleInsteadOfTheUnits) {
    EXPECT_EQ(Running(kPack + voltage_sensor("scale = 0.002\noffset = -1\n")).answer({0x04, 0xA1}),
              value_answer(1, 2300));
}

TEST(BuiltSensor, HasItsAddress) {
    Running running(kPack + voltage_sensor("", "address = 3\n"));
    EXPECT_EQ(running.answer({0x04, 0xA1}), Bytes{});
    EXPECT_EQ(running.answer({0x04, 0xA3}), value_answer(3, 1200));
}

TEST(BuiltSensor, TakesTheFirstAddressThatIsSoughtAtTheEndOfAChain) {
    Running running(kPack + voltage_sensor("", "chain = true\n"));
    EXPECT_EQ(running.answer({0x04, 0xA1}), Bytes{});
    EXPECT_EQ(running.answer({0x04, 0x85}), with_ibus_checksum({0x04, 0x85}));
}

TEST(BuiltSensor, AnswersAfterItsTime) {
    Running running(kPack + voltage_sensor("", "reply_after = \"500us\"\n"));
    EXPECT_EQ(running.answer({0x04, 0xA1}, 0, 400us), Bytes{});
    EXPECT_EQ(running.sent(0, kStart + 1s + 450us, 100us), value_answer(1, 1200));
}

TEST(BuiltSensor, SendsItsNumberForWhatIsNotAvailable) {
    const std::string sensor =
        "[values.pack]\ninterface = \"can0\"\n"
        "dronecan = \"uavcan.equipment.power.CircuitStatus\"\n"
        "[sensor_type.own]\nid = 133\nunit = \"V\"\n"
        "[sensor_bus.own]\nrole = \"sensor\"\ndevice = \"/dev/ttyT\"\n"
        "[[sensor_bus.own.sensor]]\ntype = \"own\"\nvalue = \"pack.voltage\"\n";
    EXPECT_EQ(Running(sensor).answer({0x04, 0xA1}), Bytes{});
    EXPECT_EQ(Running(sensor + "not_available = 5\n").answer({0x04, 0xA1}), value_answer(1, 5));
}

TEST(BuiltSensor, HasZeroInAFieldWithoutAValue) {
    EXPECT_EQ(Running("[values.cells]\nconstant = 6\n[sensor_bus.own]\nrole = \"sensor\"\n"
                      "device = \"/dev/ttyT\"\n[[sensor_bus.own.sensor]]\ntype = \"gps_status\"\n"
                      "values = { satellites = \"cells\" }\n")
                  .answer({0x04, 0xA1}),
              value_answer(1, 0x0600));
}

TEST(BuiltReceiver, AsksForTheFirstSensorInItsSlot) {
    Running running(
        "[sensor_bus.a]\nrole = \"receiver\"\ndevice = \"/dev/ttyT\"\npower_up = false\n"
        "[sensor_bus.b]\nrole = \"receiver\"\ndevice = \"/dev/ttyU\"\n");
    EXPECT_EQ(running.values->bus_count(), 2U);
    EXPECT_TRUE(running.values->bus_state(0).is_receiver);
    EXPECT_EQ(running.sent(0, kStart, 20ms), with_ibus_checksum({0x04, 0x81}));
    EXPECT_NE(running.sent(1, kStart, 20ms), with_ibus_checksum({0x04, 0x81}))
        << "it begins with the frames of power-up";
}

TEST(BuiltReceiver, PutsAReadingOnTheBoard) {
    Running running(
        "[sensor_bus.a]\nrole = \"receiver\"\ndevice = \"/dev/ttyT\"\n"
        "power_up = false\nwires = \"two\"\n");
    Instant now = kStart;
    const auto exchange = [&](const Bytes& request, const Bytes& reply) {
        Bytes asked;
        for (; asked != with_ibus_checksum(request) && now < kStart + 2s; now += 50us) {
            asked = running.sent(0, now, Duration::zero());
            if (!asked.empty()) {
                running.values->written(0, now);
            }
        }
        now += 1ms;
        running.values->receive(0, with_ibus_checksum(reply), now);
    };
    exchange({0x04, 0x81}, {0x04, 0x81});
    exchange({0x04, 0x91}, {0x06, 0x91, 0x03, 0x02});
    exchange({0x04, 0xA1}, {0x06, 0xA1, 0xB0, 0x04});
    const ValueBoard& board = running.values->board();
    for (const std::string name : {"a.1", "a.external_voltage"}) {
        EXPECT_NEAR(board.fresh(board.find(name).value(), now).value_or(0), 12, 1e-9) << name;
    }
    EXPECT_EQ(board.fresh(board.find("a.1.raw").value(), now), 1200);
}

TEST(BuiltValues, AreReadByEveryOutput) {
    Running running(
        loaded("[output.o]\nprotocol = \"crsf-telemetry\"\ndevice = \"/dev/ttyC\"\n"
               "battery = { voltage = \"pack\" }\n" +
               main_job_with(10, kPack)));
    const auto first = [&] {
        for (Instant now = kStart; now < kStart + 2s; now += 10ms) {
            running.engine->poll(now);
            const auto bytes = running.engine->output(0).take().bytes();
            if (!bytes.empty()) {
                return Bytes(bytes.begin(), bytes.end());
            }
        }
        return Bytes{};
    }();
    ASSERT_GT(first.size(), 5U);
    EXPECT_EQ(Bytes(first.begin() + 2, first.begin() + 5), (Bytes{0x08, 0x00, 120}))
        << "a frame of a battery of 12.0 V";
}

/// A configuration that reads signed telemetry.
class SignedValues : public ::testing::Test {
  protected:
    SignedValues() {
        std::iota(key_.begin(), key_.end(), std::uint8_t{1});
        std::filesystem::permissions(
            folder_.write("drone.key", std::string(key_.begin(), key_.end())),
            std::filesystem::perms::owner_read);
    }
    /// The voltage behind a message that was signed so long before the day of the clock.
    std::optional<double> voltage(Duration age, const WallClock* clock) const {
        const auto configuration = load_configuration(
            main_job_with(10,
                          "[values.drone]\nprotocol = \"mavlink-telemetry\"\n"
                          "device = \"/dev/ttyC\"\nkey = \"drone.key\"\n"
                          "[sensor_bus.probes]\nrole = \"receiver\"\ndevice = \"/dev/ttyS\"\n"),
            folder_ / "t.toml");
        EXPECT_TRUE(configuration);
        Running running(*configuration, clock);
        MavlinkSigner signer(key_, 0);
        const FixedClock of_sender(kDay - age, kStart);
        signer.use_clock(of_sender);
        Bytes frame = message_2(1, 124,
                                from_hex("00000000 00000000 00000000 fa00 3831 5901 0000 0000 0000 "
                                         "0000 0000 0000 57"),
                                {.flags = 1});
        signer.sign(frame, frame.size() - 13, kStart);
        running.values->receive_message(0, frame, kStart);
        const ValueBoard& board = running.values->board();
        return board.fresh(board.find("drone.system.voltage").value(), kStart);
    }
    /// 2026-11-26, 00:00:00 UTC.
    static constexpr Duration kDay = 1795651200s;
    SecretKey key_{};
    TemporaryFolder folder_;
};

TEST_F(SignedValues, CountIfTheClockSaysThatTheyAreNew) {
    const FixedClock clock(kDay, kStart);
    EXPECT_EQ(voltage(10s, &clock), 12.6);
    EXPECT_EQ(voltage(1h, &clock), std::nullopt);
    EXPECT_EQ(voltage(1h, nullptr), 12.6) << "without a clock the first one counts";
}

}  // namespace
}  // namespace tribus::test::values_test
