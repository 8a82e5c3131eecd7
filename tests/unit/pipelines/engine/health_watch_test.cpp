#include "pipelines/engine/health_watch.h"

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/pipelines/engine/engine_bench.h"

namespace tribus::test::serial::health_watch_test {
namespace {

std::vector<InputSettings> one_input() {
    std::vector<InputSettings> inputs;
    inputs.push_back(ibus_input());
    return inputs;
}
std::vector<OutputSettings> one_output() {
    std::vector<OutputSettings> outputs;
    outputs.push_back(sbus_output({0}));
    return outputs;
}

/// A receiver that sends every 10 ms for two seconds. One of `every` frames is missing.
class HealthOfAReceiver : public testing::Test {
  protected:
    void fly(Duration until, int every = 0) {
        for (; now_ < until; now_ += 10ms) {
            if (++frame_ % 10 == 0) {
                watch_.look(bench_.engine(), at(now_));
            }
            if (every == 0 || frame_ % every != 0) {
                bench_.ibus(0, at(now_), us(1500));
            }
        }
        watch_.look(bench_.engine(), at(now_));
        bench_.engine().look(0, at(now_));
    }
    double input(InputFact fact) {
        return watch_.number(bench_.engine(), 0, fact, at(now_)).value_or(-1);
    }

    Bench bench_{one_input(), one_output()};
    HealthWatch watch_{1, 1};
    Duration now_ = 10ms;
    int frame_ = 0;
};

TEST_F(HealthOfAReceiver, HasNothingToSayOfAnInputThatWasNeverSeen) {
    watch_.look(bench_.engine(), at(100ms));
    watch_.look(bench_.engine(), at(200ms));
    bench_.engine().look(0, at(200ms));
    EXPECT_EQ(watch_.number(bench_.engine(), 0, InputFact::age, at(200ms)), std::nullopt);
    EXPECT_EQ(watch_.number(bench_.engine(), 0, InputFact::loss_ratio, at(200ms)), std::nullopt);
    EXPECT_EQ(watch_.number(bench_.engine(), 0, InputFact::frame_rate, at(200ms)), 0);
    EXPECT_EQ(watch_.number(bench_.engine(), 0, InputFact::good, at(200ms)), 0);
    EXPECT_EQ(watch_.number(bench_.engine(), 0, InputFact::cause, at(200ms)),
              static_cast<double>(LinkCause::never_seen));
}

TEST_F(HealthOfAReceiver, TellsTheFrameRateOfTheLatestSecond) {
    fly(3s);
    EXPECT_NEAR(input(InputFact::frame_rate), 100, 1);
    EXPECT_NEAR(input(InputFact::loss_ratio), 0, 0.5);
    EXPECT_EQ(input(InputFact::good), 1);
    EXPECT_EQ(input(InputFact::cause), 0);
    EXPECT_NEAR(input(InputFact::age), 10, 0.001);
}

TEST_F(HealthOfAReceiver, TellsTheShareOfFramesThatDidNotCome) {
    fly(3s);
    fly(6s, 4);
    EXPECT_NEAR(input(InputFact::loss_ratio), 25, 2);
    EXPECT_NEAR(input(InputFact::frame_rate), 75, 2);
}

TEST(HealthOfAnSbusReceiver, CountsFramesThatItMarksAsLostOrAsFailsafeAmongThoseThatDidNotCome) {
    std::vector<InputSettings> inputs;
    inputs.push_back(sbus_input());
    Bench bench(std::move(inputs), one_output());
    HealthWatch watch{1, 1};
    for (int frame = 1; frame <= 300; ++frame) {
        const Instant now = at(frame * 10ms);
        bench.sbus(0, now, us(1500), frame % 10 == 0, frame % 5 == 1);
        if (frame % 10 == 0) {
            watch.look(bench.engine(), now);
        }
    }
    bench.engine().look(0, at(3s));
    EXPECT_NEAR(watch.number(bench.engine(), 0, InputFact::loss_ratio, at(3s)).value_or(-1), 30, 1)
        << "of ten frames one is marked as lost and two as failsafe";
}

TEST_F(HealthOfAReceiver, TellsThatAllIsLostWhenNothingComesAnyMore) {
    fly(3s);
    fly(5s, 1);
    EXPECT_EQ(input(InputFact::loss_ratio), 100);
    EXPECT_EQ(input(InputFact::good), 0);
    EXPECT_EQ(input(InputFact::cause), static_cast<double>(LinkCause::wire_silent));
    EXPECT_NEAR(input(InputFact::age), 2010, 0.001);
}

TEST_F(HealthOfAReceiver, GoesOnInAnotherEngineWhereTheReceiverHasAnotherPlace) {
    fly(3s);
    auto two = one_input();
    two.push_back(ibus_input());
    Engine next(std::move(two), one_output());
    const EngineCarry carry{.inputs = {{}, {.from = 0}}, .outputs = {{.from = 0}}, .nodes = {}};
    next.start(at(now_));
    next.continue_from(bench_.engine(), carry, at(now_));
    HealthWatch watch{2, 1};
    watch.continue_from(watch_, carry);
    watch.look(next, at(now_ + 100ms));
    EXPECT_NEAR(watch.number(next, 1, InputFact::frame_rate, at(now_)).value_or(-1), 89, 1)
        << "none came in 100 of the 900 ms";
    EXPECT_EQ(watch.number(next, 0, InputFact::frame_rate, at(now_)), 0);
    EXPECT_NEAR(watch.number(next, 0, OutputFact::frame_rate, at(now_)).value_or(-1), 89, 1);
}

TEST_F(HealthOfAReceiver, TellsWhetherAnOutputIsInFailsafe) {
    EXPECT_EQ(watch_.number(bench_.engine(), 0, OutputFact::failsafe, at(now_)), 1);
    fly(3s);
    EXPECT_EQ(watch_.number(bench_.engine(), 0, OutputFact::failsafe, at(now_)), 0);
    EXPECT_EQ(watch_.number(bench_.engine(), 0, OutputFact::holding, at(now_)), 0);
}

/// Each frame's first byte is the link quality that its sender reports.
class QualityDecoder final : public CanDecoder {
  public:
    std::span<const CanIdMatch> wanted() const override { return ids_; }
    std::optional<ChannelFrame> next(const CanFrame& frame, Instant received) override {
        ChannelFrame snapshot;
        snapshot.received = received;
        snapshot.link_quality = frame.data[0];
        return snapshot;
    }
    std::span<const NamedCount> rejected() const override { return {}; }

  private:
    std::array<CanIdMatch, 1> ids_{{{.id = 1, .mask = kMostExtendedId, .extended = false}}};
};

TEST(HealthOfASender, TellsTheLinkQualityOfItsLatestFrameUntilThatIsASecondOld) {
    std::vector<InputSettings> inputs(1);
    inputs[0].decoder = std::make_unique<QualityDecoder>();
    Engine engine(std::move(inputs), one_output());
    const HealthWatch watch{1, 1};
    const auto quality = [&](Duration now) {
        return watch.number(engine, 0, InputFact::link_quality, at(now));
    };
    EXPECT_EQ(quality(1s), std::nullopt) << "no frame yet";
    CanFrame frame;
    frame.id = 1;
    frame.length = 1;
    frame.data[0] = 73;
    engine.receive(0, frame, at(1s));
    EXPECT_EQ(quality(1s), 73);
    EXPECT_EQ(quality(2s), 73);
    EXPECT_EQ(quality(2s + 1ns), std::nullopt) << "too old";
    frame.data[0] = kNoLinkQuality;
    engine.receive(0, frame, at(3s));
    EXPECT_EQ(quality(3s), std::nullopt) << "its sender does not know it";
}

}  // namespace
}  // namespace tribus::test::serial::health_watch_test
