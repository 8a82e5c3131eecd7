#include <algorithm>
#include <cctype>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/captures/recordings.h"
#include "tests/support/shell.h"
#include "transports/recordings/recording.h"

/// Compares with an independent reader: tshark must find the ids, data and times in the logs of CAN
/// frames.
namespace tribus::tshark_test {
namespace {

using test::Ended;
using test::run_in_shell;
using test::TemporaryFolder;

using Rows = std::vector<std::string>;

constexpr const char* kClassic = R"(
[input.receiver]
protocol = "ibus"
device = "/dev/ttyAMA5"
[output.bus]
protocol = "can"
interface = "can0"
[pipeline.main]
from = "receiver"
to = "bus"
)";

std::string with_setting(std::string config, const std::string& line) {
    const std::string place = "interface = \"can0\"\n";
    return config.insert(config.find(place) + place.size(), line);
}

Rows lines_of(const std::string& text) {
    Rows lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) {
        lines.push_back(line);
    }
    return lines;
}

/// Returns rows of `id<tab>data in hex`, as tshark prints them.
Rows rows_in(const std::string& log) {
    Rows rows;
    const auto recording = parse_recording(log, "can.log");
    EXPECT_TRUE(recording) << recording.error();
    for (const RecordedCanFrame& recorded : recording.value_or(Recording{}).can_frames) {
        std::ostringstream row;
        row << recorded.frame.id << '\t' << std::hex;
        for (const std::uint8_t byte : recorded.frame.bytes()) {
            row << (byte < 0x10 ? "0" : "") << static_cast<unsigned>(byte);
        }
        rows.push_back(row.str());
    }
    return rows;
}

class Tshark : public testing::Test {
  protected:
    void SetUp() override {
        if (run_in_shell("command -v tshark").status != 0) {
            GTEST_SKIP() << "tshark is not installed (Debian: tshark)";
        }
    }
    Ended run(const std::string& command) const {
        return run_in_shell("cd '" + folder / "" + "'; " + command);
    }
    /// Sends 18 channels of an i.Bus receiver through a pipeline whose output is on CAN.
    std::string simulate(const std::string& config, const std::string& recording) const {
        folder.write("config.toml", config);
        const Ended result = run("\"$TRIBUS\" simulate config.toml --in 'receiver=" + recording +
                                 "' --out bus=can.log");
        EXPECT_EQ(result.status, 0) << result.output;
        return folder.read("can.log");
    }
    std::string receiver() const {
        std::string lines;
        for (int frame = 0; frame < 100; ++frame) {
            lines += "{\"t_us\":" + std::to_string(7000 * frame) + ",\"channels\":[";
            for (int channel = 0; channel < 18; ++channel) {
                lines += (channel > 0 ? "," : "") + std::to_string(1000 + 40 * channel + frame);
            }
            lines += "]}\n";
        }
        folder.write("frames.json", lines);
        run("\"$TRIBUS\" encode --protocol ibus --format timed frames.json > ibus.txt");
        return folder / "ibus.txt";
    }
    Rows seen(const std::string& fields) const {
        return lines_of(run("tshark -r can.log -T fields " + fields + " 2>/dev/null").output);
    }
    TemporaryFolder folder;
};

/// Number of flags that are set. tshark 4.4 prints "True" where 4.0 prints "1".
std::ptrdiff_t set_in(const Rows& flags) {
    return std::ranges::count(flags, "1") + std::ranges::count(flags, "True");
}

TEST_F(Tshark, SeesTheClassicFramesOfAPipeline) {
    const std::string log = simulate(kClassic, receiver());
    ASSERT_GT(rows_in(log).size(), 500U);
    EXPECT_EQ(seen("-e can.id -e data.data"), rows_in(log));
}

TEST_F(Tshark, SeesTheFramesWithExtendedIdsOfAPipeline) {
    const std::string log =
        simulate(with_setting(kClassic, "id = 0x18FF0000\nextended = true\n"), receiver());
    ASSERT_GT(rows_in(log).size(), 500U);
    EXPECT_EQ(seen("-e can.id -e data.data"), rows_in(log));
    const Rows extended = seen("-e can.flags.xtd");
    EXPECT_EQ(set_in(extended), std::ssize(rows_in(log)));
}

TEST_F(Tshark, SeesTheFdFramesOfAPipeline) {
    const std::string log = simulate(with_setting(kClassic, "fd = true\n"), receiver());
    ASSERT_GT(rows_in(log).size(), 100U);
    EXPECT_EQ(seen("-e can.id -e data.data"), rows_in(log));
    const Rows switched = seen("-e canfd.flags.brs");
    EXPECT_EQ(set_in(switched), std::ssize(rows_in(log)));
}

/// A FlySky AFHDS3 receiver (tests/captures/receivers.cpp).
TEST_F(Tshark, SeesWhatAPipelineMakesOfARealReceiver) {
    for (const test::Capture capture : test::captures()) {
        SCOPED_TRACE(test::capture_name(capture));
        const std::string log = simulate(
            kClassic, test::file_of("ibus_servo18_afhds3.timed.txt", capture, folder / ""));
        ASSERT_GT(rows_in(log).size(), 500U);
        EXPECT_EQ(seen("-e can.id -e data.data"), rows_in(log));
    }
}

TEST_F(Tshark, SeesTheTimesOfALog) {
    folder.write("frames.json",
                 "{\"t_us\":1,\"channels\":[1500]}\n{\"t_us\":123456789,\"channels\":[1500]}\n");
    run("\"$TRIBUS\" encode --protocol can --fd true frames.json > can.log");
    EXPECT_EQ(seen("-e frame.time_epoch"), (Rows{"0.000001000", "123.456789000"}));
}

}  // namespace
}  // namespace tribus::tshark_test
