#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/value_board.h"
#include "tests/support/shell.h"
#include "transports/codecs/native_can/sensors.h"
#include "transports/codecs/native_can/sensors_dbc.h"

/// canmatrix (Debian: python3-canmatrix) reads what the protocol "sensors" sends, with the DBC file
/// that we ship: every type, at the limits and in the middle of its raw values.
namespace tribus::test::sensors_dbc_test {
namespace {

using nlohmann::json;

/// Debian's interpreter: another python3 earlier in PATH would not find Debian's packages.
constexpr std::string_view kPython = "/usr/bin/python3";

struct Sent {
    const SensorType* type = nullptr;
    std::int64_t raw = 0;
    std::string line;  ///< input line of canmatrix_decode.py
};

/// Returns frames with readings of all types that have one field of at most 4 bytes.
std::vector<Sent> readings(const SensorTypes& types) {
    ValueBoard board({{.name = "probes.7.raw", .unit = "", .lasts = kForever}});
    SensorCanEncoder encoder({.sensor_bus = "probes"});
    encoder.use(board);
    std::vector<Sent> all;
    for (const SensorType& type : types.all()) {
        if (type.size > 4 || type.fields.size() != 1) {
            continue;
        }
        const SensorField& field = type.fields.front();
        const std::int64_t values = std::int64_t{1} << field.bits;
        const std::int64_t least = field.least.value_or(field.is_signed ? -values / 2 : 0);
        for (const std::int64_t raw : {least, least + values / 3, least + values - 1}) {
            board.set(0, static_cast<double>(raw), Instant{}, type.id);
            std::array<CanFrame, kMostSnapshotFrames> frames{};
            EXPECT_EQ(encoder.write({}, frames, Instant{}), 1U);
            all.push_back(
                {&type, raw,
                 fmt::format("{} {:02x}\n", frames[0].id, fmt::join(frames[0].bytes(), ""))});
        }
    }
    return all;
}

TEST(SensorsByCanmatrix, HaveTheNumbersOfTheirTypes) {
    const SensorTypes types;
    const std::vector<Sent> sent = readings(types);
    std::string frame_lines;
    for (const Sent& reading : sent) {
        frame_lines += reading.line;
    }
    const TemporaryFolder folder;
    const std::string output =
        run_in_shell(fmt::format("{} '{}/tests/oracle/canmatrix_decode.py' "
                                 "'{}/deploy/can/sensors.dbc' '{}'",
                                 kPython, TRIBUS_SOURCE_DIR, TRIBUS_SOURCE_DIR,
                                 folder.write("frames.txt", frame_lines)))
            .output;
    std::istringstream lines(output);
    std::size_t read = 0;
    for (std::string line; std::getline(lines, line) && read < sent.size();) {
        if (!line.starts_with('{')) {
            continue;  // canmatrix reports formats whose library is missing
        }
        const json theirs = json::parse(line, nullptr, false);
        ASSERT_FALSE(theirs.is_discarded()) << line;
        const Sent& reading = sent[read++];
        SCOPED_TRACE(reading.type->name + " " + std::to_string(reading.raw));
        EXPECT_EQ(theirs.at("message"), "Sensor7");
        EXPECT_EQ(theirs.at("signals").at("type").at("raw"), reading.type->id);
        EXPECT_EQ(theirs.at("signals").at("available").at("raw"), 1);
        const SensorField& field = reading.type->fields.front();
        const double number = static_cast<double>(reading.raw) * field.scale + field.offset;
        EXPECT_NEAR(theirs.at("signals").at(reading.type->name).at("physical").get<double>(),
                    number, 1e-12 * std::abs(number) + 1e-12);
        // The type, three signals of the state and the age, and the reading.
        EXPECT_EQ(theirs.at("signals").size(), 5U);
        ASSERT_FALSE(HasFailure());
    }
    EXPECT_EQ(read, sent.size()) << output.substr(0, 2000);
    EXPECT_GT(sent.size(), 100U);
}

}  // namespace
}  // namespace tribus::test::sensors_dbc_test
