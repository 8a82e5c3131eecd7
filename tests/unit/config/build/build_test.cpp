#include "config/build/build.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/streams.h"
#include "tests/unit/config/main_job.h"
#include "transports/codecs/ibus/ibus.h"
#include "transports/links/can/can_medium.h"
#include "transports/links/serial/serial_medium.h"

namespace tribus::test::build_test {
namespace {

using namespace std::chrono_literals;
using enum StationKind;

const std::string kProbes = "[sensor_bus.probes]\nrole = \"receiver\"\ndevice = \"/dev/ttyS\"\n";
const std::string kPack =
    "[values.pack]\ninterface = \"can0\"\ndronecan = \"uavcan.equipment.power.BatteryInfo\"\n";
const std::string kCells = "[values.cells]\nconstant = 6\n";

std::vector<PortPlan> plans(const std::string& more) {
    return plan_ports(loaded(main_job_with(10, more)));
}

TEST(PlannedPorts, AreOneForEachDevice) {
    const auto ports = plans("");
    ASSERT_EQ(ports.size(), 2U);
    EXPECT_EQ(ports[0].config.device, "/dev/ttyA");
    EXPECT_EQ(ports[0].config.medium, &kSerialMedium);
    EXPECT_EQ(ports[0].wiring.stations, (std::vector<Station>{{input, 0}}));
    EXPECT_EQ(ports[0].wiring.byte_time, 86806ns) << "10 bits at 115200 baud";
    EXPECT_FALSE(ports[0].wiring.has_datagrams);
    EXPECT_FALSE(ports[0].wiring.answers);
    EXPECT_EQ(ports[0].period, Duration::zero());
    EXPECT_EQ(ports[1].config.device, "/dev/ttyB");
    EXPECT_EQ(ports[1].wiring.stations, (std::vector<Station>{{output, 0}}));
    EXPECT_EQ(ports[1].wiring.byte_time, 120us) << "12 bits at 100000 baud";
}

TEST(PlannedPorts, AreSharedByAnInputAndAnOutputOfOneDevice) {
    const auto ports =
        plan_ports(loaded("[input.receiver]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyA\"\n"
                          "[output.servos]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyA\"\n" +
                          std::string(kPipelineTable)));
    ASSERT_EQ(ports.size(), 1U);
    EXPECT_EQ(ports[0].wiring.stations, (std::vector<Station>{{input, 0}, {output, 0}}));
}

TEST(PlannedPorts, HaveThreadsInRealTimeUnlessThatIsOff) {
    EXPECT_TRUE(plans("")[1].realtime);
    EXPECT_TRUE(plans("[runtime]\nrealtime = \"require\"\n")[0].realtime);
    EXPECT_FALSE(plans("[runtime]\nrealtime = \"off\"\n")[0].realtime);
    EXPECT_FALSE(plans("[runtime]\nrealtime = \"off\"\n")[1].realtime);
}

TEST(PlannedPorts, AreReadForValuesOnlyWhereSomebodyNeedsThem) {
    EXPECT_EQ(plans(kCells + kPack).size(), 2U);
    const auto ports = plans(kCells + kPack + kProbes);
    ASSERT_EQ(ports.size(), 4U);
    EXPECT_EQ(ports[2].config.device, "/dev/ttyS");
    EXPECT_EQ(ports[2].wiring.stations, (std::vector<Station>{{sensor_bus, 0}}));
    EXPECT_EQ(ports[2].wiring.byte_time, Duration::zero()) << "it is read at once";
    EXPECT_EQ(ports[3].config.medium, &kCanMedium);
    EXPECT_EQ(ports[3].wiring.stations, (std::vector<Station>{{value_message, 0}}));
    EXPECT_EQ(ports[3].wiring.byte_time, Duration::zero());
}

TEST(PlannedPorts, CountMessagesOfValuesAlone) {
    const auto ports = plans(kPack + kCells +
                             "[values.more]\ninterface = \"can1\"\ndronecan = "
                             "\"uavcan.equipment.power.CircuitStatus\"\n" +
                             kProbes);
    ASSERT_EQ(ports.size(), 5U);
    EXPECT_EQ(ports[3].wiring.stations, (std::vector<Station>{{value_message, 0}}));
    EXPECT_EQ(ports[4].config.device, "can1");
    EXPECT_EQ(ports[4].wiring.stations, (std::vector<Station>{{value_message, 1}}));
}

LinkUse use_of(const Configuration& configuration, std::size_t port) {
    const auto engine = build_engine(configuration);
    const auto values = build_value_engine(configuration, *engine);
    return link_use(Stations(*engine, values.get()), plan_ports(configuration).at(port));
}

TEST(UseOfALink, IsBothWaysOnASerialLine) {
    const Configuration job = loaded(main_job_with(10, "[runtime]\nrealtime = \"off\""));
    const LinkUse use = use_of(job, 1);
    EXPECT_EQ(use.way, SettingScope::both);
    EXPECT_EQ(use.line.baud, 100000U);
    EXPECT_FALSE(use.fd);
    EXPECT_TRUE(use.wanted.empty() && use.sent.empty());
    EXPECT_FALSE(use.worker.realtime);
    EXPECT_TRUE(use_of(loaded(main_job_with(0, "")), 0).worker.realtime);
}

TEST(UseOfALink, HasTheIdsOfAllThatUseTheBus) {
    const auto job = [](const std::string& lines) {
        return loaded(
            "[input.a]\nprotocol = \"can\"\ninterface = \"can0\"\nfd = true\n"
            "[input.b]\nprotocol = \"can\"\ninterface = \"can0\"\nid = 0x400\n" +
            lines +
            "[output.c]\nprotocol = \"can\"\ninterface = \"can0\"\nid = 0x500\n"
            "[pipeline.m]\nfrom = [\"a\", \"b\"]\nto = \"c\"\n");
    };
    const auto ids = [](const std::vector<CanIdMatch>& matches) {
        std::vector<std::uint32_t> all;
        for (const CanIdMatch& match : matches) {
            all.push_back(match.id);
        }
        return all;
    };
    const LinkUse use = use_of(job(""), 0);
    const std::vector<std::uint32_t> wanted = ids(use.wanted);
    EXPECT_EQ(std::ranges::count(wanted, 0x305), 1) << "one FD frame carries a snapshot";
    EXPECT_EQ(std::ranges::count(wanted, 0x400), 1);
    const std::vector<std::uint32_t> sent = ids(use.sent);
    EXPECT_EQ(std::ranges::count(sent, 0x500), 1);
    EXPECT_EQ(std::ranges::count(sent, 0x400), 0);
    EXPECT_TRUE(use.fd) << "one of them has FD frames";
    EXPECT_FALSE(use_of(job("fd = false\n"), 0).sent.empty());
}

TEST(OpenedPort, SaysInTheFileWhatIsMissing) {
    const Configuration job = loaded(main_job_with(3, "device = \"/dev/no-such-port\""));
    const auto engine = build_engine(job);
    const auto opened = open_port(job, Stations(*engine, nullptr), plan_ports(job).at(0));
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().substr(0, 29), "t.toml:3:10: /dev/no-such-por");
}

TEST(OpenedLine, SaysInTheFileWhatIsMissing) {
    const Configuration job = loaded(
        main_job_with(10,
                      "[gpio.lamp]\nchip = \"/dev/no-such-chip\"\nline = 1\nrole = \"link\"\n"
                      "[gpio.stop]\nchip = \"/dev/no-such-chip\"\nline = 2\n"
                      "role = \"force_failsafe\"\n"));
    for (const auto& [line, place] : {std::pair(0U, "t.toml:12:8: "), {1U, "t.toml:16:8: "}}) {
        const auto opened = open_line(job, job.lines.at(line));
        ASSERT_FALSE(opened);
        EXPECT_EQ(opened.error().substr(0, 13), place) << opened.error();
    }
}

TEST(TasksOfLines, AreInTheOrderOfTheFile) {
    const auto tasks =
        line_tasks(loaded(main_job_with(10,
                                        "[gpio.stop]\nline = \"A\"\nrole = \"force_failsafe\"\n"
                                        "[gpio.lamp]\nline = \"B\"\nrole = \"link\"\n")));
    ASSERT_EQ(tasks.size(), 2U);
    EXPECT_EQ(tasks[0].role, LineRole::force_failsafe);
    EXPECT_EQ(tasks[1].role, LineRole::link);
    EXPECT_TRUE(line_tasks(loaded(main_job_with(0, ""))).empty());
}

/// Whether the input counts fewer channels than before for good, so long after they began.
bool takes_fewer_channels(const std::string& recover, Duration after) {
    const auto engine =
        build_engine(loaded(main_job_with(10, "[pipeline.main.failsafe]\n" + recover)));
    const auto send = [&](std::size_t channels, Instant at) {
        ChannelFrame frame;
        for (std::size_t channel = 0; channel < channels; ++channel) {
            frame.set(channel, Pulse::from_microseconds(1200));
        }
        std::array<std::uint8_t, kLongestSerialFrame> bytes{};
        IbusEncoder encoder(channels);
        const std::size_t count = encoder.write(frame, bytes, at);
        engine->receive(0, std::span(bytes).first(count), at);
    };
    Instant now{1s};
    engine->start(now);
    for (; now < Instant{2s}; now += 10ms) {
        send(18, now);
    }
    for (; now < Instant{2s} + after; now += 10ms) {
        send(14, now);
    }
    engine->look(0, now);
    return !engine->inputs()[0].control().has(15);
}

TEST(BuiltEngine, TakesFewerChannelsAsTheyAreAfterTheTimeToRecover) {
    EXPECT_FALSE(takes_fewer_channels("recover = \"2s\"", 1900ms));
    EXPECT_TRUE(takes_fewer_channels("recover = \"2s\"", 2100ms));
    EXPECT_FALSE(takes_fewer_channels("recover = \"300ms\"", 200ms));
    EXPECT_TRUE(takes_fewer_channels("recover = \"300ms\"", 400ms));
}

TEST(TimeOfAFrame, IsThatOfTheLongestOneAndAPause) {
    const Configuration job = loaded(main_job_with(0, ""));
    EXPECT_EQ(frame_time(job.outputs.at(0)), 3120us) << "26 bytes of 12 bits at 100000 baud";
    const Configuration udp = loaded(main_job_with(6, "address = \"127.0.0.1:5501\""));
    EXPECT_EQ(frame_time(udp.outputs.at(0)), Duration::zero());
}

}  // namespace
}  // namespace tribus::test::build_test
