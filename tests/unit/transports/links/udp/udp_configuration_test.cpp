#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "config/build/build.h"
#include "config/build/carry_over.h"
#include "config/show/effective.h"
#include "tests/unit/config/main_job.h"
#include "transports/links/udp/udp_medium.h"

/// `address` in a configuration.
namespace tribus::test::udp_configuration_test {
namespace {

using Lines = std::vector<std::string>;

/// An input of SBUS and an output of i.Bus, with these lines for their places.
std::string job(const std::string& input, const std::string& output) {
    return "[input.receiver]\nprotocol = \"sbus\"\n" + input +
           "\n[output.servos]\nprotocol = \"ibus\"\n" + output +
           "\n[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n";
}
const std::string kHere = "address = \"127.0.0.1:5501\"";
const std::string kThere = "address = \"127.0.0.1:5502\"";

TEST(UdpConfiguration, GivesEachAddressAPortOfItsOwn) {
    const Configuration configuration = loaded(job(kHere, kThere));
    EXPECT_EQ(configuration.inputs[0].port.medium, &kUdpMedium);
    EXPECT_EQ(configuration.inputs[0].port.device, "127.0.0.1:5501");
    const auto plans = plan_ports(configuration);
    ASSERT_EQ(plans.size(), 2U);
    EXPECT_TRUE(plans[0].wiring.has_datagrams);
    EXPECT_EQ(plans[0].wiring.byte_time, Duration::zero());
    const auto engine = build_engine(configuration);
    const Stations stations(*engine, nullptr);
    EXPECT_EQ(link_use(stations, plans[0]).way, SettingScope::input);
    EXPECT_EQ(link_use(stations, plans[1]).way, SettingScope::output);
}

TEST(UdpConfiguration, IsPrintedAsItIsRead) {
    const std::string text = job(kHere, "address = \"192.0.2.7:5502\"\npublic = true");
    const std::string printed = effective_toml(loaded(text));
    EXPECT_NE(printed.find("address = \"192.0.2.7:5502\"\npublic = true\n"), std::string::npos)
        << printed;
    EXPECT_EQ(effective_toml(loaded(printed)), printed);
}

TEST(UdpConfiguration, ASenderIsAnAddressOfTheSameVersionWithoutAPort) {
    const auto with = [](const std::string& sender) {
        return mistakes_in(job(kHere + "\nsender = \"" + sender + "\"", kThere));
    };
    EXPECT_EQ(with("127.0.0.1"), Lines{});
    for (const std::string wrong : {"127.0.0.1:5501", "[::1]", "localhost"}) {
        EXPECT_EQ(
            with(wrong),
            Lines{"t.toml:4:10: \"sender\" is \"" + wrong +
                  R"("; allowed: an IP address in digits without a port, of the same version )"
                  R"(as "address", such as "127.0.0.1" or "[::1]")"})
            << wrong;
    }
    EXPECT_EQ(mistakes_in(job(kHere, kThere + "\nsender = \"127.0.0.1\"")).size(), 1U)
        << "an output receives nothing";
}

TEST(UdpConfiguration, AnAddressBesideADeviceIsAMistake) {
    EXPECT_EQ(mistakes_in(job("device = \"/dev/ttyA\"\n" + kHere, kThere)),
              Lines{R"(t.toml:4:1: "address" in [input.receiver], which has "device" already; )"
                    "leave one of them out"});
}

TEST(UdpConfiguration, AnAddressHasOneUser) {
    EXPECT_EQ(mistakes_in(job(kHere, kHere)),
              Lines{R"(t.toml:6:11: address "127.0.0.1:5501" is already used by )"
                    "[input.receiver] in line 3; one address serves one input or one output"});
}

TEST(UdpConfiguration, AnAddressOutsideOfThisMachineMustBeAllowed) {
    const std::string outside = "address = \"0.0.0.0:5501\"";
    EXPECT_EQ(mistakes_in(job(outside, kThere)),
              Lines{R"(t.toml:3:11: "address" is "0.0.0.0:5501", outside of this machine; )"
                    R"(allowed: a loopback address, such as "127.0.0.1:5501", or add )"
                    "public = true (UDP has no password: who reaches an input moves the servos)"});
    EXPECT_EQ(mistakes_in(job(outside + "\npublic = true", kThere)), Lines{});
}

TEST(UdpConfiguration, AnAddressIsInDigitsWithAPort) {
    EXPECT_EQ(mistakes_in(job("address = \"localhost:5501\"", kThere)),
              Lines{R"(t.toml:3:11: "address" is "localhost:5501": localhost is not an IP address )"
                    R"(in digits; allowed: an IP address in digits and a port from 1 to 65535, )"
                    R"(such as "127.0.0.1:5501" or "[::1]:5501")"});
}

TEST(UdpConfiguration, ABusHasNoAddress) {
    const auto mistakes = mistakes_in("[input.a]\nprotocol = \"can\"\n" + kHere +
                                      "\n[output.servos]\nprotocol = \"ibus\"\n" + kThere +
                                      "\n[pipeline.main]\nfrom = \"a\"\nto = \"servos\"\n");
    EXPECT_EQ(mistakes, Lines{R"(t.toml:3:1: unknown key "address" in [input.a]; protocol "can" )"
                              R"(has "interface" instead: CAN interface, such as "can0")"});
}

TEST(UdpConfiguration, TheRateOfALineIsNoKeyBesideAnAddress) {
    const auto mistakes = mistakes_in(job(kHere + "\nbaud = 200000", kThere));
    ASSERT_EQ(mistakes.size(), 1U);
    EXPECT_EQ(mistakes[0].substr(0, mistakes[0].find("; allowed")),
              R"(t.toml:4:1: unknown key "baud" in [input.receiver]; it belongs in [input.NAME] )"
              R"(with protocol "sbus" and "device")");
}

TEST(UdpConfiguration, AnInvertedLineIsNoKeyBesideAnAddress) {
    EXPECT_EQ(mistakes_in(job(kHere + "\ninverted = false", kThere)).size(), 1U);
}

TEST(UdpConfiguration, APeriodIsNotLimitedByALine) {
    // 32 bytes at 115200 baud take 2.8 ms.
    EXPECT_EQ(mistakes_in(job(kHere, kThere + "\nperiod = \"1ms\"\nforce = true")), Lines{});
}

TEST(UdpConfiguration, AnAddressThatChangesItsWayIsOpenedAnew) {
    const auto before = loaded(job(kHere, kThere));
    const auto after = loaded(job(kThere, kHere));
    const auto engine = build_engine(before);
    EXPECT_TRUE(same_device(plan_ports(before)[0].config, plan_ports(after)[1].config));
    EXPECT_FALSE(link_use(Stations(*engine, nullptr), plan_ports(before)[0]) ==
                 link_use(Stations(*engine, nullptr), plan_ports(after)[1]));
}

}  // namespace
}  // namespace tribus::test::udp_configuration_test
