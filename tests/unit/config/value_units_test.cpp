#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"
#include "tests/unit/config/main_job.h"

/// Every output that sends named values refuses a wrong unit in the same way.
namespace tribus::test::value_units_test {
namespace {

constexpr std::string_view kDbc = R"(BO_ 291 Battery: 8 A
 SG_ Voltage : 0|16@1+ (1,0) [0|60000] "mV" B
 SG_ Heat : 16|8@1+ (1,-40) [0|0] "degC" B
 SG_ Odd : 24|8@1+ (1,0) [0|0] "bananas" B
 SG_ Bare : 32|8@1+ (1,0) [0|0] "" B
 SG_ Fruit : 40|8@1+ (1,0) [0|0] "apple" B
)";

constexpr std::string_view kTables = R"([values.battery]
interface = "can0"
dbc = "battery.dbc"
message = "Battery"
)"
                                     R"([input.receiver]
protocol = "exbus"
device = "/dev/ttyA"
[output.servos]
protocol = "sbus"
device = "/dev/ttyB"
[pipeline.main]
from = "receiver"
)";

/// An output, with VALUE for the name of the value that it sends.
struct Sender {
    std::string_view name;
    std::string_view unit;  ///< in which it is sent
    std::string_view table;
    std::string_view to;  ///< what the pipeline feeds
};

void PrintTo(const Sender& sender, std::ostream* stream) {
    *stream << sender.name;
}

class SentUnit : public testing::TestWithParam<Sender> {
  protected:
    SentUnit() { folder_.write("battery.dbc", std::string(kDbc)); }
    /// The mistakes where that value is sent.
    std::vector<std::string> mistakes_with(std::string_view value) const {
        std::string text(kTables);
        text += "to = " + std::string(GetParam().to) + "\n" + std::string(GetParam().table);
        for (std::size_t at = text.find("VALUE"); at != std::string::npos;
             at = text.find("VALUE")) {
            text.replace(at, 5, value);
        }
        auto mistakes = mistakes_in(text, folder_ / "t.toml");
        for (std::string& mistake : mistakes) {
            mistake = mistake.substr(mistake.find(": ") + 2);
        }
        return mistakes;
    }
    std::vector<std::string> refused(const std::string& value, const std::string& in) const {
        return {"\"" + value + "\" is in " + in + ", but is sent here in \"" +
                std::string(GetParam().unit) +
                "\"; name a value whose unit converts, or correct the unit that is wrong"};
    }

    TemporaryFolder folder_;
};

INSTANTIATE_TEST_SUITE_P(
    EachOutput, SentUnit,
    testing::Values(
        Sender{"Crsf", "V",
               "[output.o]\nprotocol = \"crsf-telemetry\"\ndevice = \"/dev/ttyC\"\n"
               "battery = { voltage = \"VALUE\" }\n",
               "\"servos\""},
        Sender{"ExBus", "V",
               "[output.o]\nprotocol = \"exbus-telemetry\"\ndevice = \"/dev/ttyA\"\n"
               "sensors = { 1 = { value = \"VALUE\", unit = \"V\" } }\n",
               "\"servos\""},
        Sender{"Dbc", "mV",
               "[output.o]\nprotocol = \"dbc\"\ninterface = \"can1\"\ndbc = \"battery.dbc\"\n"
               "[output.o.signals.Battery]\nVoltage = { from = \"VALUE\" }\n",
               "\"servos\""}),
    [](const auto& test) { return std::string(test.param.name); });

TEST_P(SentUnit, IsConvertedOrRefused) {
    EXPECT_EQ(mistakes_with("battery.Voltage"), std::vector<std::string>{});
    EXPECT_EQ(mistakes_with("battery.Bare"), std::vector<std::string>{})
        << "without a unit as it is";
    EXPECT_EQ(mistakes_with("battery.Heat"), refused("battery.Heat", "\"degC\""));
    EXPECT_EQ(mistakes_with("battery.Odd"), refused("battery.Odd", "\"bananas\", an unknown unit"));
}

class ShownUnit : public SentUnit {};

INSTANTIATE_TEST_SUITE_P(Jeti, ShownUnit,
                         testing::Values(Sender{
                             "ExBus", "apple",
                             "[output.o]\nprotocol = \"exbus-telemetry\"\ndevice = \"/dev/ttyA\"\n"
                             "sensors = { 1 = { value = \"VALUE\", unit = \"apple\" } }\n",
                             "\"servos\""}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST_P(ShownUnit, IsRefusedWhereItIsUnknown) {
    EXPECT_EQ(mistakes_with("battery.Voltage"),
              (std::vector<std::string>{
                  "\"battery.Voltage\" is in \"mV\", but is sent here in \"apple\", an unknown "
                  "unit; name a value whose unit converts, or correct the unit that is wrong"}));
    EXPECT_EQ(mistakes_with("battery.Fruit"), std::vector<std::string>{}) << "the same text";
}

class SentQuality : public SentUnit {};

INSTANTIATE_TEST_SUITE_P(DroneCan, SentQuality,
                         testing::Values(Sender{
                             "Quality", "%",
                             "[output.o]\nprotocol = \"dronecan\"\ninterface = \"can1\"\n"
                             "node_id = 42\nquality = \"VALUE\"\n",
                             "[\"servos\", \"o\"]"}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST_P(SentQuality, IsAShareOrAPulse) {
    EXPECT_EQ(mistakes_with("machine.load"), std::vector<std::string>{});
    EXPECT_EQ(mistakes_with("input.receiver.channel.14"), std::vector<std::string>{});
    EXPECT_EQ(mistakes_with("battery.Heat"), refused("battery.Heat", "\"degC\""));
}

}  // namespace
}  // namespace tribus::test::value_units_test
