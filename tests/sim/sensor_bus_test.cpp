#include <algorithm>
#include <random>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "pipelines/sensor_bus/receiver_role.h"
#include "pipelines/sensor_bus/sensor_role.h"
#include "tests/captures/recordings.h"
#include "tests/sim/sensor_wire.h"
#include "tests/support/heap_trap.h"
#include "tests/support/ibus_checksum.h"
#include "transports/recordings/recording.h"

/// Both roles of a sensor bus under virtual time: with a recorded receiver and its twin, with
/// simulated sensors, and with each other.
namespace tribus::test::sensor_bus_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr Instant kStart{1s};

SensorSettings sensor(std::string_view type, std::size_t value) {
    SensorSettings settings;
    settings.type = *SensorTypes().find(type);
    settings.sources = {FieldSource{.value = value}};
    return settings;
}

ValueBoard board_of(std::size_t values) {
    return ValueBoard(std::vector<NamedValue>(values, {"", "", 2s}));
}

/// A recording of a receiver with genuine sensors (README of the recordings).
struct RecordedBus {
    std::string_view file;
    std::uint8_t first_address = 1;
    std::vector<std::string_view> types;
    int answers = 0;  ///< number of recorded answers
};

class RecordedReceiver : public testing::TestWithParam<std::tuple<RecordedBus, Capture>> {
  protected:
    void SetUp() override {
        const auto& [bus, capture] = GetParam();
        bursts_ = recording_of(bus.file, capture).bursts;
    }
    static bool is_request(const Burst& burst) { return burst.bytes.size() == 4; }

    std::vector<Burst> bursts_;
};

TEST_P(RecordedReceiver, GetsTheRecordedAnswersByteForByteAndInTime) {
    const RecordedBus& bus = std::get<RecordedBus>(GetParam());
    SensorRoleSettings settings{.first_address = bus.first_address};
    for (std::size_t i = 0; i < bus.types.size(); ++i) {
        settings.sensors.push_back(sensor(bus.types[i], i));
    }
    SensorRole role(settings);
    ValueBoard board = board_of(bus.types.size());
    role.start(Instant{});
    int compared = 0;
    for (std::size_t i = 0; i + 1 < bursts_.size(); ++i) {
        if (!is_request(bursts_[i])) {
            continue;
        }
        const Instant asked_at = Instant(*bursts_[i].start) + 4 * kSensorByteTime;
        const bool answered = !is_request(bursts_[i + 1]);
        if (answered) {
            // The genuine sensor measures half a slot before the request.
            const Bytes& reply = bursts_[i + 1].bytes;
            const auto index = static_cast<std::size_t>((reply[1] & 0xFU) - bus.first_address);
            const SensorField& field = settings.sensors[index].type.fields[0];
            const auto raw = raw_in(field, std::span(reply).subspan(2, reply.size() - 4));
            board.set(index, *number_of(field, *raw), asked_at - 4ms);
            role.written(asked_at - 4ms, board);
        }
        role.receive(bursts_[i].bytes, asked_at, board);
        if (role.due() == kNever) {
            EXPECT_FALSE(answered) << "request at " << bursts_[i].start->count() / 1000 << " us";
            continue;
        }
        const Duration after = role.due() - asked_at;
        EXPECT_GE(after, 100us);
        EXPECT_LE(after, 1ms);
        const Instant now = role.due();
        const auto said = role.run(now, board);
        if (answered) {
            EXPECT_EQ(Bytes(said.begin(), said.end()), bursts_[i + 1].bytes);
            ++compared;
        }
        const Bytes echo(said.begin(), said.end());
        role.written(now, board);
        role.receive(echo, now + 6 * kSensorByteTime, board);
    }
    EXPECT_EQ(compared, bus.answers);
    EXPECT_EQ(role.counts().late, 0U);
    EXPECT_EQ(role.echo().collisions, 0U);
}

const RecordedBus kRecordedBuses[]{
    {"ibus_sensor_ia6b_2sensors.timed.txt", 1, {"rotation_speed", "external_voltage"}, 634},
    {"ibus_sensor_ia6b_rpmsensor.timed.txt", 1, {"rotation_speed"}, 700},
    {"ibus_sensor_ia6b_tap_between.timed.txt", 2, {"external_voltage"}, 316}};

INSTANTIATE_TEST_SUITE_P(FsIa6b, RecordedReceiver,
                         testing::Combine(testing::ValuesIn(kRecordedBuses),
                                          testing::ValuesIn(captures())),
                         [](const auto& test) {
                             return capture_name(std::get<Capture>(test.param)) +
                                    std::to_string(test.index);
                         });

ReceiverRoleSettings receiver_settings() {
    ReceiverRoleSettings settings;
    for (std::size_t i = 0; i < kMostSensors; ++i) {
        settings.readings[i] = {.raw = 2 * i, .fields = {2 * i + 1}};
    }
    return settings;
}

/// Genuine sensors as recorded: they answer 0.63 ms after the request, and now and then not at all
/// (docs/protocols/ibus.md, "Sensor bus: timing").
class GenuineSensors final : public SensorBusRole {
  public:
    explicit GenuineSensors(double miss) : miss_(miss) {}

    void start(Instant /*now*/) override {}
    void receive(std::span<const std::uint8_t> bytes, Instant now, ValueBoard& /*board*/) override {
        if (silenced_ > 0) {
            --silenced_;
            return;
        }
        const auto address = bytes.size() == 4 ? bytes[1] & 0xFU : 0U;
        if (address < 1 || address > 2 || chance_(random_) < miss_) {
            missed_ += address >= 1 && address <= 2 ? 1 : 0;
            return;
        }
        reply_.assign(bytes.begin(), bytes.end());
        if (bytes[1] >> 4U == 9) {
            reply_ = with_ibus_checksum({6, bytes[1], static_cast<std::uint8_t>(address + 1), 2});
        } else if (bytes[1] >> 4U == 0xA) {
            reply_ = with_ibus_checksum({6, bytes[1], static_cast<std::uint8_t>(10 * address), 0});
        }
        reply_at_ = now + 630us;
    }
    void damaged_byte(Instant /*now*/) override {}
    Instant due() const override { return reply_at_; }
    std::span<const std::uint8_t> run(Instant /*now*/, ValueBoard& /*board*/) override {
        reply_at_ = kNever;
        return reply_;
    }
    void written(Instant /*now*/, ValueBoard& /*board*/) override { silenced_ = 1; }
    void dropped() override {}
    void device_lost(ValueBoard& /*board*/) override {}
    int missed() const { return missed_; }

  private:
    double miss_;
    int missed_ = 0;
    int silenced_ = 0;  ///< bytes of its own that it still has to ignore
    Bytes reply_;
    Instant reply_at_ = kNever;
    std::minstd_rand random_{7};
    std::uniform_real_distribution<double> chance_{0, 1};
};

TEST(SensorBus, KeepsGenuineSensorsThatMissOneAnswerInEightyAsAGenuineReceiverDoes) {
    ReceiverRole receiver(receiver_settings());
    GenuineSensors sensors(0.0125);
    ValueBoard board = board_of(2 * kMostSensors);
    ValueBoard none = board_of(0);
    SensorWire wire({{&receiver, &board}, {&sensors, &none}}, kStart);
    std::vector<std::uint8_t> asked;
    wire.listen([&](std::size_t from, std::span<const std::uint8_t> bytes, Instant) {
        if (from == 0) {
            asked.push_back(bytes[1]);
        }
    });
    wire.run_until(kStart + 10s);
    ASSERT_EQ(receiver.found().size(), 2U);
    wire.run_until(kStart + 600s);
    EXPECT_EQ(receiver.found().size(), 2U);
    EXPECT_EQ(receiver.counts().lost_sensors, 0U);
    EXPECT_EQ(board.fresh(0, wire.now()), 10);
    EXPECT_EQ(board.fresh(2, wire.now()), 20);
    EXPECT_GT(sensors.missed(), 800);
    EXPECT_NEAR(static_cast<double>(receiver.counts().misses), sensors.missed(), 3);
    const auto probes = std::ranges::count(asked, 0x83);
    EXPECT_NEAR(static_cast<double>(probes), 600 / 0.50825, 5);
    int repeated = 0;
    for (std::size_t i = 1; i < asked.size(); ++i) {
        repeated += asked[i] >> 4U == 0xA && asked[i] == asked[i - 1] ? 1 : 0;
    }
    EXPECT_NEAR(repeated, static_cast<double>(receiver.counts().misses),
                0.02 * static_cast<double>(receiver.counts().misses))
        << "each missed answer is requested again at once, a second one in a row is not";
}

/// Faults of one frame on the wire.
enum class Fault : std::uint8_t { lost_byte, flipped_bit, extra_byte, lost_frame, stall, count };

void spoil(Bytes& bytes, Fault fault, std::minstd_rand& random) {
    const std::size_t place = random() % bytes.size();
    switch (fault) {
        case Fault::lost_byte:
            bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(place));
            break;
        case Fault::flipped_bit:
            bytes[place] ^= static_cast<std::uint8_t>(1U << (random() % 8));
            break;
        case Fault::extra_byte:
            bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(place),
                         static_cast<std::uint8_t>(random()));
            break;
        default:
            bytes.clear();
            break;
    }
}

TEST(SensorBus, LosesNothingButTheFaultedSlotsInAnHourOfRandomFaults) {
    constexpr std::size_t kSensors = 3;
    SensorRole role({.first_address = 1,
                     .sensors = {sensor("external_voltage", 0), sensor("temperature", 1),
                                 sensor("latitude", 2)}});
    ReceiverRole receiver(receiver_settings());
    ValueBoard given = board_of(kSensors);
    ValueBoard read = board_of(2 * kMostSensors);
    SensorWire wire({{&receiver, &read}, {&role, &given}}, kStart);
    const auto give = [&](Instant now) {
        given.set(0, -1.23, now);
        given.set(1, 85.5, now);
        given.set(2, -33.8688197, now);
    };
    give(kStart);
    wire.run_until(kStart + 2s);
    ASSERT_EQ(receiver.found().size(), kSensors);

    std::minstd_rand random(20);
    int faulted = 0;
    bool spoiled_this_slot = false;
    wire.on_frame([&](std::size_t from, Bytes& bytes, Instant at) {
        spoiled_this_slot = spoiled_this_slot && from != 0;
        if (spoiled_this_slot || random() % 100 != 0) {
            return;
        }
        spoiled_this_slot = true;
        ++faulted;
        const auto fault = static_cast<Fault>(random() % static_cast<unsigned>(Fault::count));
        if (fault != Fault::stall) {
            spoil(bytes, fault, random);
        } else if (from == 0) {
            wire.stall(1, at + 400us + 1us * static_cast<int>(random() % 6000));
        }
    });
    const std::uint64_t requests_before = receiver.counts().requests;
    for (Instant until = wire.now(); until < kStart + 3600s; until += 100ms) {
        give(until);
        wire.run_until(until);
        ASSERT_EQ(receiver.found().size(), kSensors) << until.time_since_epoch() / 1s << " s";
        ASSERT_DOUBLE_EQ(*read.fresh(1, until), -1.23);
        ASSERT_DOUBLE_EQ(*read.fresh(3, until), 85.5);
        ASSERT_DOUBLE_EQ(*read.fresh(5, until), -33.8688197);
    }
    EXPECT_GT(receiver.counts().requests - requests_before, 465'000U);
    EXPECT_GT(faulted, 8000);
    EXPECT_LE(receiver.counts().misses, static_cast<std::uint64_t>(faulted));
    EXPECT_EQ(receiver.counts().lost_sensors, 0U);
    RecordProperty("faulted", faulted);
    RecordProperty("misses", static_cast<int>(receiver.counts().misses));
}

TEST(SensorBus, NeitherRoleAllocatesOnceItIsMade) {
    SensorRole role({.first_address = 1,
                     .sensors = {sensor("external_voltage", 0), sensor("rotation_speed", 1)}});
    ReceiverRole receiver(receiver_settings());
    ValueBoard given = board_of(2);
    ValueBoard read = board_of(2 * kMostSensors);
    given.set(0, 12, kStart);
    given.set(1, 9000, kStart);
    role.start(kStart);
    receiver.start(kStart);
    const HeapTrap trap;
    for (Instant slot = kStart; slot < kStart + 3s; slot = receiver.due()) {
        const auto asked = receiver.run(slot, read);
        if (asked.empty()) {
            continue;
        }
        receiver.written(slot, read);
        receiver.receive(asked, slot + 400us, read);
        role.receive(asked, slot + 400us, given);
        if (role.due() != kNever) {
            const Instant now = role.due();
            const auto said = role.run(now, given);
            role.written(now, given);
            receiver.receive(said, now + 600us, read);
            role.receive(said, now + 600us, given);
        }
    }
    EXPECT_EQ(trap.allocations(), 0U);
    EXPECT_EQ(receiver.found().size(), 2U);
}

}  // namespace
}  // namespace tribus::test::sensor_bus_test
