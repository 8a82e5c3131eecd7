#include "app/wire/frames/frame_json.h"

#include <array>
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "transports/registry/registry.h"

namespace tribus::frame_json_test {
namespace {

using namespace std::chrono_literals;

std::string text_of(Pulse pulse) {
    std::string text;
    append_pulse(text, pulse);
    return text;
}

FoundFrame contract_example() {
    FoundFrame found;
    found.protocol = find_protocol("ibus");
    found.start = Duration(1146us);
    found.frame.channels.frame_lost = false;
    found.frame.channels.failsafe = false;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        found.frame.channels.set(channel, kCentrePulse);
    }
    found.frame.channels.set(2, Pulse::from_microseconds(2000));
    found.frame.channels.set(3, Pulse::from_microseconds(1000));
    return found;
}

std::string json_of(const FoundFrame& found) {
    std::string text;
    append_frame_json(text, found);
    return text;
}

WrittenFrame read(std::string_view line) {
    const auto frame = parse_frame_json(line);
    EXPECT_TRUE(frame && *frame) << line;
    return frame && *frame ? **frame : WrittenFrame{};
}

std::string mistake_in(std::string_view line) {
    const auto frame = parse_frame_json(line);
    EXPECT_FALSE(frame) << line;
    return frame ? std::string() : frame.error().text;
}

TEST(FrameJson, WholePulsesHaveNoPoint) {
    EXPECT_EQ(text_of(Pulse::from_microseconds(1500)), "1500");
    EXPECT_EQ(text_of(Pulse{}), "0");
}

TEST(FrameJson, EighthsAreExact) {
    EXPECT_EQ(text_of(Pulse::from_eighths(8805)), "1100.625");
    EXPECT_EQ(text_of(Pulse::from_eighths(8004)), "1000.5");
    EXPECT_EQ(text_of(Pulse::from_eighths(-1)), "-0.125");
}

// Other programs read this format.
TEST(FrameJson, PrintsTheContractsExample) {
    EXPECT_EQ(json_of(contract_example()),
              "{\"t_us\":1146,\"protocol\":\"ibus\",\"channels\":[1500,1500,2000,1000,1500,1500,"
              "1500,1500,1500,1500,1500,1500,1500,1500,1500,1500,1500,1500],\"frame_lost\":false,"
              "\"failsafe\":false}\n");
}

TEST(FrameJson, AbsentChannelsAreNullAndUnknownTimesLeftOut) {
    FoundFrame found = contract_example();
    found.start.reset();
    for (std::size_t channel = 1; channel < kChannelCount; ++channel) {
        found.frame.channels.remove(channel);
    }
    EXPECT_EQ(json_of(found),
              "{\"protocol\":\"ibus\",\"channels\":[1500,null,null,null,null,null,null,null,null,"
              "null,null,null,null,null,null,null,null,null],\"frame_lost\":false,"
              "\"failsafe\":false}\n");
}

TEST(FrameJson, DetailsOfTheProtocolComeLast) {
    FoundFrame found = contract_example();
    found.frame.channels.failsafe = true;
    const std::array<std::uint16_t, 2> raw{172, 1811};
    const std::array<std::uint16_t, 1> footer{4};
    const std::array<FrameDetail, 2> details{{{"raw", raw, true}, {"footer", footer, false}}};
    found.details = details;
    const std::string text = json_of(found);
    EXPECT_EQ(text.substr(text.find("\"frame_lost\"")),
              "\"frame_lost\":false,\"failsafe\":true,\"raw\":[172,1811],\"footer\":4}\n");
}

TEST(FrameJson, SummaryNamesEveryCause) {
    const Tally tally{
        .bytes = 64, .frames = 1, .rejected = {{"checksum", 1}, {"ibus2", 0}}, .skipped_bytes = 32};
    std::string text;
    append_summary_json(text, tally, "hex");
    EXPECT_EQ(text,
              "{\"summary\":{\"bytes\":64,\"frames\":1,\"rejected\":{\"checksum\":1,\"ibus2\":0},"
              "\"skipped_bytes\":32,\"input\":\"hex\"}}\n");
}

TEST(FrameJson, ReadsWhatItPrints) {
    const FoundFrame found = contract_example();
    const WrittenFrame frame = read(json_of(found));
    EXPECT_TRUE(frame.channels.same_content(found.frame.channels));
    EXPECT_EQ(frame.start, found.start);
}

TEST(FrameJson, EveryPulseReadsBackTheSame) {
    for (int eighths = INT16_MIN; eighths <= INT16_MAX; ++eighths) {
        const Pulse pulse = Pulse::from_eighths(eighths);
        const auto line = "{\"channels\":[" + text_of(pulse) + "]}";
        ASSERT_EQ(read(line).channels.channel(0), pulse) << line;
    }
}

TEST(FrameJson, FlagsTimesAndChannelsMayBeMissing) {
    const WrittenFrame frame = read("{\"channels\":[null,1500]}");
    EXPECT_FALSE(frame.channels.has(0));
    EXPECT_EQ(frame.channels.channel(1), kCentrePulse);
    EXPECT_FALSE(frame.channels.has(2));
    EXPECT_TRUE(frame.channels.good());
    EXPECT_EQ(frame.start, std::nullopt);
}

TEST(FrameJson, BlankLinesAndTheSummaryAreNoFrames) {
    for (const std::string_view line : {"", "  \r", "{\"summary\":{\"frames\":3}}"}) {
        const auto frame = parse_frame_json(line);
        ASSERT_TRUE(frame) << line;
        EXPECT_EQ(*frame, std::nullopt) << line;
    }
}

TEST(FrameJson, SaysWhereALineStopsBeingJson) {
    const auto frame = parse_frame_json("{\"channels\":[1,2");
    ASSERT_FALSE(frame);
    EXPECT_EQ(frame.error().column, 17U);
    EXPECT_EQ(frame.error().text, "not JSON; a line must be one object, as decode prints it");
}

TEST(FrameJson, RefusesWhatIsNoFrame) {
    EXPECT_EQ(mistake_in("[1500]"), "a line must be one object, as decode prints it");
    EXPECT_EQ(mistake_in("{\"t_us\":1}"),
              "no \"channels\" in it; a frame is {\"channels\":[1500, ...]}");
    EXPECT_EQ(mistake_in("{\"channels\":1500}"),
              "\"channels\" must be a list of at most 18 pulses in microseconds, null if absent");
    EXPECT_EQ(mistake_in("{\"channels\":[0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0]}"),
              "\"channels\" must be a list of at most 18 pulses in microseconds, null if absent");
}

TEST(FrameJson, RefusesValuesThatNothingCanHold) {
    EXPECT_EQ(mistake_in("{\"channels\":[1500,9000]}"),
              "channel 2 is 9000; allowed: -4096 to 4095.875 us, or null");
    EXPECT_EQ(mistake_in("{\"channels\":[\"1500\"]}"),
              "channel 1 is \"1500\"; allowed: -4096 to 4095.875 us, or null");
    EXPECT_EQ(mistake_in("{\"channels\":[],\"failsafe\":1}"), "\"failsafe\" must be true or false");
    EXPECT_EQ(mistake_in("{\"channels\":[],\"t_us\":1e99}"),
              "\"t_us\" must be a number of microseconds; leave it out if unknown");
}

}  // namespace
}  // namespace tribus::frame_json_test
