#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "config/load.h"
#include "tests/reference/plain_exbus_telemetry.h"
#include "tests/support/streams.h"
#include "transports/codecs/exbus/telemetry.h"

namespace tribus::test::exbus_telemetry_test {
namespace {

using namespace std::chrono_literals;
using reference::plain_exbus_answer;
using reference::plain_exbus_request;
using reference::PlainExBusAnswer;
using Numbers = std::map<unsigned, double>;

// Jeti's text, EX Bus protocol 1.21: the request, and an answer of device 5551.
constexpr std::string_view kRequest = "3D0108063A009881";
constexpr std::string_view kAnswer =
    "3B0120083A189F5600A45155EE11302021004034A328004100005118000991D6";
constexpr Instant kNow = Instant(1h);

/// Sensors 1, 2 ... show the numbers "v.1", "v.2" ... of a board.
class Device {
  public:
    explicit Device(std::vector<ExBusSensor> sensors, std::string_view unit = "V")
        : board_(values_of(sensors, unit)), encoder_({"boat", 7, std::move(sensors)}) {
        encoder_.use(board_);
        for (std::size_t i = 0; i < board_.size(); ++i) {
            board_.set(i, 1 + static_cast<double>(i), kNow);
        }
    }
    static std::vector<ExBusSensor> plain(std::size_t count) {
        std::vector<ExBusSensor> sensors;
        for (std::size_t i = 1; i <= count; ++i) {
            sensors.push_back({.number = static_cast<std::uint8_t>(i),
                               .value = "v." + std::to_string(i),
                               .label = "Label" + std::to_string(i),
                               .unit = {}});
        }
        return sensors;
    }

    /// Whether the bytes ask for a frame at once.
    bool hear(const Bytes& bytes, Duration at = 0ms) {
        const auto asked = encoder_.hear(bytes, kNow + at);
        return asked && asked->at_once;
    }
    Bytes written(Duration at = 0ms) {
        std::array<std::uint8_t, kLongestSerialFrame> wire{};
        const std::size_t length = encoder_.write({}, wire, kNow + at);
        return {wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(length)};
    }
    /// The answer to a request that comes then.
    std::optional<PlainExBusAnswer> answer(Duration at = 0ms) {
        EXPECT_TRUE(hear(plain_exbus_request(++packet_), at));
        const Bytes bytes = written(at + 100us);
        const auto read = plain_exbus_answer(bytes);
        EXPECT_TRUE(read || bytes.empty());
        EXPECT_TRUE(!read || (read->packet == packet_ && read->device == 7));
        return read;
    }
    /// The next answer with numbers.
    Numbers numbers(Duration at = 0ms) {
        for (int tries = 0; tries < 40; ++tries) {
            if (const auto read = answer(at); read && !read->named) {
                return read->numbers;
            }
        }
        return {};
    }
    ValueBoard& board() { return board_; }
    ExBusTelemetryEncoder& encoder() { return encoder_; }

    static constexpr Duration kLasts = 1s;

  private:
    static std::vector<NamedValue> values_of(const std::vector<ExBusSensor>& sensors,
                                             std::string_view unit) {
        std::vector<NamedValue> values;
        for (const ExBusSensor& sensor : sensors) {
            values.push_back({.name = sensor.value, .unit = std::string(unit), .lasts = kLasts});
        }
        return values;
    }

    ValueBoard board_;
    ExBusTelemetryEncoder encoder_;
    std::uint8_t packet_ = 0;
};

TEST(ExBusTelemetry, ThePlainReaderReadsTheAnswerOfJetisText) {
    const auto answer = plain_exbus_answer(from_hex(kAnswer));
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->device, 0x5551U);
    EXPECT_EQ(answer->numbers, (Numbers{{1, 4.8}, {2, 0}, {3, 10403}, {4, 0}, {5, 24}}));
}

TEST(ExBusTelemetry, AnswersTheRequestOfJetisTextWithTheNameOfTheDevice) {
    Device device(Device::plain(1));
    EXPECT_TRUE(device.hear(from_hex(kRequest)));
    // By hand: answer 06 of 20 bytes, EX text of 0x0C bytes, maker A400, device 0007, name 0.
    const Bytes written = device.written();
    EXPECT_EQ(Bytes(written.begin(), written.begin() + 19),
              from_hex("3B0116063A0E9F0C00A40700000020626F6174"));
    EXPECT_TRUE(plain_exbus_answer(written));
}

TEST(ExBusTelemetry, FirstNamesTheDeviceAndEachSensorThenSendsNumbers) {
    Device device(Device::plain(2));
    const auto first = device.answer();
    EXPECT_EQ(first->named, 0U);
    EXPECT_EQ(first->label, "boat");
    for (const unsigned sensor : {1U, 2U}) {
        const auto name = device.answer();
        EXPECT_EQ(name->named, sensor);
        EXPECT_EQ(name->label, "Label" + std::to_string(sensor));
        EXPECT_EQ(name->unit, "V");
    }
    EXPECT_EQ(device.answer()->numbers, (Numbers{{1, 1}, {2, 2}}));
}

TEST(ExBusTelemetry, RepeatsANameAfterTenFramesOfNumbers) {
    Device device(Device::plain(1));
    std::vector<unsigned> names;
    for (int i = 0; i < 2 + 3 * 11; ++i) {
        const auto answer = device.answer();
        names.push_back(answer->named.value_or(9));
    }
    std::vector<unsigned> expected{0, 1};
    for (const unsigned name : {0U, 1U, 0U}) {
        expected.insert(expected.end(), 10, 9);
        expected.push_back(name);
    }
    EXPECT_EQ(names, expected);
}

TEST(ExBusTelemetry, SendsAllOfFifteenNumbersInTurn) {
    Device device(Device::plain(15));
    Numbers seen;
    for (int i = 0; i < 4; ++i) {
        const Numbers part = device.numbers();
        EXPECT_LE(part.size(), 4U);
        for (const auto& [number, value] : part) {
            EXPECT_TRUE(seen.emplace(number, value).second || i == 3) << number;
        }
    }
    ASSERT_EQ(seen.size(), 15U);
    for (const auto& [number, value] : seen) {
        EXPECT_EQ(value, number);
    }
}

TEST(ExBusTelemetry, WritesEveryNumberOfADecade) {
    for (int decimals = 0; decimals <= 3; ++decimals) {
        auto sensors = Device::plain(1);
        sensors[0].decimals = decimals;
        Device device(std::move(sensors));
        device.numbers();
        const double step = std::pow(10, -decimals);
        for (int number = -1100; number <= 1100; ++number) {
            device.board().set(0, number * step, kNow);
            EXPECT_NEAR(device.numbers()[1], number * step, 1e-9) << decimals;
        }
    }
}

TEST(ExBusTelemetry, LargeNumbersLoseDecimalsAndEndAtTheLimit) {
    auto sensors = Device::plain(1);
    sensors[0].decimals = 3;
    Device device(std::move(sensors));
    for (const auto& [number, shown] : std::vector<std::pair<double, double>>{{2097.151, 2097.151},
                                                                              {2097.152, 2097.15},
                                                                              {-2097.152, -2097.15},
                                                                              {123456.78, 123456.8},
                                                                              {2097151, 2097151},
                                                                              {5e6, 2097151},
                                                                              {-5e6, -2097151},
                                                                              {1e300, 2097151}}) {
        device.board().set(0, number, kNow);
        EXPECT_NEAR(device.numbers()[1], shown, 1e-9) << number;
    }
}

TEST(ExBusTelemetry, WritesPositions) {
    auto sensors = Device::plain(2);
    sensors[0].form = ExBusNumber::latitude;
    sensors[1].form = ExBusNumber::longitude;
    Device device(std::move(sensors), "deg");
    for (const auto& [latitude, longitude] :
         std::vector<std::pair<double, double>>{{47.5, 8.25},
                                                {-33.8688, 151.2093},
                                                {89.9999999, -179.9999999},
                                                {0, -0.00002},
                                                {90, 180},
                                                {-90, -180}}) {
        device.board().set(0, latitude, kNow);
        device.board().set(1, longitude, kNow);
        Numbers shown = device.numbers();
        // Half of a thousandth of a minute.
        EXPECT_NEAR(shown[1], latitude, 1 / 120'000.0);
        EXPECT_NEAR(shown[2], longitude, 1 / 120'000.0);
    }
}

TEST(ExBusTelemetry, MarksALongitude) {
    auto sensors = Device::plain(1);
    sensors[0].form = ExBusNumber::longitude;
    Device device(std::move(sensors), "deg");
    device.board().set(0, -8.5, kNow);
    device.answer();
    device.answer();
    device.hear(plain_exbus_request(3));
    const Bytes written = device.written();
    // Sensor 1, type 9: 30.000 minutes, 8 degrees, longitude (20), west (40).
    EXPECT_EQ(Bytes(written.begin() + 13, written.begin() + 18), from_hex("1930750860"));
}

TEST(ExBusTelemetry, ConvertsToTheConfiguredUnitAndShowsIt) {
    auto sensors = Device::plain(1);
    sensors[0].unit = "mV";
    Device device(std::move(sensors));
    device.answer();
    EXPECT_EQ(device.answer()->unit, "mV");
    EXPECT_EQ(device.numbers(), (Numbers{{1, 1000}}));
}

TEST(ExBusTelemetry, ShowsDegreesInLatin1) {
    Device device(Device::plain(1), "degC");
    device.answer();
    EXPECT_EQ(device.answer()->unit,
              "\xB0"
              "C");
}

TEST(ExBusTelemetry, AValueOfAnotherQuantityOrAnUnknownOneHasNoNumber) {
    for (const char* const unit : {"A", "bananas"}) {
        auto sensors = Device::plain(2);
        sensors[0].unit = unit;
        Device device(std::move(sensors));
        EXPECT_EQ(device.numbers(), (Numbers{{2, 2}})) << unit;
    }
}

TEST(ExBusTelemetry, AStaleNumberIsLeftOutAndWithoutAnyItIsSilent) {
    Device device(Device::plain(2));
    device.board().set(1, 5, kNow + 500ms);
    // It is written 0.1 ms after the request.
    EXPECT_EQ(device.numbers(Device::kLasts - 100us), (Numbers{{1, 1}, {2, 5}}));
    EXPECT_EQ(device.numbers(Device::kLasts), (Numbers{{2, 5}}));
    EXPECT_FALSE(device.answer(Device::kLasts + 501ms));
}

TEST(ExBusTelemetry, AnswersOnlyRequestsForTelemetry) {
    Device device(Device::plain(1));
    Bytes forbidden = plain_exbus_request(1);
    forbidden[1] = 0x03;
    const unsigned check = reference::plain_exbus_check(std::span(forbidden).first(6));
    forbidden[6] = static_cast<std::uint8_t>(check);
    forbidden[7] = static_cast<std::uint8_t>(check >> 8U);
    for (const Bytes& other : {plain_exbus_request(1, 0x3B), forbidden, from_hex(kAnswer),
                               reference::plain_exbus_channels({8066, 8066})}) {
        EXPECT_FALSE(device.hear(other));
        EXPECT_TRUE(device.written().empty());
    }
}

TEST(ExBusTelemetry, NoRequestWithAFlippedBitIsAnswered) {
    const Bytes request = from_hex(kRequest);
    for (std::size_t bit = 0; bit < 8 * request.size(); ++bit) {
        Bytes flipped = request;
        flipped[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
        Device device(Device::plain(1));
        EXPECT_FALSE(device.hear(flipped)) << bit;
    }
}

TEST(ExBusTelemetry, FindsARequestByteByByteBehindACutFrameAfterAPause) {
    const Bytes before = reference::plain_exbus_channels(std::vector<std::uint16_t>(16, 8066));
    for (std::size_t cut = 0; cut <= before.size(); ++cut) {
        Device device(Device::plain(1));
        device.hear(Bytes(before.begin(), before.begin() + static_cast<std::ptrdiff_t>(cut)));
        bool asked = false;
        for (const std::uint8_t byte : plain_exbus_request(9)) {
            EXPECT_FALSE(asked);
            asked = device.hear({byte}, 6ms);
        }
        EXPECT_TRUE(asked) << cut;
        EXPECT_EQ(plain_exbus_answer(device.written(6ms))->packet, 9U);
    }
}

TEST(ExBusTelemetry, ARequestThatOthersFollowIsNotAnswered) {
    Device device(Device::plain(1));
    Bytes bytes = plain_exbus_request(1);
    EXPECT_TRUE(device.hear(bytes));
    EXPECT_FALSE(device.hear({0x3E}));
    EXPECT_TRUE(device.written().empty()) << "in another read";
    append(bytes, reference::plain_exbus_channels({8066}));
    EXPECT_FALSE(device.hear(bytes, 10ms));
    EXPECT_TRUE(device.written(10ms).empty()) << "in the same read";
}

TEST(ExBusTelemetry, ALateAnswerIsNotSent) {
    for (const bool late : {false, true}) {
        Device device(Device::plain(1));
        device.hear(plain_exbus_request(1));
        const Duration at = ExBusTelemetryEncoder::kMostDelay + (late ? 1ns : 0ns);
        EXPECT_EQ(device.written(at).empty(), late);
        EXPECT_TRUE(device.written().empty()) << "one request has one answer";
    }
}

TEST(ExBusTelemetry, AGapBehindARequestForgetsIt) {
    Device device(Device::plain(1));
    device.hear(plain_exbus_request(1));
    device.encoder().forget_heard();
    EXPECT_TRUE(device.written().empty());
}

/// What `check` says of `sensors = ...`, or nothing.
std::string mistake_in(std::string_view sensors, std::string_view more = "") {
    const auto loaded = load_configuration(
        "[values.supply]\nconstant = 12\n[output.jeti]\nprotocol = \"exbus-telemetry\"\n"
        "device = \"/dev/ttyAMA5\"\n" +
            std::string(more) + "sensors = " + std::string(sensors) + "\n",
        "test.toml");
    return loaded ? std::string() : loaded.error().front().text;
}

TEST(ExBusTelemetry, TakesItsKeys) {
    EXPECT_EQ(mistake_in("{ 1 = { value = \"supply\" } }"), "");
    EXPECT_EQ(mistake_in("{ 15 = { value = \"supply\", label = \"Accumulator\", unit = \"V\", "
                         "decimals = 1, form = \"decimal\" } }",
                         "label = \"My boat\"\nnumber = 65535\nbaud = 250000\n"),
              "");
    EXPECT_EQ(mistake_in("{ 2 = { value = \"supply\", form = \"latitude\" } }"), "");
}

TEST(ExBusTelemetry, RefusesWrongKeysAndSaysWhatIsAllowed) {
    for (const auto& [sensors, text] : std::vector<std::pair<std::string, std::string>>{
             {"{}", "a table by number"},
             {"5", "allowed: a table"},
             {"{ 0 = { value = \"supply\" } }", "the numbers from 1 to 15"},
             {"{ 16 = { value = \"supply\" } }", "the numbers from 1 to 15"},
             {"{ 01 = { value = \"supply\" } }", "the numbers from 1 to 15"},
             {"{ 1x = { value = \"supply\" } }", "the numbers from 1 to 15"},
             {"{ 1 = \"supply\" }", "a table with value"},
             {"{ 1 = { label = \"A\" } }", "a table with value"},
             {"{ 1 = { value = 7 } }", "the name of a value"},
             {"{ 1 = { value = \"supply\", label = \"\" } }", "1 to 11 letters"},
             {"{ 1 = { value = \"supply\", label = \"twelve chars\" } }", "1 to 11 letters"},
             {"{ 1 = { value = \"supply\", unit = \"volts!\" } }", "1 to 5 letters"},
             {"{ 1 = { value = \"supply\", decimals = 4 } }", "0 to 3"},
             {"{ 1 = { value = \"supply\", decimals = \"1\" } }", "0 to 3"},
             {"{ 1 = { value = \"supply\", form = \"gps\" } }", "\"decimal\", \"latitude\""},
             {"{ 1 = { value = \"supply\", unit = \"V\", form = \"latitude\" } }", "no unit"},
             {"{ 1 = { value = \"supply\", colour = 1 } }", "unknown; allowed: value, label"},
             {"{ 1 = { value = \"missing\" } }", "missing"},
         }) {
        EXPECT_NE(mistake_in(sensors).find(text), std::string::npos)
            << sensors << ": " << mistake_in(sensors);
    }
    EXPECT_NE(mistake_in("{ 1 = { value = \"supply\" } }", "label = \"seventeen letters\"\n")
                  .find("1 to 16"),
              std::string::npos);
}

}  // namespace
}  // namespace tribus::test::exbus_telemetry_test
