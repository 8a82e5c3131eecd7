#include "app/doctor/listening/line_judge.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <tuple>
#include <variant>
#include <vector>

#include "config/schema/notation.h"
#include "tests/captures/recordings.h"
#include "tests/support/recorded_lines.h"
#include "transports/codecs/sbus/sbus.h"
#include "transports/links/serial/serial_medium.h"
#include "transports/registry/registry.h"

namespace tribus::doctor::line_judge_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using test::Capture;
using test::heard_of;
using test::HeardBy;
using test::on_a_wire;
using test::SentAs;
using test::UartKind;
using test::Wire;

const std::vector<std::string> kIbus14{"ibus_servo14_ia6b_2sensors.timed.txt",
                                       "ibus_servo14_ia6b_rpmsensor.timed.txt"};
const std::string kIbus18 = "ibus_servo18_afhds3.timed.txt";
const std::vector<std::string> kSensorBuses{"ibus_sensor_ia6b_2sensors.timed.txt",
                                            "ibus_sensor_ia6b_rpmsensor.timed.txt",
                                            "ibus_sensor_ia6b_tap_between.timed.txt"};
const std::string kSbus2 = "sbus2_r7008SB.timed.txt";

/// Ports of both kinds that deliver each byte, or once a millisecond what has come.
constexpr HeardBy kEachByteWaitingForIdle{UartKind::waits_for_idle, Duration(1)};
constexpr HeardBy kLumpsWaitingForIdle{UartKind::waits_for_idle, milliseconds(1)};
constexpr HeardBy kEachByteAtOnce{UartKind::takes_error_for_start, Duration(1)};
constexpr HeardBy kLumpsAtOnce{UartKind::takes_error_for_start, milliseconds(1)};

class LineJudgeAtAPort : public testing::TestWithParam<HeardBy> {};

/// The first tier has each property of a port, the second one has the other pairs.
INSTANTIATE_TEST_SUITE_P(Usual, LineJudgeAtAPort,
                         testing::Values(kEachByteWaitingForIdle, kLumpsAtOnce));
INSTANTIATE_TEST_SUITE_P(Further, LineJudgeAtAPort,
                         testing::Values(kLumpsWaitingForIdle, kEachByteAtOnce));

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
        return line_judge_test::story_of(test::recording_of(file, capture), as, port);
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

void expect_period(const LineStory& story, Duration expected) {
    ASSERT_TRUE(story.period);
    EXPECT_LT(std::chrono::abs(*story.period - expected), microseconds(100))
        << story.period->count();
}

TEST_P(RecordedLineAtAPort, knows_ibus_of_14_channels) {
    for (const std::string& name : kIbus14) {
        const LineStory story = story_of(name, ibus_sent());
        EXPECT_EQ(story.sound, LineSound::frames);
        EXPECT_EQ(story.protocol, "ibus");
        EXPECT_EQ(story.channels, 14U);
        EXPECT_EQ(story.line, kIbusLine);
        expect_period(story, microseconds(7701));
    }
}

TEST_P(RecordedLineAtAPort, knows_ibus_of_18_channels) {
    const LineStory story = story_of(kIbus18, ibus_sent());
    EXPECT_EQ(story.sound, LineSound::frames);
    EXPECT_EQ(story.protocol, "ibus");
    EXPECT_EQ(story.channels, 18U);
    expect_period(story, microseconds(4000));
}

TEST_P(RecordedLineAtAPort, knows_sbus2_and_futabas_scale) {
    const LineStory story = story_of(kSbus2, {.sender = {.line = kSbusLine}});
    EXPECT_EQ(story.sound, LineSound::frames);
    EXPECT_EQ(story.protocol, "sbus");
    EXPECT_EQ(story.line, kSbusLine);
    EXPECT_TRUE(story.sbus2);
    EXPECT_EQ(story.scale.name, "futaba");
    expect_period(story, milliseconds(15));
}

TEST_P(RecordedLineAtAPort, knows_fast_sbus) {
    const LineStory story = story_of(kSbus2, {.sender = {.line = kFastSbusLine}});
    EXPECT_EQ(story.sound, LineSound::frames);
    EXPECT_EQ(story.protocol, "sbus");
    EXPECT_EQ(story.line, kFastSbusLine);
}

TEST_P(RecordedLineAtAPort, knows_the_sensor_bus) {
    for (const std::string& name : kSensorBuses) {
        const LineStory story = story_of(name, ibus_sent());
        EXPECT_EQ(story.sound, LineSound::frames) << name;
        EXPECT_EQ(story.protocol, "ibus-sensor") << name;
        EXPECT_GT(story.requests, 40U) << name;
        EXPECT_GT(story.replies, 15U) << name;
        expect_period(story, microseconds(7701));
    }
}

TEST_P(RecordedLineAtAPort, knows_inverted_ibus) {
    for (const std::string& name : {kIbus14[0], kIbus14[1], kIbus18}) {
        const LineStory story = story_of(name, ibus_sent(true));
        EXPECT_EQ(story.sound, LineSound::inverted) << name;
        EXPECT_EQ(story.protocol, "ibus") << name;
        expect_period(story, name == kIbus18 ? microseconds(4000) : microseconds(7701));
    }
}

TEST_P(RecordedLineAtAPort, knows_inverted_ibus_of_senders_that_make_no_pause) {
    const LineStory story = story_of(kIbus14[0], {.sender = {.line = kIbusLine, .inverted = true}});
    EXPECT_EQ(story.sound, LineSound::inverted);
    EXPECT_EQ(story.protocol, "ibus");
}

TEST_P(RecordedLineAtAPort, knows_inverted_sbus) {
    for (const LineSettings& line : {kSbusLine, kFastSbusLine}) {
        const LineStory story = story_of(kSbus2, {.sender = {.line = line, .inverted = true}});
        EXPECT_EQ(story.sound, LineSound::inverted);
        EXPECT_EQ(story.protocol, "sbus");
        EXPECT_EQ(story.line, line);
        expect_period(story, milliseconds(15));
    }
}

TEST_P(RecordedLineAtAPort, knows_an_inverted_sensor_bus) {
    const LineStory story = story_of(kSensorBuses[0], ibus_sent(true));
    EXPECT_EQ(story.sound, LineSound::inverted);
    EXPECT_EQ(story.protocol, "ibus-sensor");
}

TEST_P(RecordedLineAtAPort, knows_sbus_without_parity) {
    for (const std::uint8_t stop_bits : {std::uint8_t{1}, std::uint8_t{2}}) {
        const LineSettings line{.baud = 100'000, .stop_bits = stop_bits};
        const LineStory story = story_of(kSbus2, {.sender = {.line = line}});
        EXPECT_EQ(story.sound, LineSound::wrong_parity);
        EXPECT_EQ(story.protocol, "sbus");
    }
}

TEST_P(RecordedLineAtAPort, knows_sbus_with_odd_parity) {
    const LineStory story = story_of(kSbus2, {.sender = {.line = kSbusLine, .odd_parity = true}});
    EXPECT_EQ(story.sound, LineSound::wrong_parity);
    EXPECT_EQ(story.protocol, "sbus");
}

TEST_P(RecordedLine, knows_ibus_with_parity_where_the_port_gets_into_step_again) {
    const LineSettings line{.baud = kUsualBaud, .parity = Parity::even};
    const LineStory story = story_of(
        recorded(kIbus14[0]), {.sender = {.line = line}, .pause_bits = 1}, kEachByteWaitingForIdle);
    EXPECT_EQ(story.sound, LineSound::wrong_parity);
    EXPECT_EQ(story.protocol, "ibus");
}

TEST_P(RecordedLineAtAPort, takes_another_rate_for_nothing_known) {
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

TEST(LineJudge, takes_no_byte_for_silence) {
    const auto heard = heard_of(Wire({.line = kIbusLine}), {});
    const LineStory story = judge_line(heard);
    EXPECT_EQ(story.sound, LineSound::silence);
    EXPECT_EQ(story.listened, static_cast<int>(heard.size()) * test::kRecordedTime);
}

TEST_P(LineJudgeAtAPort, takes_noise_for_nothing_known) {
    std::mt19937 random(7);
    Wire wire({.line = {.baud = 300'000}});
    for (int burst = 0; burst < 100; ++burst) {
        std::vector<std::uint8_t> bytes(1 + random() % 30);
        std::ranges::generate(bytes, [&] { return static_cast<std::uint8_t>(random()); });
        wire.send(microseconds(random() % 5000) + wire.end(), bytes);
    }
    EXPECT_EQ(judge_line(heard_of(wire, GetParam())).sound, LineSound::unknown);
}

/// As FTDI adapters report it: an error in a packet counts for all its bytes, and their values are
/// lost.
TEST_P(RecordedLine, hears_a_low_line_where_the_port_tells_breaks_only) {
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
TEST_P(RecordedLine, knows_inverted_sbus_where_the_port_tells_no_errors) {
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

TEST_P(RecordedLine, finds_requests_on_a_wire_that_carries_ibus_too) {
    Recording both = recorded(kIbus14[0]);
    const Recording sensors = recorded(kSensorBuses[0]);
    both.bursts.insert(both.bursts.end(), sensors.bursts.begin(), sensors.bursts.end());
    std::ranges::sort(both.bursts, {}, [](const Burst& burst) { return *burst.start; });
    const LineStory story = judge_line(heard_of(on_a_wire(both, ibus_sent()), {}));
    EXPECT_EQ(story.protocol, "ibus");
    EXPECT_GT(story.frames, 40U);
    EXPECT_GT(story.requests, 40U);
}

TEST_P(RecordedLine, counts_bytes_of_no_frame) {
    auto heard = heard_of(on_a_wire(recorded(kIbus18), ibus_sent()), {});
    heard[0].bursts[1000].damaged[0] = true;
    const LineStory story = judge_line(heard);
    EXPECT_EQ(story.sound, LineSound::frames);
    EXPECT_EQ(story.damaged, 1U);
    EXPECT_GE(story.lost_bytes, 31U);
    EXPECT_LE(story.lost_bytes, 64U);
}

TEST(LineJudge, knows_ibus2_as_what_it_cannot_read) {
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
                     std::uint8_t flags = 0) {
    Heard heard{.line = kSbusLine, .listened = std::chrono::seconds(1), .bursts = {}};
    for (int frame = 0; frame < 30; ++frame) {
        SbusFrame sbus;
        sbus.raw.fill(centre);
        sbus.raw[0] = frame < 10 ? low : frame < 20 ? high : centre;
        sbus.raw[1] = frame < 10 ? high : frame < 20 ? low : centre;
        std::vector<std::uint8_t> bytes(kSbusFrameLength);
        emit_sbus(sbus, std::span(bytes).first<kSbusFrameLength>());
        bytes[23] = flags;
        heard.bursts.push_back({.start = milliseconds(9 * frame), .bytes = bytes, .damaged = {}});
    }
    return judge_line(std::span(&heard, 1));
}

TEST(LineJudge, tells_the_scales_of_sbus_apart) {
    EXPECT_EQ(sbus_story(992, 192, 1792).scale.name, "betaflight");
    EXPECT_EQ(sbus_story(992, 172, 1811).scale.name, "frsky");
    EXPECT_EQ(sbus_story(1024, 352, 1696).scale.name, "futaba");
    EXPECT_EQ(sbus_story(1002, 202, 1802).scale.name, "px4");
    EXPECT_EQ(sbus_story(1001, 201, 1801).scale.name, "ardupilot");
}

TEST(LineJudge, says_where_the_scale_cannot_be_known) {
    const LineStory story = sbus_story(600, 500, 700);
    EXPECT_EQ(story.scale.name, "");
    EXPECT_NE(story.scale.reason.find("cannot be determined"), std::string::npos);
}

TEST(LineJudge, counts_the_flags_of_sbus) {
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

TEST_P(LineJudgeAtAPort, knows_every_protocol_that_can_be_written) {
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
TEST_P(LineJudgeAtAPort,
       knows_every_protocol_that_can_be_written_inverted_by_how_its_frames_begin) {
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

TEST(LineJudge, knows_crsf_at_the_rates_to_which_receivers_are_set) {
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
