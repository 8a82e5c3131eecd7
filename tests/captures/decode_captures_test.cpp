#include <algorithm>
#include <cstddef>
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
#include "tests/captures/recordings.h"
#include "tests/captures/twins.h"
#include "transports/recordings/recording.h"

/// Recordings of real receivers and their twins. The README of the recordings has the expected
/// counts, which another program found.
namespace tribus::decode_captures_test {
namespace {

using nlohmann::json;
using test::Capture;

std::string decoded(const Recording& recording, std::string_view protocol, DecodeFormat format,
                    const GivenSettings& given = {}) {
    const auto uses = choose_protocols(protocol, SettingScope::input, given);
    EXPECT_TRUE(uses) << uses.error();
    std::ostringstream results;
    std::ostringstream messages;
    const DecodeOutput output{format, recording.kind, results, messages};
    RecordingInMemory source(recording);
    EXPECT_EQ(decode_frames(source, of_shape(*uses, WireShape::bytes), output), kExitFine);
    return results.str();
}

struct Decoded {
    std::vector<json> frames;
    json summary;
};

Decoded decoded_json(const Recording& recording, std::string_view protocol) {
    Decoded result;
    std::istringstream text(decoded(recording, protocol, DecodeFormat::json));
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

class Captures : public testing::TestWithParam<Capture> {
  protected:
    static Recording recording(std::string_view file) {
        return test::recording_of(file, GetParam());
    }
    static Decoded decoded_file(std::string_view file, std::string_view protocol) {
        return decoded_json(recording(file), protocol);
    }
};

INSTANTIATE_TEST_SUITE_P(Both, Captures, testing::ValuesIn(test::captures()),
                         [](const auto& test) { return test::capture_name(test.param); });

TEST_P(Captures, Ibus18FindsEveryFrameAndEveryChannelOfTheTable) {
    const std::string csv =
        decoded(recording("ibus_servo18_afhds3.timed.txt"), "ibus", DecodeFormat::csv);
    EXPECT_EQ(channel_columns(csv),
              test::content_of("ibus_servo18_afhds3.channels.csv", GetParam()));
}

TEST_P(Captures, Ibus18HasNoRejectAndTheTimesOfItsBursts) {
    const Decoded result = decoded_file("ibus_servo18_afhds3.timed.txt", "ibus");
    EXPECT_EQ(result.frames.size(), 1231U);
    expect_no_reject(result.summary);
    EXPECT_EQ(result.summary["skipped_bytes"], 2);  // end of a frame that started earlier
    EXPECT_EQ(result.frames.front()["t_us"], 1146);
    EXPECT_EQ(result.frames.back()["t_us"], 4922137);
}

TEST_P(Captures, Ibus14WithTwoSensorsLosesOnlyTheCutFrameInFront) {
    const Decoded result = decoded_file("ibus_servo14_ia6b_2sensors.timed.txt", "ibus");
    EXPECT_EQ(result.frames.size(), 651U);
    expect_no_reject(result.summary);
    EXPECT_EQ(result.summary["skipped_bytes"], 11);
    EXPECT_TRUE(result.frames.front()["channels"][14].is_null());
}

TEST_P(Captures, Ibus14WithRpmSensorLosesNothing) {
    const Decoded result = decoded_file("ibus_servo14_ia6b_rpmsensor.timed.txt", "ibus");
    EXPECT_EQ(result.frames.size(), 718U);
    expect_no_reject(result.summary);
    EXPECT_EQ(result.summary["skipped_bytes"], 0);
}

TEST_P(Captures, Sbus2FindsEveryFrameBetweenTheSlots) {
    const Decoded result = decoded_file("sbus2_r7008SB.timed.txt", "sbus");
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
TEST_P(Captures, AnalysersExportGivesTheSameFramesAndTimes) {
    const Decoded exported = decoded_file("sbus2_r7008SB.saleae.csv", "sbus");
    const Decoded timed = decoded_file("sbus2_r7008SB.timed.txt", "sbus");
    ASSERT_EQ(exported.frames.size(), timed.frames.size());
    for (std::size_t frame = 0; frame < timed.frames.size(); ++frame) {
        EXPECT_EQ(exported.frames[frame]["raw"], timed.frames[frame]["raw"]);
        EXPECT_NEAR(exported.frames[frame]["t_us"].get<double>(),
                    timed.frames[frame]["t_us"].get<double>(), 1);
    }
}

TEST_P(Captures, AutoReadsEveryReceiverAsWhatItIs) {
    EXPECT_EQ(decoded_file("ibus_servo18_afhds3.timed.txt", "auto").frames.size(), 1231U);
    EXPECT_EQ(decoded_file("ibus_servo14_ia6b_2sensors.timed.txt", "auto").frames.size(), 651U);
    EXPECT_EQ(decoded_file("sbus2_r7008SB.timed.txt", "auto").frames.size(), 85U);
}

/// Frames that are quoted in public documents (tests/vectors/single_frames.txt).
class SingleFrames : public testing::Test {
  protected:
    const Recording recording_ = test::single_frames();
};

TEST_F(SingleFrames, AutoFindsOneFrameInEveryLine) {
    const Decoded result = decoded_json(recording_, "auto");
    ASSERT_EQ(result.frames.size(), recording_.bursts.size());
    for (std::size_t line = 0; line < result.frames.size(); ++line) {
        const bool sbus = recording_.bursts[line].bytes.front() == 0x0F;
        EXPECT_EQ(result.frames[line]["protocol"], sbus ? "sbus" : "ibus") << "line " << line;
    }
    EXPECT_EQ(result.summary["skipped_bytes"], 0);
    expect_no_reject(result.summary);
}

TEST_F(SingleFrames, EachSbusLineIsFoundWithItsFooter) {
    const Decoded result = decoded_json(recording_, "sbus");
    ASSERT_EQ(result.frames.size(), 15U);
    EXPECT_EQ(result.frames[3]["footer"], 0x34);
    for (std::size_t line = 4; line < 9; ++line) {
        EXPECT_EQ(result.frames[line]["footer"], 0x08);
    }
    EXPECT_EQ(result.frames[9]["footer"], 0x00);
}

// What ArduPilot's test expects of that frame, in its scale.
TEST_F(SingleFrames, ArduPilotScaleReadsItsOwnVector) {
    const std::string text =
        decoded(recording_, "sbus", DecodeFormat::text, {{"scale", "ardupilot"}});
    EXPECT_NE(text.find(" 1562 1496 1000 1531 1806 2006 1495 1495  875"), std::string::npos);
}

void expect_same_bytes_after_encoding(const Recording& recording, std::string_view protocol,
                                      const GivenSettings& given, std::size_t frame_length) {
    std::istringstream lines(decoded(recording, protocol, DecodeFormat::json));
    const auto uses = choose_protocols(protocol, SettingScope::output, given);
    ASSERT_TRUE(uses) << uses.error();
    std::ostringstream results;
    std::ostringstream messages;
    EXPECT_EQ(
        encode_lines(lines, "recording", uses->front(), EncodeFormat::timed, results, messages),
        kExitFine);
    const auto written = parse_recording(results.str(), "encoded");
    ASSERT_TRUE(written) << written.error();
    std::size_t frame = 0;
    for (const Burst& burst : recording.bursts) {
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

TEST_P(Captures, Ibus18IsTheSameAfterDecodingAndEncoding) {
    expect_same_bytes_after_encoding(recording("ibus_servo18_afhds3.timed.txt"), "ibus",
                                     {{"channels", "18"}}, 32);
}

TEST_P(Captures, Ibus14IsTheSameAfterDecodingAndEncoding) {
    expect_same_bytes_after_encoding(recording("ibus_servo14_ia6b_rpmsensor.timed.txt"), "ibus",
                                     {{"channels", "18"}}, 32);
}

Decoded decoded_worn(std::string_view file, std::string_view protocol, const test::Wear& wear) {
    const auto recording = parse_recording(test::twin_file(file, wear), file);
    EXPECT_TRUE(recording) << recording.error();
    return recording ? decoded_json(*recording, protocol) : Decoded{};
}

constexpr std::string_view kTwins[][2]{{"ibus_servo18_afhds3.timed.txt", "ibus"},
                                       {"ibus_servo14_ia6b_2sensors.timed.txt", "ibus"},
                                       {"sbus2_r7008SB.timed.txt", "sbus"}};

TEST(WornTwins, BurstsThatAPortCutsGiveTheSameFrames) {
    for (const auto& [file, protocol] : kTwins) {
        for (const std::size_t each : {1U, 7U, 23U, 26U}) {
            const Decoded whole = decoded_worn(file, protocol, {});
            const Decoded cut = decoded_worn(file, protocol, {.split_each = each});
            ASSERT_EQ(cut.frames.size(), whole.frames.size()) << file << " " << each;
            for (std::size_t frame = 0; frame < whole.frames.size(); ++frame) {
                EXPECT_EQ(cut.frames[frame]["channels"], whole.frames[frame]["channels"]);
            }
        }
    }
}

TEST(WornTwins, AParityErrorCostsTheFramesThatHaveOneAndNoOther) {
    constexpr std::size_t kEach = 32 * 20 + 7;
    for (const auto& [file, protocol] : kTwins) {
        const auto worn = parse_recording(test::twin_file(file, {.damage_each = kEach}), file);
        ASSERT_TRUE(worn) << worn.error();
        const std::size_t length = protocol == "ibus" ? 32 : 25;
        const auto whole = std::ranges::count_if(worn->bursts, [&](const Burst& burst) {
            return burst.bytes.size() == length && std::ranges::count(burst.damaged, true) == 0;
        });
        const Decoded result = decoded_json(*worn, protocol);
        EXPECT_EQ(std::ssize(result.frames), whole) << file;
        EXPECT_LT(result.frames.size(), decoded_worn(file, protocol, {}).frames.size()) << file;
    }
}

}  // namespace
}  // namespace tribus::decode_captures_test
