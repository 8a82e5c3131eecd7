#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/captures/recordings.h"
#include "tests/loopback/sensor_bus.h"

/// The recorded requests of a genuine receiver and the answers of its two sensors. The program
/// takes the place of the sensors.
namespace tribus::test {

/// Sensors for after [sensor_bus.telemetry]. The speed sensor at address 1 stood still, and the
/// voltage sensor at 2 had an open input: 0 rpm and -0.01 V in all 634 answers.
inline constexpr std::string_view kRecordedSensors = R"(
[[sensor_bus.telemetry.sensor]]
type  = "rotation_speed"
value = "speed"
[[sensor_bus.telemetry.sensor]]
type  = "external_voltage"
value = "probe"
[values.speed]
constant = 0
unit     = "rpm"
[values.probe]
constant = -0.01
unit     = "V"
)";

struct RecordedExchange {
    unsigned request = 0;  ///< second byte of the request
    /// Empty for the probes of address 3, which nobody ever answered. If the sensor missed this
    /// request, its answer to the same request at other times.
    Bytes answer;
};

/// Returns the first `count` of the 652 requests in their order.
inline std::vector<RecordedExchange> recorded_exchanges(std::size_t count, Capture capture) {
    Bytes wire;
    for (const Burst& burst : recording_of("ibus_sensor_ia6b_2sensors.timed.txt", capture).bursts) {
        wire.insert(wire.end(), burst.bytes.begin(), burst.bytes.end());
    }
    std::size_t strays = 0;
    std::map<unsigned, Bytes> answers;
    std::vector<RecordedExchange> exchanges;
    for (const Bytes& frame : cut_sensor_frames(wire, strays)) {
        if (frame.size() == 4) {
            exchanges.push_back({frame[1], {}});
        } else {
            EXPECT_EQ(answers.try_emplace(frame[1], frame).first->second, frame);
        }
    }
    EXPECT_EQ(strays, 0U);
    EXPECT_EQ(exchanges.size(), 652U);
    for (RecordedExchange& exchange : exchanges) {
        exchange.answer = answers[exchange.request];
    }
    exchanges.resize(std::min(count, exchanges.size()));
    return exchanges;
}

/// Repeats the exchanges with the program. Like the receiver it repeats a request without an
/// answer. At most half of the answers may be missing at first.
inline void expect_recorded_answers(Asker& receiver,
                                    const std::vector<RecordedExchange>& exchanges) {
    std::map<unsigned, Bytes> answers;
    std::size_t wanted = 0;
    std::size_t at_once = 0;
    for (const auto& [request, recorded] : exchanges) {
        answers[request] = recorded;
        Bytes answer = receiver.ask(request);
        if (!recorded.empty()) {
            ++wanted;
            at_once += answer.empty() ? 0U : 1U;
            answer = answer.empty() ? receiver.ask_until_answered(request) : answer;
        }
        ASSERT_EQ(answer, recorded);
    }
    for (const Bytes& frame : receiver.frames()) {
        ASSERT_EQ(frame, answers[frame[1]]) << "an answer without a request";
    }
    EXPECT_LE(receiver.frames().size(), receiver.requests()) << "more answers than requests";
    EXPECT_EQ(receiver.strays(), 0U);
    testing::Test::RecordProperty("answered_at_once", static_cast<int>(at_once));
    EXPECT_GE(at_once, wanted / 2) << "of " << wanted;
}

}  // namespace tribus::test
