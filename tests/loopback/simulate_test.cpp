#include <sys/resource.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/loopback/loopback.h"
#include "tests/support/sanitized.h"

namespace tribus::test::simulate_test {
namespace {

using Json = nlohmann::json;

struct Burst {
    std::int64_t at_us = 0;
    Bytes bytes;
};

std::vector<Burst> read_timed(const std::filesystem::path& path) {
    std::vector<Burst> bursts;
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
        if (line.empty() || line.front() == '#') {
            continue;
        }
        std::istringstream words(line);
        Burst& burst = bursts.emplace_back();
        words >> burst.at_us >> std::hex;
        for (unsigned byte = 0; words >> byte;) {
            burst.bytes.push_back(static_cast<std::uint8_t>(byte));
        }
    }
    return bursts;
}

std::string timed_line(std::int64_t at_us, const Bytes& bytes) {
    std::ostringstream line;
    line << at_us << std::hex;
    for (const std::uint8_t byte : bytes) {
        line << ' ' << (byte < 0x10 ? "0" : "") << static_cast<unsigned>(byte);
    }
    line << '\n';
    return line.str();
}

/// A frame of the receiver: when its last bit arrived, and what the servos should see.
struct Arrival {
    std::int64_t at_us = 0;
    SbusSight sight;
};

/// 32 bytes of 10 bits at 115200 baud take 2777.8 us. Simulated frames are written whole.
constexpr std::int64_t kFrameUs = 2778;
/// Times in the files are rounded to whole microseconds.
constexpr std::int64_t kRoundingUs = 1;
constexpr std::int64_t kPeriodUs = 7000;
/// Behind a late frame or a repeat one may come this early (docs/channels.md, "When an output
/// sends").
constexpr std::int64_t kLeastSpacingUs = 6000;
constexpr std::int64_t kTimeoutUs = 100'000;
/// The same as `recover`.
constexpr std::int64_t kPowerOnUs = 500'000;
constexpr std::int64_t kHoldUs = 300'000;

SbusSight sight_of_raw(const Json& frame) {
    SbusSight sight;
    for (std::size_t i = 0; i < sight.raw.size(); ++i) {
        sight.raw[i] = frame["raw"][i].get<int>();
    }
    sight.channel_17 = frame["channels"][16].get<double>() > 1500;
    sight.channel_18 = frame["channels"][17].get<double>() > 1500;
    sight.frame_lost = frame["frame_lost"].get<bool>();
    sight.failsafe = frame["failsafe"].get<bool>();
    return sight;
}

/// An emulated board takes a minute for what a real one does in seconds.
constexpr std::chrono::seconds kMinutes{120};

class Simulate : public Loopback {
  protected:
    std::filesystem::path simulate(const std::filesystem::path& recording) {
        std::filesystem::path out = folder() / "servos.txt";
        Program& program =
            start({"simulate", write_config(main_job()), "--in", "receiver=" + recording.string(),
                   "--out", "servos=" + out.string()});
        EXPECT_EQ(program.end(kMinutes), 0) << program.errors();
        return out;
    }
    /// Returns the frames that `tribus decode` reads from the file, with their times.
    std::vector<Arrival> decode(const std::filesystem::path& out, std::size_t frames_written) {
        Program& program =
            start({"decode", "--protocol", "sbus", "--format", "json", out.string()});
        EXPECT_EQ(program.end(), 0) << program.errors();
        std::vector<Arrival> frames;
        std::istringstream lines(program.output());
        Json summary;
        for (std::string line; std::getline(lines, line);) {
            const Json object = Json::parse(line);
            if (object.contains("summary")) {
                summary = object["summary"];
            } else {
                frames.push_back({object["t_us"].get<std::int64_t>(), sight_of_raw(object)});
            }
        }
        EXPECT_EQ(frames.size(), frames_written);
        EXPECT_EQ(summary["frames"], frames_written);
        for (const auto& cause : summary["rejected"]) {
            EXPECT_EQ(cause, 0) << summary;
        }
        return frames;
    }

    static void expect_least_gap(const std::vector<Arrival>& frames) {
        for (std::size_t i = 1; i < frames.size(); ++i) {
            EXPECT_GE(frames[i].at_us - frames[i - 1].at_us, kLeastSpacingUs - kRoundingUs);
        }
        for (std::size_t i = 10; i < frames.size(); ++i) {
            EXPECT_GE(frames[i].at_us - frames[i - 10].at_us, 9 * kPeriodUs - kRoundingUs);
        }
    }
    /// Checks that frames carry the newest input while there is one, are marked within the timeout
    /// after the last one, and are in failsafe after the hold time.
    static void expect_each_right(const std::vector<Arrival>& frames,
                                  const std::vector<Arrival>& inputs) {
        const std::int64_t last_us = inputs.back().at_us;
        // The default: throttle low, all other channels centred.
        Sticks defaults(18, 1500);
        defaults[2] = 988;
        const SbusSight presets = sbus_sight_of(defaults);
        std::size_t newest = 0;
        std::size_t held = 0;
        for (const Arrival& frame : frames) {
            while (newest + 1 < inputs.size() &&
                   inputs[newest + 1].at_us <= frame.at_us + kRoundingUs) {
                ++newest;
            }
            const bool before = frame.at_us + kRoundingUs < inputs.front().at_us + kPowerOnUs;
            const std::int64_t age = frame.at_us - last_us;
            SCOPED_TRACE("frame at " + std::to_string(frame.at_us) + " us");
            if (before || age >= kTimeoutUs + kHoldUs) {
                EXPECT_TRUE(frame.sight.failsafe && frame.sight.frame_lost);
                EXPECT_TRUE(same_channels(frame.sight, presets));
                continue;
            }
            if (age >= kTimeoutUs) {
                EXPECT_TRUE(frame.sight.frame_lost);
            } else if (age <= kTimeoutUs - kPeriodUs - kRoundingUs) {
                EXPECT_TRUE(frame.sight.good());
            }
            held += frame.sight.frame_lost && !frame.sight.failsafe ? 1 : 0;
            EXPECT_TRUE(frame.sight.failsafe || same_channels(frame.sight, inputs[newest].sight));
        }
        EXPECT_GE(held, static_cast<std::size_t>(kHoldUs / kPeriodUs / 2));
        EXPECT_GE(frames.back().at_us - last_us, 1'900'000) << "the tail is shorter than 2 s";
    }
};

TEST_F(Simulate, RefusesARecordingWhoseTimesJump) {
    const std::string recording = folder() / "gap.txt";
    std::ofstream(recording) << timed_line(0, {0x20}) << timed_line(7000, {0x40})
                             << timed_line(7'300'000'000, {0x20});
    Program& program =
        start({"simulate", write_config(main_job()), "--in", "receiver=" + recording});
    EXPECT_EQ(program.end(kMinutes), 1);
    EXPECT_NE(program.errors().find(recording + ":3:1: the times jump by 2.0 hours here"),
              std::string::npos)
        << program.errors();
}

TEST_F(Simulate, MainJobCarriesTheNewestInputThenMarksTheLossThenFailsafe) {
    std::vector<Arrival> inputs;
    std::ofstream file(folder() / "receiver.txt");
    file << "# t_us bytes\n";
    for (int number = 0; number < 500; ++number) {
        Sticks sticks = sticks_with_first(1000 + number);
        sticks[4] = 2000 - number;
        const std::int64_t start_us = 20'000 + 4000 * number;
        inputs.push_back({start_us + kFrameUs, sbus_sight_of(sticks)});
        file << timed_line(start_us, ibus_bytes(sticks));
    }
    file.close();
    const std::filesystem::path out = simulate(folder() / "receiver.txt");
    const std::vector<Arrival> frames = decode(out, read_timed(out).size());
    ASSERT_FALSE(frames.empty());
    expect_least_gap(frames);
    expect_each_right(frames, inputs);
}

TEST_F(Simulate, NeedsNoMoreMemoryForALongRecordingAndDecodeNeither) {
    if (kSanitized) {
        GTEST_SKIP() << "a sanitizer keeps what was freed";
    }
    const auto peak_with = [&](int frames) {
        const std::string bytes = folder() / "receiver.txt";
        const std::string log = folder() / "can.log";
        std::ofstream bytes_file(bytes);
        std::ofstream log_file(log);
        for (int number = 0; number < frames; ++number) {
            bytes_file << timed_line(7000 * number, ibus_bytes(sticks_with_first(1500)));
            log_file << '(' << number << ".5) can0 123#00112233445566\n";
        }
        bytes_file.close();
        log_file.close();
        long peak_kib = 0;
        const auto run = [&](const std::vector<std::string>& words, int status) {
            Program& program = start(words);
            EXPECT_EQ(program.end(kMinutes), status) << program.errors();
            peak_kib = std::max(peak_kib, program.peak_kib());
        };
        run({"simulate", write_config(main_job()), "--in", "receiver=" + bytes, "--out",
             "servos=" + (folder() / "servos.txt").string()},
            0);
        run({"decode", "--protocol", "ibus", bytes}, 0);
        run({"decode", bytes}, 0);
        run({"decode", log}, 1);  // no protocol has its id
        return peak_kib;
    };
    const long peak_of_short = peak_with(1'000);
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    const long most_kib = std::max(30 * 1024L, usage.ru_maxrss);
    const long peak_of_long = peak_with(40'000);
    EXPECT_LE(peak_of_long, most_kib);
    EXPECT_LE(peak_of_long, peak_of_short + 1024) << "the recordings have 4 MB and 1 MB";
}

TEST_F(Simulate, RefusesToOverwriteTheRecordingThatItReads) {
    const std::filesystem::path recording = folder() / "receiver.txt";
    std::ofstream(recording) << timed_line(0, ibus_bytes(sticks_with_first(1500)));
    const auto size = std::filesystem::file_size(recording);
    const std::filesystem::path other_name = folder() / "other.txt";
    std::filesystem::create_symlink(recording, other_name);
    Program& program =
        start({"simulate", write_config(main_job()), "--in", "receiver=" + recording.string(),
               "--out", "servos=" + other_name.string()});
    EXPECT_EQ(program.end(), 2);
    EXPECT_NE(program.errors().find("--in reads this file"), std::string::npos) << program.errors();
    EXPECT_EQ(std::filesystem::file_size(recording), size);
}

TEST_F(Simulate, PlaysARecordingUntilItsMistakeAndSaysWhereThatIs) {
    std::ofstream file(folder() / "receiver.txt");
    for (int number = 0; number < 200; ++number) {
        file << timed_line(7000 * number, ibus_bytes(sticks_with_first(1500)));
    }
    file << "1400000 2g\n";
    file.close();
    const std::filesystem::path out = folder() / "servos.txt";
    Program& program = start({"simulate", write_config(main_job()), "--in",
                              "receiver=" + (folder() / "receiver.txt").string(), "--out",
                              "servos=" + out.string()});
    EXPECT_EQ(program.end(), 1);
    EXPECT_NE(program.errors().find("receiver.txt:201:9: \"2g\" is not a byte"), std::string::npos)
        << program.errors();
    EXPECT_GT(read_timed(out).size(), 100U);
}

/// A FlySky AFHDS3 receiver, 18 channels every 4 ms (tests/captures/receivers.cpp).
TEST_F(Simulate, MainJobOverARealReceiversRecording) {
    for (const Capture capture : captures()) {
        SCOPED_TRACE(capture_name(capture));
        const auto recording = file_of("ibus_servo18_afhds3.timed.txt", capture, folder());
        const std::vector<Sticks> rows = channel_rows("ibus_servo18_afhds3.channels.csv", capture);
        std::vector<Arrival> inputs;
        for (const Burst& burst : read_timed(recording)) {
            if (burst.bytes.size() == 32 && inputs.size() < rows.size()) {
                inputs.push_back({burst.at_us + kFrameUs, sbus_sight_of(rows[inputs.size()])});
            }
        }
        ASSERT_EQ(inputs.size(), rows.size());
        const std::filesystem::path out = simulate(recording);
        const std::vector<Arrival> frames = decode(out, read_timed(out).size());
        ASSERT_FALSE(frames.empty());
        expect_least_gap(frames);
        expect_each_right(frames, inputs);
    }
}

/// A battery on a CAN bus is a sensor of a receiver. The receiver asks before the message came,
/// after it came, and when it is stale.
TEST_F(Simulate, PlaysMessagesAndSensorBusesToo) {
    std::ofstream(folder() / "battery.dbc") << "BO_ 291 Battery: 2 A\n"
                                               " SG_ Voltage : 0|16@1+ (1,0) [0|0] \"mV\" B\n";
    const std::string config = write_config(R"(
[values.battery]
interface = "can0"
dbc = "battery.dbc"
message = "Battery"
[sensor_bus.telemetry]
device = "/dev/nowhere"
role = "sensor"
[[sensor_bus.telemetry.sensor]]
type = "external_voltage"
value = "battery.Voltage"
)");
    std::ofstream(folder() / "bus.log") << "(1.000000) can0 123#3430\n";
    std::ofstream(folder() / "asked.txt") << "# t_us\n100 04 81 7a ff\n8000 04 a1 5a ff\n"
                                             "1600000 04 a1 5a ff\n";
    Program& program =
        start({"simulate", config, "--in", "battery=" + (folder() / "bus.log").string(), "--in",
               "telemetry=" + (folder() / "asked.txt").string(), "--out",
               "telemetry=" + (folder() / "said.txt").string()});
    EXPECT_EQ(program.end(), 0) << program.errors();
    const auto said = read_timed(folder() / "said.txt");
    ASSERT_EQ(said.size(), 3U) << program.errors();
    EXPECT_EQ(said[0].bytes, (Bytes{0x04, 0x81, 0x7A, 0xFF}));
    EXPECT_EQ(said[1].bytes, (Bytes{0x06, 0xA1, 0xD2, 0x04, 0x82, 0xFE})) << "12340 mV are 12.34 V";
    EXPECT_EQ(said[2].bytes, (Bytes{0x06, 0xA1, 0x00, 0x80, 0xD8, 0xFE})) << "not available";
    EXPECT_NE(program.errors().find("sensor bus telemetry: 3 requests, 3 answered"),
              std::string::npos)
        << program.errors();
}

/// The same with DroneCAN: "batteryinfo" of tests/vectors/dronecan_vectors.json, which is 16.5 V.
TEST_F(Simulate, PlaysMessagesOfDroneCanToo) {
    const std::string config = write_config(R"(
[values.battery]
interface = "can0"
dronecan = "uavcan.equipment.power.BatteryInfo"
[sensor_bus.telemetry]
device = "/dev/nowhere"
role = "sensor"
[[sensor_bus.telemetry.sensor]]
type = "external_voltage"
value = "battery.voltage"
)");
    std::ofstream(folder() / "bus.log") << "(1.000000) can0 1004441E#23F9A85C204C2086\n"
                                           "(1.000200) can0 1004441E#4A505A4052A05426\n"
                                           "(1.000400) can0 1004441E#0000011FE2030006\n"
                                           "(1.000600) can0 1004441E#000000006C697026\n"
                                           "(1.000800) can0 1004441E#6F347346\n";
    std::ofstream(folder() / "asked.txt") << "# t_us\n4000 04 81 7a ff\n12000 04 a1 5a ff\n"
                                             "2900000 04 a1 5a ff\n3100000 04 a1 5a ff\n";
    Program& program =
        start({"simulate", config, "--in", "battery=" + (folder() / "bus.log").string(), "--in",
               "telemetry=" + (folder() / "asked.txt").string(), "--out",
               "telemetry=" + (folder() / "said.txt").string()});
    EXPECT_EQ(program.end(), 0) << program.errors();
    const auto said = read_timed(folder() / "said.txt");
    ASSERT_EQ(said.size(), 4U) << program.errors();
    const Bytes volts_16_50{0x06, 0xA1, 0x72, 0x06, 0xE0, 0xFE};
    EXPECT_EQ(said[1].bytes, volts_16_50);
    EXPECT_EQ(said[2].bytes, volts_16_50);
    EXPECT_EQ(said[3].bytes, (Bytes{0x06, 0xA1, 0x00, 0x80, 0xD8, 0xFE})) << "after 3 s";
}

}  // namespace
}  // namespace tribus::test::simulate_test
