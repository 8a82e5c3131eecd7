#include "pipelines/stations/stations.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "tests/unit/pipelines/engine/engine_bench.h"

namespace tribus::test::serial::stations_test {
namespace {

constexpr Station kOutput{StationKind::output, 0};
constexpr Station kBus{StationKind::sensor_bus, 0};

TEST(Stations, APortTellsTheFirstOfAKind) {
    constexpr std::array<Station, 3> kOnPort{
        {{StationKind::output, 4}, {StationKind::input, 2}, {StationKind::input, 1}}};
    EXPECT_EQ(first_of(kOnPort, StationKind::input), 2U);
    EXPECT_EQ(first_of(kOnPort, StationKind::sensor_bus), std::nullopt);
}

TEST(Stations, InputsSensorBusesValuesAndRepliesWantBytes) {
    for (const auto kind : {StationKind::input, StationKind::sensor_bus, StationKind::value_message,
                            StationKind::replies}) {
        EXPECT_TRUE(wants_bytes(std::array{Station{kind, 0}}));
    }
    for (const auto kind : {StationKind::output, StationKind::dronecan_node}) {
        EXPECT_FALSE(wants_bytes(std::array{Station{kind, 0}}));
    }
}

/// A receiver and an SBUS output that is due every 10 ms, without values.
class StationsOfAPipeline : public testing::Test {
  protected:
    StationsOfAPipeline() { stations_.start(at(0ms)); }

    Engine engine_{list(ibus_input()), list(sbus_output({0})), {}, {}};
    Stations stations_{engine_, nullptr};
};

TEST_F(StationsOfAPipeline, AnOutputThatRanIsReadyUntilTheNextPoll) {
    const Instant next = stations_.poll(at(0ms));
    EXPECT_EQ(std::vector(stations_.ready().begin(), stations_.ready().end()),
              std::vector{kOutput});
    stations_.poll(next - 1ns);
    EXPECT_TRUE(stations_.ready().empty());
}

TEST_F(StationsOfAPipeline, WhatAnOutputSendsIsTakenOnce) {
    stations_.poll(at(0ms));
    EXPECT_EQ(stations_.take(kOutput, at(0ms)).bytes().size(), kSbusFrameLength);
    EXPECT_TRUE(stations_.take(kOutput, at(0ms)).empty());
}

TEST_F(StationsOfAPipeline, AnInputReceivesAndSendsNothing) {
    stations_.poll(at(0ms));
    EXPECT_TRUE(stations_.take(input_station(0), at(0ms)).empty());
    EXPECT_FALSE(sends(input_station(0)));
}

TEST_F(StationsOfAPipeline, EachOutcomeIsCountedAsWhatItIs) {
    using enum WriteStatus;
    stations_.poll(at(0ms));
    for (const WriteStatus status :
         {written, busy, busy, unavailable, unavailable, unavailable, lost, lost, lost, lost}) {
        stations_.handed_over(kOutput, status, at(0ms));
    }
    const OutputCounts& counts = engine_.outputs()[0].counts();
    EXPECT_EQ(counts.frames, 1U);
    EXPECT_EQ(counts.busy_drops, 2U);
    EXPECT_EQ(counts.unavailable_drops, 3U);
    EXPECT_EQ(counts.lost_drops, 4U);
}

TEST_F(StationsOfAPipeline, AFrameIsValidForThePeriodOfItsOutput) {
    EXPECT_EQ(stations_.valid_for(kOutput), 10ms);
}

TEST_F(StationsOfAPipeline, BytesAreOfUseForTheTimeoutOfAnInputAlsoBesideASensorBus) {
    const Duration timeout = engine_.inputs()[0].link().timeout();
    ASSERT_GT(timeout, 50ms);
    EXPECT_EQ(stations_.useful_for(std::array{input_station(0)}), timeout);
    EXPECT_EQ(stations_.useful_for(std::array{input_station(0), kBus}), timeout);
}

TEST_F(StationsOfAPipeline, BytesOfASensorBusAloneAreOfUseFor50Milliseconds) {
    EXPECT_EQ(stations_.useful_for(std::array{kBus}), 50ms);
}

TEST_F(StationsOfAPipeline, AnInputCountsTheLossOfItsDevice) {
    stations_.device_lost(input_station(0));
    EXPECT_EQ(engine_.inputs()[0].counts().device_losses, 1U);
}

TEST_F(StationsOfAPipeline, AnOutputWithoutItsDeviceCannotSend) {
    stations_.device_lost(kOutput);
    EXPECT_EQ(engine_.outputs()[0].stage(), OutputStage::cannot_send);
    stations_.set_device_present(kOutput, true);
    EXPECT_EQ(engine_.outputs()[0].stage(), OutputStage::failsafe);
}

TEST_F(StationsOfAPipeline, AnAnswerOnASensorBusIsValidForLessThanHalfASlot) {
    // A slot has 7.7 ms (docs/protocols/ibus.md).
    EXPECT_EQ(stations_.valid_for(kBus), 3500us);
}

/// Tells the number of bytes since it was reset.
class ByteCounter final : public ByteValueReader {
  public:
    std::span<const Value> values() const override { return {}; }
    std::span<const NamedCount> rejected() const override { return {}; }
    std::uint64_t skipped_bytes() const override { return 0; }
    void damaged_byte() override {}
    void reset() override { count_ = 0; }
    bool next(std::span<const std::uint8_t>& bytes, Instant /*received*/,
              std::span<ValueReading> readings) override {
        count_ += static_cast<int>(bytes.size());
        const bool some = !bytes.empty();
        bytes = {};
        readings[0] = {.state = ValueReading::State::number, .number = 1.0 * count_};
        return some;
    }

  private:
    int count_ = 0;
};

TEST(StationOfAMessage, ForgetsItsUnfinishedMessageWhereItsDeviceIsLost) {
    ValueEngineSettings settings;
    settings.values = {{"battery.voltage", "V", 500ms}};
    settings.messages.push_back({std::make_unique<ByteCounter>(), {0}});
    ValueEngine values(std::move(settings));
    Engine engine({}, {}, {}, {});
    Stations stations(engine, &values);
    stations.start(at(0ms));
    constexpr Station kMessage{StationKind::value_message, 0};
    constexpr std::array<std::uint8_t, 3> kBytes{1, 2, 3};
    stations.receive(kMessage, kBytes, at(1ms));
    EXPECT_EQ(values.board().fresh(0, at(1ms)), 3);
    stations.device_lost(kMessage);
    stations.receive(kMessage, kBytes, at(2ms));
    EXPECT_EQ(values.board().fresh(0, at(2ms)), 3);
}

TEST(StationOfADroneCanNode, SendsWhatTheNodeSays) {
    dronecan::NodeSettings node;
    node.id = 42;
    Engine engine({}, {}, {}, {node});
    Stations stations(engine, nullptr);
    stations.start(at(0ms));
    stations.poll(at(2s));
    EXPECT_FALSE(stations.take({StationKind::dronecan_node, 0}, at(2s)).empty());
    EXPECT_FALSE(stations.uses_fd({StationKind::dronecan_node, 0}));
}

}  // namespace
}  // namespace tribus::test::serial::stations_test
