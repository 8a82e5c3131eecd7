#include "app/doctor/listening/line_judge.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <tuple>
#include <vector>

#include "tests/captures/recordings.h"
#include "tests/support/recorded_lines.h"

/// The judge of a line at recorded receivers, and at their twins.
namespace tribus::doctor::recorded_line_judge_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using namespace test::heard_by;
using test::Capture;
using test::expect_period;
using test::heard_of;
using test::HeardBy;
using test::on_a_wire;
using test::SentAs;

const std::vector<std::string> kIbus14{"ibus_servo14_ia6b_2sensors.timed.txt",
                                       "ibus_servo14_ia6b_rpmsensor.timed.txt"};
const std::string kIbus18 = "ibus_servo18_afhds3.timed.txt";
const std::vector<std::string> kSensorBuses{"ibus_sensor_ia6b_2sensors.timed.txt",
                                            "ibus_sensor_ia6b_rpmsensor.timed.txt",
                                            "ibus_sensor_ia6b_tap_between.timed.txt"};
const std::string kSbus2 = "sbus2_r7008SB.timed.txt";

LineStory story_of(const Recording& recording, const SentAs& as, const HeardBy& by = {}) {
    return judge_line(heard_of(on_a_wire(recording, as), by));
}

/// A recording or its twin, on a wire.
class RecordedLine : public testing::TestWithParam<Capture> {
  protected:
    static Recording recorded(const std::string& file) {
        return test::recording_of(file, GetParam());
    }
};

INSTANTIATE_TEST_SUITE_P(Both, RecordedLine, testing::ValuesIn(test::captures()),
                         [](const auto& test) { return test::capture_name(test.param); });

class RecordedLineAtAPort : public testing::TestWithParam<std::tuple<HeardBy, Capture>> {
  protected:
    static LineStory story_of(const std::string& file, const SentAs& as) {
        const auto& [port, capture] = GetParam();
        return recorded_line_judge_test::story_of(test::recording_of(file, capture), as, port);
    }
};

INSTANTIATE_TEST_SUITE_P(Usual, RecordedLineAtAPort,
                         testing::Combine(testing::Values(kEachByteWaitingForIdle, kLumpsAtOnce),
                                          testing::ValuesIn(test::captures())));
INSTANTIATE_TEST_SUITE_P(Further, RecordedLineAtAPort,
                         testing::Combine(testing::Values(kLumpsWaitingForIdle, kEachByteAtOnce),
                                          testing::ValuesIn(test::captures())));

SentAs ibus_sent(bool inverted = false) {
    return {.sender = {.line = kIbusLine, .inverted = inverted}, .pause_bits = 1};
}

TEST_P(RecordedLineAtAPort, KnowsIbusOf14Channels) {
    for (const std::string& name : kIbus14) {
        const LineStory story = story_of(name, ibus_sent());
        EXPECT_EQ(story.sound, LineSound::frames);
        EXPECT_EQ(story.protocol, "ibus");
        EXPECT_EQ(story.channels, 14U);
        EXPECT_EQ(story.line, kIbusLine);
        expect_period(story, microseconds(7701));
    }
}

TEST_P(RecordedLineAtAPort, KnowsIbusOf18Channels) {
    const LineStory story = story_of(kIbus18, ibus_sent());
    EXPECT_EQ(story.sound, LineSound::frames);
    EXPECT_EQ(story.protocol, "ibus");
    EXPECT_EQ(story.channels, 18U);
    expect_period(story, microseconds(4000));
}

TEST_P(RecordedLineAtAPort, KnowsSbus2AndFutabasScale) {
    const LineStory story = story_of(kSbus2, {.sender = {.line = kSbusLine}});
    EXPECT_EQ(story.sound, LineSound::frames);
    EXPECT_EQ(story.protocol, "sbus");
    EXPECT_EQ(story.line, kSbusLine);
    EXPECT_TRUE(story.sbus2);
    EXPECT_EQ(story.scale.name, "futaba");
    expect_period(story, milliseconds(15));
}

TEST_P(RecordedLineAtAPort, KnowsFastSbus) {
    const LineStory story = story_of(kSbus2, {.sender = {.line = kFastSbusLine}});
    EXPECT_EQ(story.sound, LineSound::frames);
    EXPECT_EQ(story.protocol, "sbus");
    EXPECT_EQ(story.line, kFastSbusLine);
}

TEST_P(RecordedLineAtAPort, KnowsTheSensorBus) {
    for (const std::string& name : kSensorBuses) {
        const LineStory story = story_of(name, ibus_sent());
        EXPECT_EQ(story.sound, LineSound::frames) << name;
        EXPECT_EQ(story.protocol, "ibus-sensor") << name;
        EXPECT_GT(story.requests, 40U) << name;
        EXPECT_GT(story.replies, 15U) << name;
        expect_period(story, microseconds(7701));
    }
}

TEST_P(RecordedLineAtAPort, KnowsInvertedIbus) {
    for (const std::string& name : {kIbus14[0], kIbus14[1], kIbus18}) {
        const LineStory story = story_of(name, ibus_sent(true));
        EXPECT_EQ(story.sound, LineSound::inverted) << name;
        EXPECT_EQ(story.protocol, "ibus") << name;
        expect_period(story, name == kIbus18 ? microseconds(4000) : microseconds(7701));
    }
}

TEST_P(RecordedLineAtAPort, KnowsInvertedIbusOfSendersThatMakeNoPause) {
    const LineStory story = story_of(kIbus14[0], {.sender = {.line = kIbusLine, .inverted = true}});
    EXPECT_EQ(story.sound, LineSound::inverted);
    EXPECT_EQ(story.protocol, "ibus");
}

TEST_P(RecordedLineAtAPort, KnowsInvertedSbus) {
    for (const LineSettings& line : {kSbusLine, kFastSbusLine}) {
        const LineStory story = story_of(kSbus2, {.sender = {.line = line, .inverted = true}});
        EXPECT_EQ(story.sound, LineSound::inverted);
        EXPECT_EQ(story.protocol, "sbus");
        EXPECT_EQ(story.line, line);
        expect_period(story, milliseconds(15));
    }
}

TEST_P(RecordedLineAtAPort, KnowsAnInvertedSensorBus) {
    const LineStory story = story_of(kSensorBuses[0], ibus_sent(true));
    EXPECT_EQ(story.sound, LineSound::inverted);
    EXPECT_EQ(story.protocol, "ibus-sensor");
}

TEST_P(RecordedLineAtAPort, KnowsSbusWithoutParity) {
    for (const std::uint8_t stop_bits : {std::uint8_t{1}, std::uint8_t{2}}) {
        const LineSettings line{.baud = 100'000, .stop_bits = stop_bits};
        const LineStory story = story_of(kSbus2, {.sender = {.line = line}});
        EXPECT_EQ(story.sound, LineSound::wrong_parity);
        EXPECT_EQ(story.protocol, "sbus");
    }
}

TEST_P(RecordedLineAtAPort, KnowsSbusWithOddParity) {
    const LineStory story = story_of(kSbus2, {.sender = {.line = kSbusLine, .odd_parity = true}});
    EXPECT_EQ(story.sound, LineSound::wrong_parity);
    EXPECT_EQ(story.protocol, "sbus");
}

TEST_P(RecordedLine, KnowsIbusWithParityWhereThePortGetsIntoStepAgain) {
    const LineSettings line{.baud = kUsualBaud, .parity = Parity::even};
    const LineStory story = story_of(
        recorded(kIbus14[0]), {.sender = {.line = line}, .pause_bits = 1}, kEachByteWaitingForIdle);
    EXPECT_EQ(story.sound, LineSound::wrong_parity);
    EXPECT_EQ(story.protocol, "ibus");
}

TEST_P(RecordedLineAtAPort, TakesAnotherRateForNothingKnown) {
    for (const std::uint32_t baud : {38'400U, 300'000U}) {
        const SentAs as{.sender = {.line = {.baud = baud}}, .pause_bits = 1};
        const LineStory story = story_of(kIbus14[0], as);
        EXPECT_EQ(story.sound, LineSound::unknown)
            << baud << " " << story.protocol << " at " << story.line.baud;
    }
    const LineSettings sbus{.baud = 115'200, .parity = Parity::even, .stop_bits = 2};
    const LineStory story = story_of(kSbus2, {.sender = {.line = sbus}});
    EXPECT_EQ(story.sound, LineSound::unknown) << story.protocol << " at " << story.line.baud;
}

/// As FTDI adapters report it: an error in a packet counts for all its bytes, and their values are
/// lost.
TEST_P(RecordedLine, HearsALowLineWhereThePortTellsBreaksOnly) {
    auto heard =
        heard_of(on_a_wire(recorded(kSbus2), {.sender = {.line = kSbusLine, .inverted = true}}),
                 kLumpsWaitingForIdle);
    for (Heard& one : heard) {
        for (Burst& burst : one.bursts) {
            std::ranges::fill(burst.bytes, std::uint8_t{0});
            burst.damaged.assign(burst.bytes.size(), true);
        }
    }
    const LineStory story = judge_line(heard);
    EXPECT_EQ(story.sound, LineSound::breaks);
}

/// Some adapters report neither parity nor framing errors.
TEST_P(RecordedLine, KnowsInvertedSbusWhereThePortTellsNoErrors) {
    auto heard =
        heard_of(on_a_wire(recorded(kSbus2), {.sender = {.line = kSbusLine, .inverted = true}}),
                 kLumpsWaitingForIdle);
    for (Heard& one : heard) {
        for (Burst& burst : one.bursts) {
            burst.damaged.assign(burst.bytes.size(), false);
        }
    }
    const LineStory story = judge_line(heard);
    EXPECT_EQ(story.sound, LineSound::inverted);
    EXPECT_EQ(story.protocol, "sbus");
}

TEST_P(RecordedLine, FindsRequestsOnAWireThatCarriesIbusToo) {
    Recording both = recorded(kIbus14[0]);
    const Recording sensors = recorded(kSensorBuses[0]);
    both.bursts.insert(both.bursts.end(), sensors.bursts.begin(), sensors.bursts.end());
    std::ranges::sort(both.bursts, {}, [](const Burst& burst) { return *burst.start; });
    const LineStory story = judge_line(heard_of(on_a_wire(both, ibus_sent()), {}));
    EXPECT_EQ(story.protocol, "ibus");
    EXPECT_GT(story.frames, 40U);
    EXPECT_GT(story.requests, 40U);
}

TEST_P(RecordedLine, CountsBytesOfNoFrame) {
    auto heard = heard_of(on_a_wire(recorded(kIbus18), ibus_sent()), {});
    heard[0].bursts[1000].damaged[0] = true;
    const LineStory story = judge_line(heard);
    EXPECT_EQ(story.sound, LineSound::frames);
    EXPECT_EQ(story.damaged, 1U);
    EXPECT_GE(story.lost_bytes, 31U);
    EXPECT_LE(story.lost_bytes, 64U);
}

}  // namespace
}  // namespace tribus::doctor::recorded_line_judge_test
