#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "pipelines/engine/engine.h"
#include "pipelines/engine/health_watch.h"
#include "pipelines/virtual_time/virtual_loop.h"
#include "tests/reference/plain_crsf.h"
#include "transports/codecs/crsf/crsf.h"

/// From a CRSF receiver to a CRSF output: what kind of loss it was, and what the output says. The
/// plain form of the codec is the far end on both sides.
namespace tribus::test::engine_crsf_test {
namespace {

using namespace std::chrono_literals;
using reference::plain_crsf;
using reference::plain_crsf_packed;
using reference::PlainCrsfFrame;

constexpr std::uint8_t kChannels = 0x16;
constexpr std::uint8_t kStatistics = 0x14;

Instant at(Duration since_start) {
    return Instant(1h) + since_start;
}

InputSettings radio() {
    InputSettings input;
    input.name = "radio";
    input.decoder = std::make_unique<CrsfDecoder>();
    input.supervision.timeout = CrsfDecoder::kNoChannelsAfter;
    return input;
}

OutputSettings flight_controller() {
    OutputSettings output;
    output.name = "fc";
    output.encoder = std::make_unique<CrsfEncoder>();
    output.schedule.period = 5ms;
    output.selection.inputs = {0};
    output.failsafe.action = FailsafeAction::silence;
    return output;
}

template <class Only>
std::vector<Only> list(Only only) {
    std::vector<Only> all;
    all.push_back(std::move(only));
    return all;
}

class CrsfBench : public testing::Test, public StationObserver {
  protected:
    struct Heard {
        Instant when;
        PlainCrsfFrame frame;
    };

    CrsfBench()
        : engine_(list(radio()), list(flight_controller())), loop_(engine_, *this, at(0s)) {}

    void wrote(Station /*station*/, Instant when, const Transmission& sent) override {
        for (auto& frame : reference::plain_crsf_frames(sent.bytes())) {
            heard_.push_back({when, std::move(frame)});
        }
    }

    /// The receiver sends channels at 150 Hz and statistics at 10 Hz, or one of the two.
    void receiver(Duration until, bool channels, std::optional<std::uint8_t> link_quality) {
        for (; now_ < until; now_ += 1ms) {
            loop_.run_until(at(now_));
            if (channels && now_ % 7ms == 0ms) {
                send(plain_crsf(0xC8, kChannels, plain_crsf_packed({})));
            }
            if (link_quality && now_ % 100ms == 0ms) {
                send(plain_crsf(0xC8, kStatistics, {60, 70, *link_quality, 9, 1, 4, 3, 0, 0, 0}));
            }
        }
        loop_.run_until(at(now_));
        engine_.look(0, at(now_));
    }
    LinkCause cause() { return engine_.inputs()[0].state().cause; }
    /// What the output sent of a type from `since` on.
    std::vector<Heard> heard(std::uint8_t type, Duration since) const {
        std::vector<Heard> some;
        for (const Heard& one : heard_) {
            if (one.frame.type == type && one.when >= at(since)) {
                some.push_back(one);
            }
        }
        return some;
    }
    std::optional<double> fact(InputFact fact) const {
        return HealthWatch(1, 1).number(engine_, 0, fact, at(now_));
    }

    Duration now_ = 0s;
    Engine engine_;
    VirtualLoop loop_;
    std::vector<Heard> heard_;

  private:
    void send(const std::vector<std::uint8_t>& bytes) {
        loop_.receive(input_station(0), bytes, at(now_));
    }
};

TEST_F(CrsfBench, ChannelsPassAndSoDoesTheLinkQuality) {
    receiver(1s, true, 87);
    EXPECT_EQ(cause(), LinkCause::good);
    EXPECT_GE(heard(kChannels, 0s).size(), 135U);
    const auto statistics = heard(kStatistics, 500ms);
    ASSERT_GE(statistics.size(), 4U);
    EXPECT_LE(statistics.size(), 6U);
    EXPECT_EQ(statistics[0].frame.payload[2], 87);
}

TEST_F(CrsfBench, StatisticsAreFacts) {
    receiver(1s, true, 87);
    EXPECT_EQ(fact(InputFact::link_quality), 87);
    EXPECT_EQ(fact(InputFact::rssi), -70);
    EXPECT_EQ(fact(InputFact::snr), 9);
    EXPECT_EQ(fact(InputFact::power), 100);
    EXPECT_EQ(fact(InputFact::mode), 4);
}

TEST_F(CrsfBench, StatisticsThatStopAreNoFactsAfterASecond) {
    receiver(1s, true, 87);
    receiver(2100ms, true, std::nullopt);
    EXPECT_EQ(fact(InputFact::rssi), std::nullopt);
    EXPECT_EQ(fact(InputFact::link_quality), std::nullopt);
}

TEST_F(CrsfBench, ALinkOfQualityZeroIsARadioThatIsLostBeforeTheTimeout) {
    receiver(1s, true, 87);
    receiver(1150ms, false, 0);
    EXPECT_EQ(cause(), LinkCause::radio_lost);
}

TEST_F(CrsfBench, ALinkWithoutChannelsIsChannelsMissing) {
    receiver(1s, true, 87);
    receiver(1350ms, false, 87);
    EXPECT_EQ(cause(), LinkCause::channels_missing);
}

TEST_F(CrsfBench, NothingAtAllIsAWireThatIsSilent) {
    receiver(1s, true, 87);
    receiver(1300ms, false, std::nullopt);
    EXPECT_EQ(cause(), LinkCause::wire_silent);
}

TEST_F(CrsfBench, ASilentOutputSendsNoChannelsAndSaysThatThereIsNoLink) {
    receiver(1s, true, 87);
    receiver(2s, false, std::nullopt);
    const std::uint64_t frames = engine_.outputs()[0].counts().frames;
    receiver(4s, false, std::nullopt);
    EXPECT_TRUE(heard(kChannels, 2s).empty());
    const auto statistics = heard(kStatistics, 2s);
    ASSERT_GE(statistics.size(), 18U);
    EXPECT_LE(statistics.size(), 21U);
    for (const Heard& one : statistics) {
        EXPECT_EQ(one.frame.payload[2], 0);
    }
    EXPECT_EQ(engine_.outputs()[0].counts().frames, frames) << "they are no frames of channels";
}

TEST_F(CrsfBench, ControlReturnsWithTheChannels) {
    receiver(1s, true, 87);
    receiver(2s, false, 0);
    receiver(3s, true, 87);
    EXPECT_EQ(cause(), LinkCause::good);
    EXPECT_FALSE(heard(kChannels, 2700ms).empty());
    EXPECT_EQ(heard(kStatistics, 2700ms).at(1).frame.payload[2], 87);
}

}  // namespace
}  // namespace tribus::test::engine_crsf_test
