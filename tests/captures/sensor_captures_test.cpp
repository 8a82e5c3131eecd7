#include <cstddef>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/cli/exit_status.h"
#include "app/wire/decode_sensor.h"
#include "app/wire/sensors/sensor_frame_finder.h"
#include "tests/captures/recordings.h"
#include "transports/recordings/recording.h"

/// Recordings of a genuine receiver (FS-iA6B) with genuine sensors, and their twins. The expected
/// counts are those of the README of the recordings, which another program found, and of
/// docs/protocols/ibus.md, "Sensor bus: timing".
namespace tribus::sensor_captures_test {
namespace {

using nlohmann::json;

struct Decoded {
    std::vector<json> exchanges;
    json summary;
};

Decoded decoded(const Recording& recording) {
    const SensorTypes types;
    std::ostringstream results;
    std::ostringstream messages;
    SensorDecoding decoding(types, {DecodeFormat::json, recording.kind, results, messages});
    RecordingInMemory source(recording);
    EXPECT_EQ(decode_recording(source, decoding, messages), kExitFine) << messages.str();
    Decoded result;
    std::istringstream lines(results.str());
    for (std::string line; std::getline(lines, line);) {
        json object = json::parse(line);
        if (object.contains("summary")) {
            result.summary = object["summary"];
        } else {
            result.exchanges.push_back(std::move(object));
        }
    }
    return result;
}

void expect_complete(const json& summary, int frames) {
    EXPECT_EQ(summary["frames"], frames);
    EXPECT_EQ(summary["skipped_bytes"], 0);
    EXPECT_EQ(summary["unasked"], 0);
    EXPECT_EQ(summary["echoes"], 0);
    for (const auto& [cause, count] : summary["rejected"].items()) {
        EXPECT_EQ(count, 0) << cause;
    }
}

/// Genuine sensors answer 0.62 to 0.64 ms after the end of the request, with a tolerance of 0.01
/// ms.
void expect_response_of_genuine_sensors(const json& address) {
    EXPECT_GE(address["response_us"]["least"], 615);
    EXPECT_LE(address["response_us"]["most"], 645);
}

/// Checks that after each miss at one of `addresses` the same request follows in the next slot and
/// is answered.
void expect_misses_asked_again(const std::vector<json>& exchanges, const std::set<int>& addresses,
                               int count) {
    int misses = 0;
    for (std::size_t i = 0; i + 1 < exchanges.size(); ++i) {
        const json& missed = exchanges[i];
        const json& next = exchanges[i + 1];
        if (missed["answer"] != "miss" || addresses.count(missed["address"].get<int>()) == 0) {
            continue;
        }
        ++misses;
        EXPECT_EQ(missed["asked_again"], true) << missed;
        EXPECT_EQ(next["address"], missed["address"]) << missed;
        EXPECT_EQ(next["asked"], "value") << missed;
        EXPECT_EQ(next["answer"], "reply") << missed;
        EXPECT_NEAR(next["t_us"].get<double>() - missed["t_us"].get<double>(), 7701, 5) << missed;
    }
    EXPECT_EQ(misses, count);
}

bool of_sensors(const Recording& recording) {
    RecordingInMemory source(recording);
    return is_sensor_bus(source);
}

class SensorCaptures : public testing::TestWithParam<test::Capture> {
  protected:
    static Recording recording(std::string_view file) {
        return test::recording_of(file, GetParam());
    }
};

INSTANTIATE_TEST_SUITE_P(Both, SensorCaptures, testing::ValuesIn(test::captures()),
                         [](const auto& test) { return test::capture_name(test.param); });

void expect_two_sensors(const Recording& recording) {
    const Decoded result = decoded(recording);
    expect_complete(result.summary, 1286);
    EXPECT_EQ(result.summary["requests"], 642);
    EXPECT_EQ(result.summary["replies"], 634);
    EXPECT_EQ(result.summary["probes"], 10);
    EXPECT_EQ(result.summary["misses"], 8);
    const json& addresses = result.summary["addresses"];
    ASSERT_EQ(addresses.size(), 3U);
    EXPECT_EQ(addresses[2]["address"], 3);
    EXPECT_EQ(addresses[2]["probes"], 10);
    expect_response_of_genuine_sensors(addresses[0]);
    expect_response_of_genuine_sensors(addresses[1]);
    expect_misses_asked_again(result.exchanges, {1, 2}, 8);
}

TEST_P(SensorCaptures, TwoSensorsAreExplainedCompletely) {
    expect_two_sensors(recording("ibus_sensor_ia6b_2sensors.timed.txt"));
}

TEST_P(SensorCaptures, TheAnalysersExportSaysTheSame) {
    expect_two_sensors(recording("ibus_sensor_ia6b_2sensors.saleae.csv"));
}

TEST_P(SensorCaptures, OneSensorIsExplainedUpToTheCutAtTheEnd) {
    const Decoded result = decoded(recording("ibus_sensor_ia6b_rpmsensor.timed.txt"));
    expect_complete(result.summary, 1418);
    EXPECT_EQ(result.summary["requests"], 707);
    EXPECT_EQ(result.summary["replies"], 700);
    EXPECT_EQ(result.summary["probes"], 11);
    EXPECT_EQ(result.summary["misses"], 7);
    expect_response_of_genuine_sensors(result.summary["addresses"][0]);
    expect_misses_asked_again(result.exchanges, {1}, 7);
}

// The first sensor passes requests on, but keeps its answers off the wire behind it.
TEST_P(SensorCaptures, BehindTheFirstSensorOnlyItsRequestsAreSeen) {
    const Decoded result = decoded(recording("ibus_sensor_ia6b_tap_between.timed.txt"));
    expect_complete(result.summary, 967);
    const json& addresses = result.summary["addresses"];
    ASSERT_EQ(addresses.size(), 3U);
    EXPECT_EQ(addresses[0]["requests"], 321);
    EXPECT_EQ(addresses[0]["replies"], 0);
    EXPECT_EQ(addresses[1]["requests"], 320);
    EXPECT_EQ(addresses[1]["replies"], 316);
    EXPECT_EQ(addresses[2]["probes"], 10);
    expect_response_of_genuine_sensors(addresses[1]);
    expect_misses_asked_again(result.exchanges, {2}, 4);
}

TEST_P(SensorCaptures, ProbesComeEvery66Slots) {
    const Decoded result = decoded(recording("ibus_sensor_ia6b_2sensors.timed.txt"));
    std::vector<double> probes;
    for (const json& exchange : result.exchanges) {
        if (exchange["answer"] == "free") {
            probes.push_back(exchange["t_us"].get<double>());
        }
    }
    ASSERT_EQ(probes.size(), 10U);
    for (std::size_t i = 1; i < probes.size(); ++i) {
        EXPECT_NEAR(probes[i] - probes[i - 1], 508250, 50);
    }
}

TEST_P(SensorCaptures, TheSensorWireIsToldFromTheServoWire) {
    const auto is_of_sensors = [](std::string_view file) { return of_sensors(recording(file)); };
    EXPECT_TRUE(is_of_sensors("ibus_sensor_ia6b_2sensors.timed.txt"));
    EXPECT_TRUE(is_of_sensors("ibus_sensor_ia6b_rpmsensor.timed.txt"));
    EXPECT_TRUE(is_of_sensors("ibus_sensor_ia6b_tap_between.timed.txt"));
    EXPECT_FALSE(is_of_sensors("ibus_servo14_ia6b_2sensors.timed.txt"));
    EXPECT_FALSE(is_of_sensors("ibus_servo18_afhds3.timed.txt"));
    EXPECT_FALSE(is_of_sensors("sbus2_r7008SB.timed.txt"));
}

TEST(SensorFrames, SingleFramesAreNoSensorWire) {
    EXPECT_FALSE(of_sensors(test::single_frames()));
}

TEST_P(SensorCaptures, ServoFramesOnTheSameWireHoldNoSensorFrame) {
    SensorFrameFinder finder([](const ReceivedSensorFrame&) { ADD_FAILURE(); });
    for (const Burst& burst : recording("ibus_servo14_ia6b_2sensors.timed.txt").bursts) {
        finder.feed_burst(0, burst);
    }
    EXPECT_EQ(finder.tally().servo_frames, 651U);
    EXPECT_EQ(finder.tally().frames.skipped_bytes, 11U);
}

}  // namespace
}  // namespace tribus::sensor_captures_test
