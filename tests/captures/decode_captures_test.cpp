#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/cli/exit_status.h"
#include "app/cli/protocol_use.h"
#include "app/wire/decode_frames.h"
#include "app/wire/encode.h"
#include "tests/support/captures.h"
#include "transports/recordings/recording.h"

/// Recordings of real receivers. The README of the recordings has the expected counts, which
/// another program found.
namespace tribus::decode_captures_test {
namespace {

using nlohmann::json;

std::string content_of(std::string_view name) {
    std::ifstream file(test::capture(name), std::ios::binary);
    EXPECT_TRUE(file) << name;
    return {std::istreambuf_iterator<char>(file), {}};
}

class Captures : public testing::Test {
  protected:
    void SetUp() override {
        ASSERT_TRUE(std::filesystem::exists(test::capture("README.md"))) << test::kNoCaptures;
    }
};

std::string decoded(std::string_view name, std::string_view protocol, DecodeFormat format) {
    const auto recording = parse_recording(content_of(name), name);
    const auto uses = choose_protocols(protocol, SettingScope::input, {});
    EXPECT_TRUE(recording) << recording.error();
    EXPECT_TRUE(uses) << uses.error();
    std::ostringstream results;
    std::ostringstream messages;
    const DecodeOutput output{format, recording->kind, results, messages};
    RecordingInMemory source(*recording);
    EXPECT_EQ(decode_frames(source, of_shape(*uses, WireShape::bytes), output), kExitFine);
    return results.str();
}

struct Decoded {
    std::vector<json> frames;
    json summary;
};

Decoded decoded_json(std::string_view name, std::string_view protocol) {
    Decoded result;
    std::istringstream text(decoded(name, protocol, DecodeFormat::json));
    for (std::string line; std::getline(text, line);) {
        json object = json::parse(line);
        if (object.contains("summary")) {
            result.summary = object["summary"];
        } else {
            result.frames.push_back(std::move(object));
        }
    }
    return result;
}

void expect_no_reject(const json& summary) {
    for (const auto& [cause, count] : summary["rejected"].items()) {
        EXPECT_EQ(count, 0) << cause;
    }
}

/// Returns the CSV without its first and its last two columns: only channels.
std::string channel_columns(const std::string& csv) {
    std::string columns;
    std::istringstream text(csv);
    for (std::string line; std::getline(text, line);) {
        const std::size_t first = line.find(',') + 1;
        const std::size_t last = line.rfind(',', line.rfind(',') - 1);
        columns += line.substr(first, last - first) + "\n";
    }
    return columns;
}

TEST_F(Captures, Ibus18FindsEveryFrameAndEveryChannelOfTheTable) {
    const std::string csv = decoded("ibus_servo18_afhds3.timed.txt", "ibus", DecodeFormat::csv);
    EXPECT_EQ(channel_columns(csv), content_of("ibus_servo18_afhds3.channels.csv"));
}

TEST_F(Captures, Ibus18HasNoRejectAndTheTimesOfItsBursts) {
    const Decoded result = decoded_json("ibus_servo18_afhds3.timed.txt", "ibus");
    EXPECT_EQ(result.frames.size(), 1231U);
    expect_no_reject(result.summary);
    EXPECT_EQ(result.summary["skipped_bytes"], 2);  // end of a frame that started earlier
    EXPECT_EQ(result.frames.front()["t_us"], 1146);
    EXPECT_EQ(result.frames.back()["t_us"], 4922137);
}

TEST_F(Captures, Ibus14WithTwoSensorsLosesOnlyTheCutFrameInFront) {
    const Decoded result = decoded_json("ibus_servo14_ia6b_2sensors.timed.txt", "ibus");
    EXPECT_EQ(result.frames.size(), 651U);
    expect_no_reject(result.summary);
    EXPECT_EQ(result.summary["skipped_bytes"], 11);
    EXPECT_TRUE(result.frames.front()["channels"][14].is_null());
}

TEST_F(Captures, Ibus14WithRpmSensorLosesNothing) {
    const Decoded result = decoded_json("ibus_servo14_ia6b_rpmsensor.timed.txt", "ibus");
    EXPECT_EQ(result.frames.size(), 718U);
    expect_no_reject(result.summary);
    EXPECT_EQ(result.summary["skipped_bytes"], 0);
}

TEST_F(Captures, Sbus2FindsEveryFrameBetweenTheSlots) {
    const Decoded result = decoded_json("sbus2_r7008SB.timed.txt", "sbus");
    EXPECT_EQ(result.frames.size(), 85U);
    expect_no_reject(result.summary);
    EXPECT_EQ(result.summary["skipped_bytes"], 0);
    std::map<int, int> footers;
    for (const json& frame : result.frames) {
        ++footers[frame["footer"].get<int>()];
    }
    EXPECT_EQ(footers, (std::map<int, int>{{0x04, 22}, {0x14, 21}, {0x24, 21}, {0x34, 21}}));
}

// The timed file was made from the export, by rounding its times to whole microseconds.
TEST_F(Captures, AnalysersExportGivesTheSameFramesAndTimes) {
    const Decoded exported = decoded_json("sbus2_r7008SB.saleae.csv", "sbus");
    const Decoded timed = decoded_json("sbus2_r7008SB.timed.txt", "sbus");
    ASSERT_EQ(exported.frames.size(), timed.frames.size());
    for (std::size_t frame = 0; frame < timed.frames.size(); ++frame) {
        EXPECT_EQ(exported.frames[frame]["raw"], timed.frames[frame]["raw"]);
        EXPECT_NEAR(exported.frames[frame]["t_us"].get<double>(),
                    timed.frames[frame]["t_us"].get<double>(), 1);
    }
}

TEST_F(Captures, AutoReadsEveryReceiverAsWhatItIs) {
    EXPECT_EQ(decoded_json("ibus_servo18_afhds3.timed.txt", "auto").frames.size(), 1231U);
    EXPECT_EQ(decoded_json("ibus_servo14_ia6b_2sensors.timed.txt", "auto").frames.size(), 651U);
    EXPECT_EQ(decoded_json("sbus2_r7008SB.timed.txt", "auto").frames.size(), 85U);
}

TEST_F(Captures, AutoFindsOneFrameInEveryLineOfTheSingleFrames) {
    const auto recording = parse_recording(content_of("single_frames.txt"), "single_frames.txt");
    ASSERT_TRUE(recording) << recording.error();
    const Decoded result = decoded_json("single_frames.txt", "auto");
    ASSERT_EQ(result.frames.size(), recording->bursts.size());
    for (std::size_t line = 0; line < result.frames.size(); ++line) {
        const bool sbus = recording->bursts[line].bytes.front() == 0x0F;
        EXPECT_EQ(result.frames[line]["protocol"], sbus ? "sbus" : "ibus") << "line " << line;
    }
    EXPECT_EQ(result.summary["skipped_bytes"], 0);
    expect_no_reject(result.summary);
}

TEST_F(Captures, EverySbusLineOfTheSingleFramesIsFoundWithItsFooter) {
    const Decoded result = decoded_json("single_frames.txt", "sbus");
    ASSERT_EQ(result.frames.size(), 15U);
    EXPECT_EQ(result.frames[3]["footer"], 0x34);
    for (std::size_t line = 4; line < 9; ++line) {
        EXPECT_EQ(result.frames[line]["footer"], 0x08);
    }
    EXPECT_EQ(result.frames[9]["footer"], 0x00);
}

// What ArduPilot's test expects of that frame, in its scale.
TEST_F(Captures, ArduPilotScaleReadsItsOwnVector) {
    const auto recording = parse_recording(content_of("single_frames.txt"), "single_frames.txt");
    const auto uses = choose_protocols("sbus", SettingScope::input, {{"scale", "ardupilot"}});
    ASSERT_TRUE(recording && uses);
    std::ostringstream results;
    const DecodeOutput output{DecodeFormat::text, recording->kind, results, results};
    RecordingInMemory source(*recording);
    decode_frames(source, of_shape(*uses, WireShape::bytes), output);
    EXPECT_NE(results.str().find(" 1562 1496 1000 1531 1806 2006 1495 1495  875"),
              std::string::npos);
}

void expect_same_bytes_after_encoding(std::string_view name, std::string_view protocol,
                                      const GivenSettings& given, std::size_t frame_length) {
    std::istringstream lines(decoded(name, protocol, DecodeFormat::json));
    const auto uses = choose_protocols(protocol, SettingScope::output, given);
    ASSERT_TRUE(uses) << uses.error();
    std::ostringstream results;
    std::ostringstream messages;
    EXPECT_EQ(encode_lines(lines, name, uses->front(), EncodeFormat::timed, results, messages),
              kExitFine);
    const auto written = parse_recording(results.str(), "encoded");
    const auto recording = parse_recording(content_of(name), name);
    ASSERT_TRUE(written && recording);
    std::size_t frame = 0;
    for (const Burst& burst : recording->bursts) {
        if (burst.bytes.size() != frame_length) {
            continue;
        }
        ASSERT_LT(frame, written->bursts.size());
        ASSERT_EQ(written->bursts[frame].start, burst.start);
        ASSERT_EQ(written->bursts[frame].bytes, burst.bytes);
        ++frame;
    }
    EXPECT_EQ(frame, written->bursts.size());
}

TEST_F(Captures, Ibus18IsTheSameAfterDecodingAndEncoding) {
    expect_same_bytes_after_encoding("ibus_servo18_afhds3.timed.txt", "ibus", {{"channels", "18"}},
                                     32);
}

TEST_F(Captures, Ibus14IsTheSameAfterDecodingAndEncoding) {
    expect_same_bytes_after_encoding("ibus_servo14_ia6b_rpmsensor.timed.txt", "ibus",
                                     {{"channels", "18"}}, 32);
}

}  // namespace
}  // namespace tribus::decode_captures_test
