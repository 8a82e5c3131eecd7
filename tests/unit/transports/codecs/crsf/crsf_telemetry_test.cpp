#include "transports/codecs/crsf/telemetry.h"

#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/reference/plain_crsf.h"
#include "tests/support/streams.h"
#include "transports/registry/registry.h"

namespace tribus::test::crsf_telemetry_test {
namespace {

using namespace std::chrono_literals;
using reference::plain_crsf;

constexpr Instant kNow = Instant(1h);

SettingTree text(std::string_view name) {
    return {std::string(name)};
}
SettingTree list(const std::vector<std::string>& names) {
    SettingTree::List items;
    for (const std::string& name : names) {
        items.push_back(text(name));
    }
    return {std::move(items)};
}
SettingTree table(const std::vector<std::pair<std::string, std::string>>& entries) {
    SettingTree::Table content;
    for (const auto& [key, name] : entries) {
        content.push_back({key, text(name)});
    }
    return {std::move(content)};
}
/// By number, from 1 on.
SettingTree numbered(const std::vector<std::string>& names) {
    SettingTree::Table content;
    for (std::size_t i = 0; i < names.size(); ++i) {
        content.push_back({std::to_string(i + 1), text(names[i])});
    }
    return {std::move(content)};
}
SettingValues with(std::string_view key, SettingTree tree) {
    SettingValues settings;
    settings.set(key, std::move(tree));
    return settings;
}

std::vector<SettingMistake> mistakes_of(const SettingValues& settings) {
    return kCrsfTelemetryProtocol.check(settings, SettingScope::output);
}

/// An output with these settings, and a board with these numbers, all of one unit.
class Telemetry {
  public:
    Telemetry(const SettingValues& settings, std::vector<std::pair<std::string, double>> numbers,
              const std::string& unit = {})
        : board_(names_of(numbers, unit)), encoder_(frames_of(settings)) {
        for (std::size_t i = 0; i < numbers.size(); ++i) {
            board_.set(i, numbers[i].second, kNow);
        }
        encoder_.use(board_);
    }
    Bytes sent(Duration after = 0ms) {
        std::array<std::uint8_t, kLongestSerialFrame> wire{};
        const std::size_t length = encoder_.write({}, wire, kNow + after);
        return {wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(length)};
    }
    ValueBoard& board() { return board_; }

    static constexpr Duration kLasts = 1s;

  private:
    static std::vector<NamedValue> names_of(
        const std::vector<std::pair<std::string, double>>& numbers, const std::string& unit) {
        std::vector<NamedValue> values;
        for (const auto& [name, number] : numbers) {
            values.push_back({.name = name, .unit = unit, .lasts = kLasts});
        }
        return values;
    }
    static std::vector<CrsfTelemetryFrame> frames_of(const SettingValues& settings) {
        std::vector<SettingMistake> mistakes;
        auto frames = crsf_telemetry_frames(settings, mistakes);
        EXPECT_TRUE(mistakes.empty()) << mistakes[0].text;
        return frames;
    }

    ValueBoard board_;
    CrsfTelemetryEncoder encoder_;
};

// Bytes of Betaflight's telemetry_crsf_unittest.cc, with the values that it asserts.
TEST(CrsfTelemetry, WritesABattery) {
    Telemetry telemetry(
        with("battery",
             table({{"voltage", "v"}, {"current", "a"}, {"consumed", "mah"}, {"remaining", "p"}})),
        {{"v", 3.3}, {"a", 29.6}, {"mah", 1234}, {"p", 67}});
    EXPECT_EQ(telemetry.sent(), from_hex("C80A08002101280004D243B2"));
}

TEST(CrsfTelemetry, WritesAPosition) {
    Telemetry telemetry(
        with("gps", table({{"latitude", "lat"},
                           {"longitude", "lon"},
                           {"speed", "kmh"},
                           {"heading", "deg"},
                           {"altitude", "m"},
                           {"satellites", "n"}})),
        {{"lat", 56.0}, {"lon", 163.0}, {"kmh", 58.7}, {"deg", 147.9}, {"m", 2345}, {"n", 9}});
    EXPECT_EQ(telemetry.sent(), from_hex("C811022160EC006127D380024B39C60D11096B"));
}

TEST(CrsfTelemetry, WritesAnAttitude) {
    constexpr double kDegrees = 180 / std::numbers::pi;
    Telemetry telemetry(
        with("attitude", table({{"pitch", "p"}, {"roll", "r"}, {"yaw", "y"}})),
        {{"p", 1.1833 * kDegrees}, {"r", 2.6092 * kDegrees}, {"y", -3.1398 * kDegrees}});
    EXPECT_EQ(telemetry.sent(), from_hex("C8081E2E3965EC855A05"));
}

TEST(CrsfTelemetry, WritesAFlightMode) {
    SettingTree::Table content{{"value", text("mode")}, {"names", list({"MANUAL", "ACRO*"})}};
    Telemetry telemetry(with("flight_mode", {content}), {{"mode", 1}});
    EXPECT_EQ(telemetry.sent(), from_hex("C808214143524F2A0014"));
    telemetry.board().set(0, 2, kNow);
    EXPECT_TRUE(telemetry.sent().empty()) << "a number without a name";
    telemetry.board().set(0, -1, kNow);
    EXPECT_TRUE(telemetry.sent().empty());
}

// Layouts of TBS's text, with the plain check.
TEST(CrsfTelemetry, WritesSingleNumbers) {
    SettingValues settings;
    settings.set("vario", std::string("climb"));
    EXPECT_EQ(Telemetry(settings, {{"climb", -1.5}}).sent(), plain_crsf(0xC8, 0x07, {0xFF, 0x6A}));
    SettingValues airspeed;
    airspeed.set("airspeed", std::string("speed"));
    EXPECT_EQ(Telemetry(airspeed, {{"speed", 72.3}}).sent(), plain_crsf(0xC8, 0x0A, {0x02, 0xD3}));
}

TEST(CrsfTelemetry, WritesLists) {
    EXPECT_EQ(Telemetry(with("rpm", numbered({"a", "b"})), {{"a", 12000}, {"b", -1}}).sent(),
              plain_crsf(0xC8, 0x0C, {0, 0x00, 0x2E, 0xE0, 0xFF, 0xFF, 0xFF}));
    EXPECT_EQ(Telemetry(with("temperature", numbered({"a"})), {{"a", 25.04}}).sent(),
              plain_crsf(0xC8, 0x0D, {0, 0x00, 0xFA}));
    EXPECT_EQ(Telemetry(with("cells", numbered({"a"})), {{"a", 4.2}}).sent(),
              plain_crsf(0xC8, 0x0E, {0, 0x10, 0x68}));
}

TEST(CrsfTelemetry, LimitsNumbersToWhatTheirPlaceHolds) {
    EXPECT_EQ(
        Telemetry(with("temperature", numbered({"a", "b"})), {{"a", 1e9}, {"b", -1e9}}).sent(),
        plain_crsf(0xC8, 0x0D, {0, 0x7F, 0xFF, 0x80, 0x00}));
    EXPECT_EQ(Telemetry(with("cells", numbered({"a", "b"})), {{"a", 1e9}, {"b", -4e-4}}).sent(),
              plain_crsf(0xC8, 0x0E, {0, 0xFF, 0xFF, 0x00, 0x00}));
}

TEST(CrsfTelemetry, WritesANegativeCurrentAsSuch) {
    const auto current = [](double amperes) {
        return Telemetry(with("battery", table({{"current", "a"}})), {{"a", amperes}}).sent();
    };
    EXPECT_EQ(current(-5), plain_crsf(0xC8, 0x08, {0, 0, 0xFF, 0xCE, 0, 0, 0, 0}));
    EXPECT_EQ(current(-0.1), plain_crsf(0xC8, 0x08, {0, 0, 0xFF, 0xFF, 0, 0, 0, 0}));
    EXPECT_EQ(current(500), plain_crsf(0xC8, 0x08, {0, 0, 0x13, 0x88, 0, 0, 0, 0}));
}

TEST(CrsfTelemetry, LeavesOutAFrameWithANegativeNumberInAPlaceWithoutASign) {
    EXPECT_TRUE(Telemetry(with("cells", numbered({"a"})), {{"a", -1}}).sent().empty());
    EXPECT_TRUE(
        Telemetry(with("battery", table({{"voltage", "v"}})), {{"v", -0.1}}).sent().empty());
    EXPECT_TRUE(
        Telemetry(with("battery", table({{"remaining", "p"}})), {{"p", -1}}).sent().empty());
}

TEST(CrsfTelemetry, WritesAHeadingWithinAWholeTurn) {
    const auto heading = [](double degrees) {
        const Bytes bytes =
            Telemetry(
                with("gps", table({{"latitude", "o"}, {"longitude", "o"}, {"heading", "deg"}})),
                {{"o", 0}, {"deg", degrees}})
                .sent();
        return bytes.at(13) << 8 | bytes.at(14);
    };
    for (const auto& [degrees, sent] :
         {std::pair{-10.0, 35000}, {350.0, 35000}, {370.0, 1000}, {0.0, 0}, {-180.0, 18000}}) {
        EXPECT_EQ(heading(degrees), sent) << degrees;
    }
}

TEST(CrsfTelemetry, LeavesOutAFrameWithAValueThatIsTooOldOrNoNumber) {
    Telemetry telemetry(with("battery", table({{"voltage", "v"}, {"current", "a"}})),
                        {{"v", 12}, {"a", 1}});
    EXPECT_FALSE(telemetry.sent(Telemetry::kLasts - 1ms).empty());
    EXPECT_TRUE(telemetry.sent(Telemetry::kLasts + 1ms).empty());
    telemetry.board().set(1, std::nan(""), kNow);
    EXPECT_TRUE(telemetry.sent().empty());
    telemetry.board().remove(1);
    EXPECT_TRUE(telemetry.sent().empty());
}

TEST(CrsfTelemetry, ConvertsUnits) {
    const Bytes four_volts = plain_crsf(0xC8, 0x0E, {0, 0x0F, 0xA0});
    const SettingValues cells = with("cells", numbered({"a"}));
    EXPECT_EQ(Telemetry(cells, {{"a", 4000}}, "mV").sent(), four_volts);
    EXPECT_EQ(Telemetry(cells, {{"a", 4}}, "V").sent(), four_volts);
    EXPECT_EQ(Telemetry(cells, {{"a", 4}}).sent(), four_volts) << "without a unit as it is";
    EXPECT_EQ(Telemetry(with("temperature", numbered({"a"})), {{"a", 298.15}}, "K").sent(),
              plain_crsf(0xC8, 0x0D, {0, 0x00, 0xFA}));
}

TEST(CrsfTelemetry, LeavesOutAFrameWithAValueThatMeasuresSomethingElse) {
    for (const char* const unit : {"degC", "furlongs"}) {
        EXPECT_TRUE(Telemetry(with("cells", numbered({"a"})), {{"a", 20}}, unit).sent().empty());
    }
}

TEST(CrsfTelemetry, SendsItsFramesInTurnAndPassesOverThoseThatItLeavesOut) {
    SettingValues settings = with("cells", numbered({"cell"}));
    settings.set("vario", std::string("climb"));
    settings.set("airspeed", std::string("speed"));
    Telemetry telemetry(settings, {{"cell", 4}, {"climb", 0}, {"speed", 0}});
    const auto types = [&] {
        std::vector<unsigned> sent;
        for (int turn = 0; turn < 4; ++turn) {
            sent.push_back(telemetry.sent().at(2));
        }
        return sent;
    };
    EXPECT_EQ(types(), (std::vector<unsigned>{0x07, 0x0A, 0x0E, 0x07}));
    telemetry.board().remove(2);
    EXPECT_EQ(types(), (std::vector<unsigned>{0x0E, 0x07, 0x0E, 0x07}));
}

TEST(CrsfTelemetry, ANumberThatNoKeyNamesIsZero) {
    EXPECT_EQ(Telemetry(with("battery", table({{"voltage", "v"}})), {{"v", 1}}).sent(),
              plain_crsf(0xC8, 0x08, {0x00, 0x0A, 0, 0, 0, 0, 0, 0}));
}

TEST(CrsfTelemetry, RefusesWrongSettingsWithThePlace) {
    const auto first = [](const SettingValues& settings) {
        const auto mistakes = mistakes_of(settings);
        return mistakes.empty() ? SettingMistake{} : mistakes[0];
    };
    EXPECT_NE(first({}).text.find("nothing to send"), std::string::npos);
    EXPECT_EQ(first(with("battery", table({{"volts", "v"}}))).path,
              (std::vector<std::string>{"battery", "volts"}));
    EXPECT_EQ(first(with("battery", text("v"))).path, std::vector<std::string>{"battery"});
    EXPECT_NE(first(with("gps", table({{"latitude", "lat"}}))).text.find("both"),
              std::string::npos);
    EXPECT_NE(
        first(with("cells", numbered(std::vector<std::string>(30, "c")))).text.find("at most 29"),
        std::string::npos);
    EXPECT_NE(first(with("rpm", numbered({}))).text.find("1 to 19"), std::string::npos);
    const SettingTree::Table long_name{{"value", text("v")}, {"names", list({"FIFTEENLETTERS!"})}};
    EXPECT_NE(first(with("flight_mode", {long_name})).text.find("1 to 14 letters"),
              std::string::npos);
    EXPECT_EQ(first(with("cells", table({{"1", "a"}, {"3", "b"}}))).path,
              (std::vector<std::string>{"cells", "3"}));
    EXPECT_EQ(first(with("cells", table({{"01", "a"}}))).path,
              (std::vector<std::string>{"cells", "01"}));
}

TEST(CrsfTelemetry, NamesItsValuesWithTheKeysThatNameThem) {
    const auto uses = kCrsfTelemetryProtocol.value_names(
        with("battery", table({{"voltage", "pack.v"}, {"remaining", "pack.p"}})));
    ASSERT_EQ(uses.size(), 2U);
    EXPECT_EQ(uses[0].name, "pack.v");
    EXPECT_EQ(uses[0].path, (std::vector<std::string>{"battery", "voltage"}));
    EXPECT_EQ(uses[0].unit, "V");
    EXPECT_EQ(uses[1].name, "pack.p");
    EXPECT_EQ(uses[1].unit, "%");
}

}  // namespace
}  // namespace tribus::test::crsf_telemetry_test
