#include "pipelines/values/value_engine.h"

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "tests/unit/pipelines/engine/engine_bench.h"

namespace tribus::test::serial::value_engine_test {
namespace {

/// A receiver and a servo output, with values for channel 1 and for the state of each. A constant
/// and a fact of the machine are values too.
class ValuesOfAPipeline : public testing::Test {
  protected:
    ValuesOfAPipeline() {
        ValueEngineSettings settings;
        for (const char* name : {"in.1", "out.1", "in.good", "cells", "load"}) {
            settings.values.push_back({name, "", 500ms});
        }
        settings.channels = {{.value = 0, .of_output = false, .index = 0, .channel = 0},
                             {.value = 1, .of_output = true, .index = 0, .channel = 0}};
        settings.health = {{.value = 2, .index = 0, .fact = InputFact::good}};
        settings.constants = {{.value = 3, .number = 6}};
        settings.values[3].lasts = kForever;
        settings.machine = {4};
        values_.emplace(std::move(settings));
        values_->start(at(0ms));
    }
    /// Lets time pass until then, with frames every 10 ms or without frames.
    void fly(Duration until, bool frames = true) {
        for (; now_ < until; now_ += 10ms) {
            if (frames) {
                bench_.ibus(0, at(now_), us(1234));
            }
            bench_.loop().run_until(at(now_));
            values_->poll(bench_.engine(), at(now_));
        }
    }
    std::optional<double> value(std::size_t index) {
        return values_->board().fresh(index, at(now_));
    }

    Bench bench_{list(ibus_input()),
                 list(sbus_output({0}, {.action = FailsafeAction::silence, .recover = 0ms}))};
    std::optional<ValueEngine> values_;
    Duration now_ = 10ms;
};

TEST_F(ValuesOfAPipeline, TellChannelsAsPulses) {
    fly(1s);
    EXPECT_EQ(value(0), 1234);
    EXPECT_EQ(value(1), 1234);
    EXPECT_EQ(value(2), 1);
}

TEST_F(ValuesOfAPipeline, HaveNoChannelOfAnInputThatIsLostNorOfASilentOutput) {
    fly(1s);
    fly(3s, false);
    EXPECT_EQ(value(0), std::nullopt);
    EXPECT_EQ(value(1), std::nullopt);
    EXPECT_EQ(value(2), 0);
}

TEST_F(ValuesOfAPipeline, KeepConstantsAndTellTheMachineWhileItTells) {
    fly(10s, false);
    EXPECT_EQ(value(3), 6);
    EXPECT_EQ(value(4), std::nullopt);
    values_->set_machine(0, 42, at(now_));
    EXPECT_EQ(value(4), 42);
    values_->set_machine(0, 42, at(now_ - 501ms));
    EXPECT_EQ(value(4), std::nullopt) << "told so long ago: whoever tells it hangs";
    values_->set_machine(0, std::nullopt, at(now_));
    EXPECT_EQ(value(4), std::nullopt);
}

/// Publishes a number for each frame with data, and "not available" for other frames.
class Gauge final : public CanValueReader {
  public:
    std::span<const CanIdMatch> wanted() const override { return {}; }
    bool uses_fd() const override { return false; }
    std::span<const Value> values() const override { return {}; }
    std::optional<Instant> take(const CanFrame& frame, Instant when,
                                std::span<ValueReading> readings) override {
        readings[0] = {.state = frame.length > 0 ? ValueReading::State::number
                                                 : ValueReading::State::not_available,
                       .number = 12.5};
        return when;
    }
    std::span<const NamedCount> rejected() const override { return {}; }
};

TEST(ValueOfAMessage, IsGoneAsSoonAsTheMessageSaysThatThereIsNone) {
    ValueEngineSettings settings;
    settings.values = {{"battery.voltage", "V", 500ms}};
    settings.messages.push_back({std::make_unique<Gauge>(), {0}});
    ValueEngine values(std::move(settings));
    values.start(at(0ms));
    values.receive(0, CanFrame{.length = 1}, at(10ms));
    EXPECT_EQ(values.board().fresh(0, at(20ms)), 12.5);
    values.receive(0, CanFrame{.length = 0}, at(20ms));
    EXPECT_FALSE(values.board().fresh(0, at(30ms)));
}

/// Publishes the number of the frame.
class Counting final : public CanValueReader {
  public:
    std::span<const CanIdMatch> wanted() const override { return {}; }
    bool uses_fd() const override { return false; }
    std::span<const Value> values() const override { return {}; }
    std::optional<Instant> take(const CanFrame& /*frame*/, Instant when,
                                std::span<ValueReading> readings) override {
        readings[0] = {.state = ValueReading::State::number, .number = ++frames_};
        return when;
    }
    std::span<const NamedCount> rejected() const override { return {}; }

  private:
    double frames_ = 0;
};

/// The reader may be in the middle of a transfer, and it knows the next counter.
TEST(ValueOfAMessage, IsReadOnOverAReloadByTheReaderThatTheMessageHas) {
    const auto three_messages = [] {
        ValueEngineSettings settings;
        settings.values = {{"first", "V", 500ms}, {"second", "V", 500ms}, {"third", "V", 500ms}};
        for (std::size_t i = 0; i < settings.values.size(); ++i) {
            settings.messages.push_back({std::make_unique<Counting>(), {i}});
        }
        return settings;
    };
    ValueEngine before(three_messages());
    before.start(at(0ms));
    before.receive(0, CanFrame{}, at(10ms));
    before.receive(1, CanFrame{}, at(10ms));
    before.receive(1, CanFrame{}, at(20ms));
    ValueEngine next(three_messages());
    next.start(at(20ms));
    next.continue_from(before, {.values = {1, {}, {}}, .buses = {}, .messages = {1, {}, 0}}, {});
    EXPECT_EQ(next.board().fresh(0, at(30ms)), 2);
    EXPECT_EQ(next.board().fresh(1, at(30ms)), std::nullopt);
    next.receive(0, CanFrame{}, at(40ms));
    next.receive(1, CanFrame{}, at(40ms));
    EXPECT_EQ(next.board().fresh(0, at(40ms)), 3);
    next.receive(2, CanFrame{}, at(40ms));
    EXPECT_EQ(next.board().fresh(1, at(40ms)), 1);
    EXPECT_EQ(next.board().fresh(2, at(40ms)), 2);
}

}  // namespace
}  // namespace tribus::test::serial::value_engine_test
