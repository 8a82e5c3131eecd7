#include <algorithm>
#include <cstddef>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/lab/candump.h"
#include "tests/lab/two_programs.h"

/// Other programs on one bus with the built program: can-utils, and canmatrix with the shipped DBC
/// file (Debian: can-utils, python3-canmatrix).
namespace tribus::test::can_clients_test {
namespace {

using nlohmann::json;
using std::chrono::milliseconds;

/// Channels in microseconds as the other program shows them.
using Shown = std::vector<double>;

Shown shown(const Sticks& sticks) {
    return {sticks.begin(), sticks.end()};
}

std::vector<Shown> shown(const std::vector<Sticks>& rows) {
    std::vector<Shown> all;
    for (const Sticks& sticks : rows) {
        all.push_back(shown(sticks));
    }
    return all;
}

/// Both limits of SBUS, each channel with a value of its own, and usual sticks.
std::vector<Sticks> stick_positions() {
    Sticks ascending;
    Sticks odd;
    for (int channel = 0; channel < 18; ++channel) {
        ascending.push_back(880 + 75 * channel);
        odd.push_back(2001 - 2 * channel);
    }
    Sticks crossed(18, 880);
    crossed[0] = crossed[15] = crossed[17] = 2159;
    return {sticks_with_first(1001), Sticks(18, 880), Sticks(18, 2159), ascending, odd, crossed};
}

/// Adds a value unless it equals the last one.
template <class Value>
void add_if_new(std::vector<Value>& values, const Value& value) {
    if (values.empty() || values.back() != value) {
        values.push_back(value);
    }
}

/// Converts a line of `candump -L` such as "(1436509052.249713) vcan0 305##1AABB" for
/// canmatrix_decode.py: id and data.
std::string id_and_data(const std::string& line) {
    const std::size_t start = line.rfind(' ') + 1;
    const std::size_t mark = line.find('#', start);
    const bool fd = line[mark + 1] == '#';
    const auto id = std::stoul(line.substr(start, mark - start), nullptr, 16);
    return std::to_string(id) + " " + line.substr(mark + (fd ? 3 : 1));
}

/// Returns the good snapshots in a log as canmatrix decodes them, without repetitions.
std::vector<Shown> seen_by_canmatrix(const std::string& folder, const std::string& log) {
    std::ofstream frames(folder + "/frames");
    std::istringstream lines(log);
    for (std::string line; std::getline(lines, line);) {
        frames << id_and_data(line) << '\n';
    }
    frames.close();
    const std::string source = TRIBUS_SOURCE_DIR;
    // Debian's interpreter: another python3 earlier in PATH would not find Debian's packages.
    shell("/usr/bin/python3 " + source + "/tests/oracle/canmatrix_decode.py " + source +
          "/deploy/can/native.dbc " + folder + "/frames >" + folder + "/decoded");
    std::vector<Shown> snapshots;
    Shown channels;
    bool good = true;
    std::ifstream decoded(folder + "/decoded");
    for (std::string line; std::getline(decoded, line);) {
        const json frame = json::parse(line);
        const std::string message = frame["message"];
        for (const auto& [name, value] : frame["signals"].items()) {
            if (name.starts_with(message + "_Ch") && name.size() == message.size() + 5) {
                channels.resize(18);
                channels[std::stoul(name.substr(message.size() + 3)) - 1] = value["physical"];
            } else if (name == message + "_Failsafe" || name == message + "_FrameLost") {
                good = good && value["raw"] == 0;
            }
        }
        if (message == "RcE" || message == "RcFd") {
            if (good) {
                add_if_new(snapshots, channels);
            }
            good = true;
        }
    }
    return snapshots;
}

/// Returns the good snapshots as `tribus decode` prints them.
std::vector<Shown> seen_by_decode(const std::string& output) {
    std::vector<Shown> snapshots;
    std::istringstream lines(output);
    for (std::string line; std::getline(lines, line);) {
        const json frame = json::parse(line);
        if (frame.contains("channels") && !frame["failsafe"] && !frame["frame_lost"]) {
            add_if_new(snapshots, frame["channels"].get<Shown>());
        }
    }
    return snapshots;
}

class CanClient : public TwoPrograms {
  protected:
    static ProgramSettings tool(const std::string& name) {
        return {.executable = "/usr/bin/" + name};
    }
    std::string write(const std::string& name, const std::string& text) const {
        std::ofstream(folder() / name) << text;
        return folder() / name;
    }
    VirtualBus bus_;
};

struct LogCase {
    std::string name;
    std::string format;
    std::string decode_options;
};

class CandumpLog : public CanClient, public testing::WithParamInterface<LogCase> {
  protected:
    /// Returns what `candump -L` writes while the receiver sends each row of sticks until the
    /// servos have it.
    std::string record(const std::vector<Sticks>& rows) {
        Candump candump(folder(), "vcan0");
        const BusJob job{.format = GetParam().format};
        Program& sender = start_sender(job);
        Program& reader = start_reader(job);
        for (const Sticks& sticks : rows) {
            Repeater repeater(receiver(), ibus_bytes(sticks));
            const SbusSight wanted = sbus_sight_of(sticks);
            EXPECT_TRUE(eventually([&] {
                repeater.send_if_due();
                return std::ranges::any_of(servos().listen(), [&](const SbusSight& sight) {
                    return sight.good() && same_channels(sight, wanted);
                });
            })) << sender.errors()
                << reader.errors();
        }
        expect_clean_end(sender);
        expect_clean_end(reader);
        return candump.log();
    }
};

INSTANTIATE_TEST_SUITE_P(Formats, CandumpLog,
                         testing::Values(LogCase{"classic", "protocol = \"can\"", ""},
                                         LogCase{"fd", "protocol = \"can\"\nfd = true",
                                                 "--fd true "}),
                         [](const auto& test) { return test.param.name; });

TEST_P(CandumpLog, HasTheSticksForCanmatrixWithTheShippedDbc) {
    const auto rows = stick_positions();
    EXPECT_EQ(seen_by_canmatrix(folder(), record(rows)), shown(rows));
}

TEST_P(CandumpLog, HasTheSticksForDecode) {
    const auto rows = stick_positions();
    const std::string log = write("log", record(rows));
    const std::string output =
        shell(std::string(TRIBUS_PROGRAM) + " decode --protocol can " + GetParam().decode_options +
              "--format json " + log + " 2>" + folder().string() + "/talk");
    EXPECT_EQ(seen_by_decode(output), shown(rows));
}

class Canplayer : public CanClient {
  protected:
    /// Returns a log in which each row of sticks is repeated in `repetitions` snapshots, 10 ms
    /// apart.
    std::string encoded_log(const std::vector<Sticks>& rows, int repetitions) {
        std::string lines;
        int snapshot = 0;
        for (const Sticks& sticks : rows) {
            for (int i = 0; i < repetitions; ++i) {
                const json frame{{"t_us", 10'000 * ++snapshot},
                                 {"protocol", "can"},
                                 {"channels", sticks},
                                 {"frame_lost", false},
                                 {"failsafe", false}};
                lines += frame.dump() + "\n";
            }
        }
        const std::string log = folder() / "log";
        shell(std::string(TRIBUS_PROGRAM) + " encode --protocol can --interface vcan0 " +
              write("lines", lines) + " >" + log);
        return log;
    }
};

TEST_F(Canplayer, MovesTheServosAsTheEncodedLogSaysAndItsEndIsFailsafe) {
    const auto rows = stick_positions();
    const std::string log = encoded_log(rows, 80);
    Program& reader = start_reader({});
    std::vector<Shown> seen;
    const auto note = [&](const SbusSight& sight) {
        if (sight.good()) {
            Shown channels(sight.raw.begin(), sight.raw.end());
            channels.push_back(sight.channel_17 ? 1 : 0);
            channels.push_back(sight.channel_18 ? 1 : 0);
            add_if_new(seen, channels);
        }
    };
    Program player(folder(), {"-I", log}, tool("canplayer"));
    EXPECT_TRUE(eventually([&] {
        std::ranges::for_each(servos().listen(), note);
        return !player.runs();
    })) << player.errors();
    bool failsafe = false;
    EXPECT_TRUE(eventually([&] {
        for (const SbusSight& sight : servos().listen()) {
            note(sight);
            failsafe = failsafe || sight.failsafe;
        }
        return failsafe;
    })) << reader.errors();

    std::vector<Shown> wanted;
    for (const Sticks& sticks : rows) {
        const SbusSight sight = sbus_sight_of(sticks);
        wanted.emplace_back(sight.raw.begin(), sight.raw.end());
        wanted.back().push_back(sight.channel_17 ? 1 : 0);
        wanted.back().push_back(sight.channel_18 ? 1 : 0);
    }
    EXPECT_EQ(seen, wanted) << reader.errors();
    expect_clean_end(reader);
}

class Cansend : public CanClient {
  protected:
    /// Sends each frame three times in the middle of a stream, the first once more by itself. Good
    /// frames must still have the receiver's sticks, and the programs must go on. Returns what the
    /// servos saw.
    std::vector<SbusSight> send_amid_stream(const std::string& interface,
                                            const std::vector<std::string>& frames) {
        EXPECT_TRUE(carry_until_control());
        std::vector<SbusSight> all;
        const auto carry = [&](milliseconds time) {
            const auto sights = carry_for(time);
            all.insert(all.end(), sights.begin(), sights.end());
        };
        std::string log;
        for (std::size_t i = 0; i < 3 * frames.size(); ++i) {
            log += fmt::format("({:.6f}) {} {}\n", 0.03 * static_cast<double>(i), interface,
                               frames[i / 3]);
        }
        const auto run = [&](const std::vector<std::string>& arguments, const std::string& name) {
            Program client(folder(), arguments, tool(name));
            while (client.runs()) {
                carry(milliseconds(10));
            }
            EXPECT_EQ(client.end(), 0) << client.errors();
        };
        run({interface, frames.front()}, "cansend");
        // A process for each frame takes a second where the kernel is a program.
        run({"-I", write("frames.log", log)}, "canplayer");
        // Gives the programs time to log.
        carry(milliseconds(500));
        const SbusSight sticks = sbus_sight_of(sticks_with_first(1234));
        EXPECT_TRUE(std::ranges::all_of(all, [&](const SbusSight& sight) {
            return !sight.good() || same_channels(sight, sticks);
        }));
        EXPECT_TRUE(carry_until_control());
        return all;
    }
    /// Checks that the frames are reported as those of another sender with the same ids.
    void expect_named(const std::string& format, const std::vector<std::string>& frames) {
        const BusJob job{.format = format};
        Program& sender = start_sender(job);
        Program& reader = start_reader(job);
        send_amid_stream("vcan0", frames);
        EXPECT_TRUE(sender.says("another node sends frames with its ids"));
        expect_clean_end(sender);
        expect_clean_end(reader);
    }
    void expect_not_named(const std::string& format, const std::vector<std::string>& frames) {
        const BusJob job{.format = format};
        Program& sender = start_sender(job);
        Program& reader = start_reader(job);
        send_amid_stream("vcan0", frames);
        EXPECT_EQ(count_of("another node", sender.errors()), 0U) << sender.errors();
        expect_clean_end(sender);
        expect_clean_end(reader);
    }
};

constexpr const char* kClassic = "protocol = \"can\"";
constexpr const char* kFd = "protocol = \"can\"\nfd = true";

TEST_F(Cansend, FramesWithOurIdsOfWrongLengthAreNamedAndNeverObeyed) {
    expect_named(kClassic, {"300#", "301#DEADBEEF", "304#01020304050607"});
}

TEST_F(Cansend, FramesWithOurIdsAndWrongChecksumsAreNamedAndNeverObeyed) {
    expect_named(kClassic,
                 {"302#0102030405060708", "300#0000000000000000", "304#FFFFFFFFFFFFFFFF"});
}

TEST_F(Cansend, FdFramesWithOurClassicIdsAreNamedAndNeverObeyed) {
    expect_named(kClassic, {"300##1DEADBEEF", "304##00102030405060708"});
}

TEST_F(Cansend, WrongFramesWithOurFdIdAreNamedAndNeverObeyed) {
    expect_named(kFd, {"305#0102030405060708", "305#", "305##1DEADBEEF"});
}

TEST_F(Cansend, RemoteAndExtendedFramesAndOtherIdsAreNoneOfOurs) {
    expect_not_named(kClassic, {"300#R", "304#R8", "00000300#0102030405060708",
                                "1FFFF301#0102030405060708", "2FF#0102030405060708", "305#01",
                                "305##1DEADBEEF", "7FF#", "000#0102030405060708"});
}

TEST_F(Cansend, RemoteAndExtendedFramesAndClassicIdsAreNoneOfOursOnFd) {
    expect_not_named(kFd, {"305#R", "00000305##1DEADBEEF", "300#0102030405060708"});
}

/// The sender is behind a gateway and does not receive these frames.
TEST_F(Cansend, WrongFramesThatOnlyTheReaderHearsDoNotEndControl) {
    const VirtualBus far("vcan1");
    shell("modprobe can-gw && cangw -A -s vcan0 -d vcan1 -e");
    Program& sender = start_sender({});
    Program& reader = start_reader({.reader_interface = "vcan1"});
    const auto seen = send_amid_stream(
        "vcan1", {"300#", "301#DEADBEEF", "302#0102030405060708", "300#0000000000000000",
                  "304#FFFFFFFFFFFFFFFF", "300##1DEADBEEF", "304##00102030405060708", "300#R"});
    // A machine that stopped the receiver or a program for so long ends control too.
    const std::size_t stops = outages() + count_of("did not run", sender.errors()) +
                              count_of("did not run", reader.errors());
    EXPECT_TRUE(stops > 0 || std::ranges::none_of(seen, &SbusSight::failsafe)) << reader.errors();
    shell("cangw -F");
    expect_clean_end(sender);
    expect_clean_end(reader);
}

}  // namespace
}  // namespace tribus::test::can_clients_test
