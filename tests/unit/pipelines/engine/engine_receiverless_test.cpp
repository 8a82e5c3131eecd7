#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "pipelines/engine/engine.h"
#include "pipelines/virtual_time/virtual_loop.h"
#include "tests/unit/pipelines/engine/engine_bench.h"
#include "transports/codecs/authenticated/broadcast_ends.h"

/// Outputs that may send no channels, whatever their inputs say.
namespace tribus::test::serial::engine_receiverless_test {
namespace {

authenticated::FdLink boat() {
    return {.keys = {.name = "boat", .secret = {1}}, .sender_id = 0x305, .receiver_id = 0x300};
}

OutputSettings boat_output() {
    OutputSettings output = sbus_output({0});
    output.encoder = std::make_unique<authenticated::FdEncoder>(boat());
    return output;
}

/// An i.Bus receiver that always sends, and a box on the bus that answers when a test wants it.
class Receiverless : public testing::Test, StationObserver {
  protected:
    Receiverless() { run(0ms, 1000ms); }

    void run(Duration from, Duration until) {
        IbusEncoder encoder(14);
        std::array<std::uint8_t, kLongestSerialFrame> wire{};
        const std::size_t length = encoder.write(ChannelFrame{}, wire, Instant{});
        for (Duration now = from; now < until; now += 7ms) {
            loop_.receive(input_station(0), std::span(wire).first(length), at(now));
        }
    }
    void challenge(Duration now) {
        const auto answer = receiver_.answer(at(now));
        ASSERT_EQ(answer.size(), 1U);
        loop_.receive({StationKind::replies, 0}, answer.front(), at(now));
    }
    OutputState state(Duration now) const { return engine_.outputs()[0].state(at(now)); }
    std::uint64_t counted() const { return engine_.outputs()[0].counts().frames; }

    authenticated::FdDecoder receiver_{boat()};
    std::vector<CanFrame> sent_;
    std::size_t published_ = 0;
    Engine engine_{list(ibus_input()), list(boat_output())};
    VirtualLoop loop_{engine_, *this, at(0ms)};

  private:
    void wrote(Station /*station*/, Instant now, const Transmission& sent) override {
        for (const CanFrame& frame : sent.can_frames()) {
            sent_.push_back(frame);
            published_ += receiver_.next(frame, now) ? 1U : 0U;
        }
    }
};

TEST_F(Receiverless, SaysSoAndCountsNoFrame) {
    EXPECT_EQ(state(1000ms).stage, OutputStage::cannot_send);
    EXPECT_EQ(state(1000ms).obstacle, SendObstacle::receiver);
    EXPECT_EQ(counted(), 0U);
    ASSERT_FALSE(sent_.empty());
    for (const CanFrame& frame : sent_) {
        EXPECT_EQ(frame.length, 24U) << "hellos, and no channels";
    }
}

TEST_F(Receiverless, SendsAsSoonAsTheReceiverAnswers) {
    challenge(1000ms);
    run(1001ms, 1100ms);
    EXPECT_EQ(state(1100ms).stage, OutputStage::control);
    EXPECT_GT(published_, 0U);
    EXPECT_EQ(counted(), published_);
}

TEST_F(Receiverless, SaysSoAgainWhenChallengesStop) {
    challenge(1000ms);
    run(1001ms, 1600ms);
    EXPECT_EQ(state(1600ms).stage, OutputStage::control);
    run(1600ms, 1700ms);
    EXPECT_EQ(state(1700ms).obstacle, SendObstacle::receiver);
}

/// An output whose receivers do not answer.
class WithoutEpoch : public testing::Test, StationObserver {
  protected:
    WithoutEpoch() {
        IbusEncoder encoder(14);
        std::array<std::uint8_t, kLongestSerialFrame> wire{};
        const std::size_t length = encoder.write(ChannelFrame{}, wire, Instant{});
        for (Duration now = 0ms; now < 1000ms; now += 7ms) {
            loop_.receive(input_station(0), std::span(wire).first(length), at(now));
        }
    }
    static OutputSettings output() {
        OutputSettings output = sbus_output({0});
        authenticated::FdLink link = boat();
        link.keys.epoch = "/not/read/by/codecs";
        output.encoder = authenticated::make_fd_encoder(link);
        return output;
    }

    Engine engine_{list(ibus_input()), list(output())};
    VirtualLoop loop_{engine_, *this, at(0ms)};
    std::size_t frames_ = 0;

  private:
    void wrote(Station /*station*/, Instant /*now*/, const Transmission& sent) override {
        frames_ += sent.can_frames().size();
    }
};

TEST_F(WithoutEpoch, SendsNothingAndSaysWhy) {
    EXPECT_EQ(engine_.outputs()[0].state(at(1000ms)).stage, OutputStage::cannot_send);
    EXPECT_EQ(engine_.outputs()[0].state(at(1000ms)).obstacle, SendObstacle::epoch);
    EXPECT_EQ(engine_.outputs()[0].counts().frames, 0U);
    EXPECT_EQ(frames_, 0U);
}

}  // namespace
}  // namespace tribus::test::serial::engine_receiverless_test
