#include "app/doctor/listening/line_judge.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <variant>
#include <vector>

#include "config/schema/notation.h"
#include "tests/support/recorded_lines.h"
#include "tests/support/sbus_frames.h"
#include "tests/support/streams.h"
#include "transports/codecs/sbus/sbus.h"
#include "transports/links/serial/serial_medium.h"
#include "transports/registry/registry.h"

namespace tribus::doctor::line_judge_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using namespace test::heard_by;
using test::expect_period;
using test::heard_of;
using test::HeardBy;
using test::on_a_wire;
using test::Wire;

class LineJudgeAtAPort : public testing::TestWithParam<HeardBy> {};

/// The first tier has each property of a port, the second one has the other pairs.
INSTANTIATE_TEST_SUITE_P(Usual, LineJudgeAtAPort,
                         testing::Values(kEachByteWaitingForIdle, kLumpsAtOnce));
INSTANTIATE_TEST_SUITE_P(Further, LineJudgeAtAPort,
                         testing::Values(kLumpsWaitingForIdle, kEachByteAtOnce));

TEST(LineJudge, TakesNoByteForSilence) {
    const auto heard = heard_of(Wire({.line = kIbusLine}), {});
    const LineStory story = judge_line(heard);
    EXPECT_EQ(story.sound, LineSound::silence);
    EXPECT_EQ(story.listened, static_cast<int>(heard.size()) * test::kRecordedTime);
}

TEST_P(LineJudgeAtAPort, TakesNoiseForNothingKnown) {
    std::mt19937 random(7);
    Wire wire({.line = {.baud = 300'000}});
    for (int burst = 0; burst < 100; ++burst) {
        std::vector<std::uint8_t> bytes(1 + random() % 30);
        std::ranges::generate(bytes, [&] { return static_cast<std::uint8_t>(random()); });
        wire.send(microseconds(random() % 5000) + wire.end(), bytes);
    }
    EXPECT_EQ(judge_line(heard_of(wire, GetParam())).sound, LineSound::unknown);
}

TEST_P(LineJudgeAtAPort, KnowsSbusWith24ChannelsAsWhatItCannotRead) {
    const std::vector<std::uint8_t> frame = test::from_hex(test::kCentred24);
    Wire wire({.line = kSbusLine});
    for (int i = 0; i < 100; ++i) {
        wire.send(milliseconds(12) * i, frame);
    }
    const LineStory story = judge_line(heard_of(wire, GetParam()));
    EXPECT_EQ(story.sound, LineSound::sbus24);
    EXPECT_EQ(story.protocol, "");
}

TEST(LineJudge, KnowsIbus2AsWhatItCannotRead) {
    const std::string hex =
        "000f07f9770080990f00000000"
        "00e7000f07f96f00da990f0000000000"
        "35";
    std::vector<std::uint8_t> bytes;
    for (std::size_t at = 0; at + 1 < hex.size(); at += 2) {
        bytes.push_back(static_cast<std::uint8_t>(std::stoul(hex.substr(at, 2), nullptr, 16)));
    }
    Heard heard{.line = kIbusLine, .listened = std::chrono::seconds(1), .bursts = {}};
    for (int frame = 0; frame < 50; ++frame) {
        heard.bursts.push_back({.start = milliseconds(7 * frame), .bytes = bytes, .damaged = {}});
    }
    EXPECT_EQ(judge_line(std::span(&heard, 1)).sound, LineSound::ibus2);
}

LineStory sbus_story(std::uint16_t centre, std::uint16_t low, std::uint16_t high,
                     std::uint8_t flags = 0,
                     std::optional<std::uint16_t> channel_12 = std::nullopt) {
    Heard heard{.line = kSbusLine, .listened = std::chrono::seconds(1), .bursts = {}};
    for (int frame = 0; frame < 30; ++frame) {
        SbusFrame sbus;
        sbus.raw.fill(centre);
        sbus.raw[0] = frame < 10 ? low : frame < 20 ? high : centre;
        sbus.raw[1] = frame < 10 ? high : frame < 20 ? low : centre;
        sbus.raw[11] = channel_12.value_or(centre);
        std::vector<std::uint8_t> bytes(kSbusFrameLength);
        emit_sbus(sbus, std::span(bytes).first<kSbusFrameLength>());
        bytes[23] = flags;
        heard.bursts.push_back({.start = milliseconds(9 * frame), .bytes = bytes, .damaged = {}});
    }
    return judge_line(std::span(&heard, 1));
}

TEST(LineJudge, TellsTheScalesOfSbusApart) {
    EXPECT_EQ(sbus_story(992, 192, 1792).scale.name, "betaflight");
    EXPECT_EQ(sbus_story(992, 172, 1811).scale.name, "frsky");
    EXPECT_EQ(sbus_story(1024, 352, 1696).scale.name, "futaba");
    EXPECT_EQ(sbus_story(1002, 202, 1802).scale.name, "px4");
    EXPECT_EQ(sbus_story(1001, 201, 1801).scale.name, "ardupilot");
}

TEST(LineJudge, SaysWhereTheScaleCannotBeKnown) {
    const LineStory story = sbus_story(600, 500, 700);
    EXPECT_EQ(story.scale.name, "");
    EXPECT_NE(story.scale.reason.find("cannot be determined"), std::string::npos);
}

/// Futaba's scale: raw 352 is 1000 us, raw 1696 is 2000 us (docs/protocols/sbus.md, "Scales").
TEST(LineJudge, RecommendsNoScaleWithWhichAValueIsNotPlausible) {
    const LineStory story = sbus_story(1024, 352, 1696, 0, 0);
    EXPECT_EQ(story.scale.name, "");
    EXPECT_NE(story.scale.reason.find("with it channel 12 is at 738.125 us"), std::string::npos)
        << story.scale.reason;
}

TEST(LineJudge, CountsTheFlagsOfSbus) {
    const LineStory lost = sbus_story(992, 192, 1792, 0x04);
    EXPECT_EQ(lost.frame_lost, 30U);
    EXPECT_EQ(lost.failsafe, 0U);
    EXPECT_EQ(sbus_story(992, 192, 1792, 0x0C).failsafe, 30U);
}

/// A protocol that can be written, as its own encoder sends it.
Recording encoded(const Protocol& protocol, Duration period) {
    SettingValues settings;
    for (const Setting& setting : protocol.settings) {
        if (!setting.fallback.empty()) {
            settings.set(setting.key, default_of(setting));
        }
    }
    const auto any = protocol.make_encoder(settings);
    ByteEncoder& encoder = *std::get<std::unique_ptr<ByteEncoder>>(any);
    ChannelFrame frame;
    frame.frame_lost = false;
    frame.failsafe = false;
    std::mt19937 random(7);
    Recording recording;
    for (Duration at{}; at < test::kRecordedTime; at += period) {
        // Real sticks tremble, so frames differ.
        for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
            frame.set(channel, Pulse::from_eighths(8 * static_cast<int>(1000 + random() % 1000)));
        }
        std::array<std::uint8_t, kLongestSerialFrame> wire{};
        const std::size_t length = encoder.write(frame, wire, Instant(at));
        recording.bursts.push_back(
            {.start = at,
             .bytes = {wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(length)},
             .damaged = std::vector<bool>(length)});
    }
    return recording;
}

std::vector<const Protocol*> written_protocols() {
    std::vector<const Protocol*> written;
    for (const Protocol* protocol : protocols()) {
        if (carries(kSerialMedium, *protocol) && protocol->make_decoder != nullptr &&
            protocol->make_encoder != nullptr) {
            written.push_back(protocol);
        }
    }
    return written;
}

/// The line that the sender has, by its own level.
LineSettings level(LineSettings line) {
    line.inverted_wire = false;
    return line;
}

TEST_P(LineJudgeAtAPort, KnowsEveryProtocolThatCanBeWritten) {
    for (const Protocol* protocol : written_protocols()) {
        const Wire wire =
            on_a_wire(encoded(*protocol, milliseconds(10)), {.sender = {level(protocol->line)}});
        const LineStory story = judge_line(heard_of(wire, GetParam()));
        EXPECT_EQ(story.sound, LineSound::frames) << protocol->name;
        EXPECT_EQ(story.protocol, protocol->name);
        EXPECT_EQ(story.line.baud, protocol->line.baud) << protocol->name;
        expect_period(story, milliseconds(10));
    }
}

/// Frames of MAVLink differ in their second byte already.
TEST_P(LineJudgeAtAPort, KnowsEveryProtocolThatCanBeWrittenInvertedByHowItsFramesBegin) {
    for (const Protocol* protocol : written_protocols()) {
        if (protocol->beginnings.empty()) {
            EXPECT_EQ(protocol->name, "mavlink");
            continue;
        }
        const Wire wire = on_a_wire(encoded(*protocol, milliseconds(10)),
                                    {.sender = {level(protocol->line), true}});
        const LineStory story = judge_line(heard_of(wire, GetParam()));
        EXPECT_EQ(story.sound, LineSound::inverted) << protocol->name;
        EXPECT_EQ(story.protocol, protocol->name);
        EXPECT_EQ(story.line.baud, protocol->line.baud) << protocol->name;
    }
}

TEST(LineJudge, KnowsCrsfAtTheRatesToWhichReceiversAreSet) {
    const Recording crsf = encoded(*find_protocol("crsf"), milliseconds(7));
    for (const std::uint32_t baud : {115'200U, 400'000U, 416'666U, 420'000U, 460'800U, 921'600U}) {
        const LineStory story =
            judge_line(heard_of(on_a_wire(crsf, {.sender = {LineSettings{.baud = baud}}}), {}));
        EXPECT_EQ(story.sound, LineSound::frames) << baud;
        EXPECT_EQ(story.protocol, "crsf");
        // A port that is off by 5 % still reads it.
        EXPECT_LE(std::abs(static_cast<double>(story.line.baud) / baud - 1), 0.051) << baud;
    }
}

}  // namespace
}  // namespace tribus::doctor::line_judge_test
