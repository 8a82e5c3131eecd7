#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "config/load.h"
#include "config/show/effective.h"
#include "tests/unit/config/main_job.h"

/// Values of the messages of a protocol on bytes as a user writes them.
namespace tribus::test::byte_values_test {
namespace {

using Lines = std::vector<std::string>;

/// Returns a bus that sends a value, after the table of the value. The table's lines begin in line
/// 2.
std::string with_values(std::string_view lines, std::string_view more = "") {
    return "[values.fc]\n" + std::string(lines) +
           "[sensor_bus.t]\ndevice = \"/dev/ttyA\"\nrole = \"sensor\"\n"
           "sensor = [{ type = \"external_voltage\", value = \"fc.battery.voltage\" }]\n" +
           std::string(more);
}
constexpr std::string_view kOnDevice = "protocol = \"crsf-telemetry\"\ndevice = \"/dev/ttyB\"\n";
constexpr std::string_view kPipeline =
    "[input.rx]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyC\"\n"
    "[pipeline.main]\nfrom = \"rx\"\nto = \"fc\"\n";

/// Returns the mistakes as "line:column: text".
Lines mistakes(const std::string& text) {
    Lines lines;
    for (const std::string& mistake : mistakes_in(text, "f")) {
        lines.push_back(mistake.substr(2));
    }
    return lines;
}

TEST(ByteValues, NeedAProtocolAndAPlaceOnly) {
    EXPECT_EQ(mistakes(with_values(kOnDevice)), Lines{});
    EXPECT_EQ(mistakes(with_values("protocol = \"crsf-telemetry\"\naddress = \"[::1]:5502\"\n")),
              Lines{});
}

TEST(ByteValues, AreAsTheUserWroteThemWithEveryDefaultFilledIn) {
    const std::string text = with_values(
        std::string(kOnDevice) + "signals = { volts = \"battery.voltage\" }\nbaud = 115200\n");
    const auto configuration = load_configuration(
        text.substr(0, text.find("fc.battery.voltage")) + "fc.volts\" }]\n", "f");
    ASSERT_TRUE(configuration);
    const std::string effective = effective_toml(*configuration);
    EXPECT_NE(effective.find("[values.fc]\nprotocol = \"crsf-telemetry\"\ndevice = \"/dev/ttyB\"\n"
                             "baud = 115200\nsignals = { volts = \"battery.voltage\" }\n"
                             "timeout = \"3s\"\n"),
              std::string::npos)
        << effective;
    EXPECT_EQ(effective_toml(*load_configuration(effective, "f")), effective);
}

TEST(ByteValues, MustHaveExactlyOnePlace) {
    EXPECT_EQ(mistakes(with_values("protocol = \"crsf-telemetry\"\n")),
              Lines{"2:12: the place is missing; required with \"protocol\": \"device\", a serial "
                    "port, or \"address\" for UDP"});
    EXPECT_EQ(mistakes(with_values(std::string(kOnDevice) + "address = \"[::1]:5502\"\n")),
              Lines{"4:1: \"address\" beside \"device\"; leave one of them out"});
}

TEST(ByteValues, RefuseKeysOfOtherPlacesAndSources) {
    EXPECT_EQ(mistakes(with_values(std::string(kOnDevice) + "public = true\n")),
              Lines{"4:1: \"public\" has no effect together with \"device\"; leave it out"});
    EXPECT_EQ(mistakes(with_values("protocol = \"crsf-telemetry\"\naddress = \"[::1]:5502\"\n"
                                   "baud = 115200\n")),
              Lines{"4:1: \"baud\" has no effect together with \"address\"; leave it out"});
    EXPECT_EQ(mistakes(with_values(std::string(kOnDevice) + "interface = \"can0\"\n")),
              Lines{"4:1: \"interface\" has no effect together with \"protocol\"; leave one of "
                    "them out"});
}

TEST(ByteValues, OutsideOfTheMachineMustBePublic) {
    const std::string outside = "protocol = \"crsf-telemetry\"\naddress = \"192.0.2.7:5502\"\n";
    EXPECT_EQ(mistakes(with_values(outside)).front().substr(0, 62),
              "3:11: \"address\" is \"192.0.2.7:5502\", outside of this machine; ");
    EXPECT_EQ(mistakes(with_values(outside + "public = true\n")), Lines{});
}

TEST(ByteValues, RefuseAProtocolThatHasNone) {
    const Lines found = mistakes(with_values("protocol = \"sbus\"\ndevice = \"/dev/ttyB\"\n"));
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found.front(),
              "2:12: \"protocol\" is \"sbus\"; allowed: \"crsf-telemetry\", "
              "\"mavlink-telemetry\"");
}

TEST(ByteValues, NameWhatWasMeant) {
    EXPECT_EQ(
        mistakes(with_values(std::string(kOnDevice) + "signals = { volts = \"batery.voltage\" }\n"))
            .front()
            .substr(0, 100),
        "4:21: message crsf-telemetry has no signal \"batery.voltage\"; did you mean "
        "\"battery.voltage\"? Allowed");
}

TEST(ByteValues, ShareADeviceWithAnOutputOfTheSameRate) {
    const auto beside = [&](std::string_view baud) {
        return with_values(kOnDevice, "[output.fc]\nprotocol = \"crsf\"\ndevice = \"/dev/ttyB\"\n" +
                                          std::string(baud) + std::string(kPipeline));
    };
    EXPECT_EQ(mistakes(beside("")), Lines{});
    EXPECT_EQ(mistakes(beside("baud = 115200\n")),
              Lines{"10:10: device \"/dev/ttyB\" is already used by [values.fc] in line 3 with "
                    "420000 baud 8N1, here with 115200 baud 8N1; values and an output may share a "
                    "device if their line settings agree"});
}

TEST(ByteValues, DoNotShareADeviceWithAnInput) {
    EXPECT_EQ(mistakes(with_values(kOnDevice,
                                   "[input.rx]\nprotocol = \"crsf\"\ndevice = \"/dev/ttyB\"\n"
                                   "[output.o]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyC\"\n"
                                   "[pipeline.main]\nfrom = \"rx\"\nto = \"o\"\n")),
              Lines{"10:10: device \"/dev/ttyB\" is already used by [values.fc] in line 3; one "
                    "device serves at most one input and one output, or one [values.NAME] and one "
                    "output"});
}

/// The sensor of the bus sends a value that the table does not have.
TEST(ByteValues, AreUnknownAfterAMistakeInTheirPlace) {
    const auto with = [](const std::string& lines) {
        std::string text = with_values("protocol = \"crsf-telemetry\"\n" + lines);
        return mistakes(text.replace(text.find("fc.battery.voltage"), 18, "fc.nothing"));
    };
    EXPECT_EQ(with("device = \"/dev/ttyB\"\n").size(), 1U);
    for (const std::string lines :
         {"device = 3\n", "device = \"/dev/ttyB\"\nbaud = \"x\"\n",
          "address = \"[::1]:5502\"\npublic = 5\n", "address = \"[::1]:5502\"\nsender = 5\n",
          "device = \"/dev/ttyB\"\naddress = \"[::1]:5502\"\n"}) {
        const Lines found = with(lines);
        ASSERT_EQ(found.size(), 1U) << lines;
        EXPECT_EQ(found[0].find("there is no value"), std::string::npos) << found[0];
    }
}

TEST(ByteValues, AtAnAddressAreNotPublicUnlessTheUserSaysSo) {
    const auto configuration = load_configuration(
        with_values("protocol = \"crsf-telemetry\"\naddress = \"[::1]:5502\"\n"), "f");
    ASSERT_TRUE(configuration);
    const auto& source = std::get<ValueMessageConfig>(configuration->values.at(0).source);
    const bool* is_public = source.port.settings.find_as<bool>("public");
    ASSERT_NE(is_public, nullptr);
    EXPECT_FALSE(*is_public);
}

}  // namespace
}  // namespace tribus::test::byte_values_test
