#include "transports/codecs/ibus_sensor/types.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace tribus::ibus_sensor_types_test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::array kDialects{SensorDialect::flysky, SensorDialect::betaflight,
                               SensorDialect::inav,   SensorDialect::ardupilot,
                               SensorDialect::edgetx, SensorDialect::flyplus};
using Bytes = std::vector<std::uint8_t>;

Bytes little_endian(std::uint64_t bits, std::size_t size) {
    Bytes bytes;
    for (std::size_t i = 0; i < size; ++i) {
        bytes.push_back(static_cast<std::uint8_t>(bits >> 8U * i));
    }
    return bytes;
}

/// Returns the number of a two-byte value, as in the tables of docs/protocols/ibus.md, "Sensor
/// types".
std::optional<double> number(std::uint8_t id, std::uint16_t raw,
                             SensorDialect dialect = SensorDialect::flysky, std::size_t field = 0) {
    const SensorTypes types(dialect);
    const SensorField& found = types.find(id)->fields.at(field);
    return number_of(found, *raw_in(found, little_endian(raw, 2)));
}

TEST(SensorTypes, IdsOfTheReferenceHaveTheirNames) {
    const SensorTypes types;
    const std::vector<std::pair<std::uint8_t, std::string_view>> expected{
        {0x01, "temperature"},     {0x02, "rotation_speed"}, {0x03, "external_voltage"},
        {0x05, "battery_current"}, {0x0B, "gps_status"},     {0x41, "pressure"},
        {0x80, "latitude"},        {0x8A, "user_6"},         {0xFD, "gps_full"}};
    for (const auto& [id, name] : expected) {
        ASSERT_NE(types.find(id), nullptr) << name;
        EXPECT_EQ(types.find(id)->name, name);
        EXPECT_EQ(types.find(name)->id, id);
    }
    EXPECT_EQ(types.find(0xFF), nullptr);
    EXPECT_EQ(types.find("nothing"), nullptr);
}

TEST(SensorTypes, NoTwoHaveTheSameIdOrTheSameNameInAnyDialect) {
    for (const SensorDialect dialect : kDialects) {
        const SensorTypes types(dialect);
        std::set<std::uint8_t> ids;
        std::set<std::string> names;
        for (const SensorType& type : types.all()) {
            EXPECT_TRUE(ids.insert(type.id).second) << type.name;
            EXPECT_TRUE(names.insert(type.name).second) << type.name;
        }
    }
}

TEST(SensorTypes, FieldsFillTheirTypeAndDoNotOverlap) {
    for (const SensorDialect dialect : kDialects) {
        const SensorTypes types(dialect);
        for (const SensorType& type : types.all()) {
            std::vector<int> used(type.size * 8U);
            for (const SensorField& field : type.fields) {
                for (unsigned bit = 0; bit < field.bits; ++bit) {
                    ++used.at(field.first_bit + bit);
                }
            }
            EXPECT_EQ(used, std::vector<int>(type.size * 8U, 1)) << type.name;
        }
    }
}

TEST(SensorTypes, AnOwnTypeReplacesThoseOfItsIdAndOfItsName) {
    const SensorType own{.name = "temperature", .id = 0x03, .size = 4, .fields = {SensorField{}}};
    const SensorTypes types(SensorDialect::flysky, {own});
    EXPECT_EQ(types.find(0x03)->name, "temperature");
    EXPECT_EQ(types.find("temperature")->size, 4);
    EXPECT_EQ(types.find(0x01), nullptr);
    EXPECT_EQ(types.find("external_voltage"), nullptr);
}

TEST(SensorTypes, NumbersAreThoseOfTheReference) {
    EXPECT_DOUBLE_EQ(*number(0x01, 0), -40);
    EXPECT_DOUBLE_EQ(*number(0x01, 400), 0);
    EXPECT_DOUBLE_EQ(*number(0x01, 65535), 6513.5);
    EXPECT_DOUBLE_EQ(*number(0x02, 65535), 65535);
    EXPECT_DOUBLE_EQ(*number(0x05, 1234), 12.34);
    EXPECT_DOUBLE_EQ(*number(0x12, 0xFFFF), -0.01);
    EXPECT_DOUBLE_EQ(*number(0x7E, 1000), 100);
    EXPECT_DOUBLE_EQ(*number(0xFC, 70), -70);
}

// The genuine CVT01 of the recordings, with an open input.
TEST(SensorTypes, ExternalVoltageHasASign) {
    EXPECT_DOUBLE_EQ(*number(0x03, 0xFFFF), -0.01);
    EXPECT_DOUBLE_EQ(*number(0x03, 0xFFFE), -0.02);
    EXPECT_DOUBLE_EQ(*number(0x03, 0x7FFF), 327.67);
}

TEST(SensorTypes, CodesForNotAvailableHaveNoNumber) {
    EXPECT_EQ(number(0x03, 0x8000), std::nullopt);
    EXPECT_EQ(number(0x0A, 0xFFFF), std::nullopt);
    EXPECT_EQ(number(0x16, 255), std::nullopt);
    EXPECT_EQ(number(0x04, 0x8000, SensorDialect::edgetx), std::nullopt);
}

TEST(SensorTypes, YawReadsRightWhetherItIsSentAsHalfTurnsOrAsAFullTurn) {
    for (unsigned raw = 0; raw <= 36000; ++raw) {
        EXPECT_DOUBLE_EQ(*number(0x11, static_cast<std::uint16_t>(raw)), raw * 0.01);
    }
    for (int raw = -18000; raw < 0; ++raw) {
        EXPECT_DOUBLE_EQ(*number(0x11, static_cast<std::uint16_t>(raw)), raw * 0.01);
    }
}

TEST(SensorTypes, GpsStatusIsFixThenSatellitesButTheOtherWayRoundWithInav) {
    EXPECT_EQ(number(0x0B, 0x0903, SensorDialect::flysky, 0), 3);
    EXPECT_EQ(number(0x0B, 0x0903, SensorDialect::flysky, 1), 9);
    const SensorTypes inav(SensorDialect::inav);
    EXPECT_EQ(inav.find(0x0B)->fields[0].name, "satellites");
    EXPECT_EQ(number(0x0B, 0x0309, SensorDialect::inav, 0), 9);
}

TEST(SensorTypes, PressurePacksATemperatureOnTop) {
    const SensorTypes types;
    const SensorType& type = *types.find(0x41);
    const Bytes data = little_endian(101325U | 600U << 19U, 4);
    EXPECT_DOUBLE_EQ(*number_of(type.fields[0], *raw_in(type.fields[0], data)), 101325);
    EXPECT_DOUBLE_EQ(*number_of(type.fields[1], *raw_in(type.fields[1], data)), 20);
}

TEST(SensorTypes, DialectsReadTheDisputedTypesTheirOwnWay) {
    EXPECT_DOUBLE_EQ(*number(0x0C, 1000, SensorDialect::betaflight), 9.80665);
    EXPECT_DOUBLE_EQ(*number(0x0C, 1000, SensorDialect::ardupilot), 1);
    EXPECT_DOUBLE_EQ(*number(0x0C, 1000, SensorDialect::flysky), 10);
    EXPECT_DOUBLE_EQ(*number(0x0A, 10000, SensorDialect::betaflight), 10);
    EXPECT_DOUBLE_EQ(*number(0x41, 10132, SensorDialect::inav), 101320);
    EXPECT_DOUBLE_EQ(*number(0x04, 0xFFFF, SensorDialect::edgetx), -0.1);
    EXPECT_EQ(SensorTypes(SensorDialect::flyplus).find(0x80)->name, "course_over_ground");
    EXPECT_EQ(SensorTypes(SensorDialect::flyplus).find(0x83)->name, "latitude");
}

// Betaflight's ibus_shared.c writes both with the same function, setValue.
TEST(SensorTypes, BetaflightsCombinedTypesReadAsItsSingleOnes) {
    const SensorTypes types(SensorDialect::betaflight);
    const std::vector<std::pair<std::uint8_t, Bytes>> combined{
        {0xEF, {0x0C, 0x0D, 0x0E, 0x0F, 0x10, 0x11}}, {0xF0, {0x03, 0x04, 0x05, 0x06, 0x07}}};
    for (const auto& [id, singles] : combined) {
        const SensorType& type = *types.find(id);
        ASSERT_EQ(type.fields.size(), singles.size()) << type.name;
        for (std::size_t i = 0; i < singles.size(); ++i) {
            const SensorType& single = *types.find(singles[i]);
            SensorField expected = single.fields.at(0);
            expected.name = single.name;
            expected.first_bit = static_cast<unsigned>(16 * i);
            EXPECT_EQ(type.fields[i], expected) << type.name << ": " << single.name;
        }
    }
}

// 1000 is 1 g; -100 is -1 A. In FlySky's own table they would be 10 m/s^2 and 654.36 A.
TEST(SensorTypes, BetaflightsCombinedTypesHaveAccelerationInThousandthsOfGAndASignedCurrent) {
    const SensorTypes types(SensorDialect::betaflight);
    const SensorField& acceleration = types.find(0xEF)->fields.at(2);
    EXPECT_DOUBLE_EQ(*number_of(acceleration, 1000), 9.80665);
    const SensorField& current = types.find(0xF0)->fields.at(2);
    const Bytes reply{0xE8, 0x03, 0x90, 0x01, 0x9C, 0xFF, 0x32, 0x00, 0xDC, 0x05};
    EXPECT_DOUBLE_EQ(*number_of(current, *raw_in(current, reply)), -1);
    EXPECT_EQ(types.find(0xF0)->fields.at(4).name, "throttle_or_capacity");
}

TEST(SensorValue, EveryRawValueOfEveryTwoByteTypeRoundTrips) {
    std::vector<SensorType> seen;
    for (const SensorDialect dialect : kDialects) {
        const SensorTypes types(dialect);
        for (const SensorType& type : types.all()) {
            // Most dialects have most types in common.
            if (type.size != 2 || std::ranges::find(seen, type) != seen.end()) {
                continue;
            }
            seen.push_back(type);
            for (unsigned bits = 0; bits <= 0xFFFF; ++bits) {
                const std::array data{static_cast<std::uint8_t>(bits),
                                      static_cast<std::uint8_t>(bits >> 8U)};
                std::array<std::uint8_t, 2> again{};
                for (const SensorField& field : type.fields) {
                    const std::int64_t raw = *raw_in(field, data);
                    const auto number = number_of(field, raw);
                    put_raw(field, number ? raw_of(field, *number) : raw, again);
                }
                ASSERT_EQ(again, data) << type.name << " " << bits;
            }
        }
    }
}

RC_GTEST_PROP(SensorValue, AnyLongValueRoundTrips, ()) {
    const SensorTypes types(*rc::gen::elementOf(kDialects));
    for (const SensorType& type : types.all()) {
        const auto data = *rc::gen::container<Bytes>(type.size, rc::gen::arbitrary<std::uint8_t>());
        Bytes again(type.size);
        for (const SensorField& field : type.fields) {
            const std::int64_t raw = *raw_in(field, data);
            const auto number = number_of(field, raw);
            put_raw(field, number ? raw_of(field, *number) : raw, again);
        }
        RC_ASSERT(again == data);
    }
}

TEST(SensorValue, EveryFieldSaturatesAtBothEndsAndNeverSaysNotAvailable) {
    for (const SensorDialect dialect : kDialects) {
        const SensorTypes types(dialect);
        for (const SensorType& type : types.all()) {
            for (const SensorField& field : type.fields) {
                const double up = field.scale > 0 ? 1 : -1;
                for (const double beyond : {1e300, kInfinity}) {
                    const std::int64_t most = raw_of(field, up * beyond);
                    const std::int64_t least = raw_of(field, -up * beyond);
                    EXPECT_NE(most, field.not_available) << type.name;
                    EXPECT_NE(least, field.not_available) << type.name;
                    EXPECT_GE(most - least, (std::int64_t{1} << field.bits) - 2) << type.name;
                    Bytes data(type.size);
                    put_raw(field, most, data);
                    EXPECT_EQ(raw_in(field, data), most) << type.name;
                }
            }
        }
    }
}

TEST(SensorValue, SaturatedExternalVoltageIsANumber) {
    const SensorTypes types;
    const SensorField& field = types.find(0x03)->fields.front();
    EXPECT_EQ(raw_of(field, 1000), 0x7FFF);
    EXPECT_EQ(raw_of(field, -327.68), -0x7FFF);
    EXPECT_EQ(raw_of(field, -kInfinity), -0x7FFF);
}

TEST(SensorValue, NotANumberIsNotAvailableOrRawZero) {
    const SensorTypes types;
    EXPECT_EQ(raw_of(types.find(0x03)->fields.front(), std::nan("")), -0x8000);
    EXPECT_EQ(raw_of(types.find(0x01)->fields.front(), std::nan("")), 0);
}

TEST(SensorValue, NumbersAreRoundedHalvesAwayFromZero) {
    const SensorField field{.name = {}, .unit = {}, .is_signed = true, .scale = 2};
    EXPECT_EQ(raw_of(field, 3), 2);
    EXPECT_EQ(raw_of(field, -3), -2);
    EXPECT_EQ(raw_of(field, 2.9), 1);
}

TEST(SensorValue, AnUnsignedNumberOf64BitsSaturatesAtWhatARawValueHolds) {
    const SensorField field{.name = {}, .unit = {}, .bits = 64};
    EXPECT_EQ(raw_of(field, 1e30), std::numeric_limits<std::int64_t>::max());
    EXPECT_EQ(raw_of(field, -1), 0);
}

TEST(SensorValue, DataThatAreTooShortHaveNoRawValueAndAreNotWritten) {
    const SensorField field{.name = {}, .unit = {}, .bits = 32};
    Bytes data{1, 2};
    EXPECT_EQ(raw_in(field, data), std::nullopt);
    put_raw(field, -1, data);
    EXPECT_EQ(data, (Bytes{1, 2}));
}

TEST(SensorValue, WritingAFieldLeavesTheOtherBits) {
    const SensorField field{.name = {}, .unit = {}, .first_bit = 3, .bits = 7};
    Bytes data{0xFF, 0xFF};
    put_raw(field, 0, data);
    EXPECT_EQ(data, (Bytes{0x07, 0xFC}));
}

TEST(WithSize, ASizeThatTheSensorSaysMakesOnePlainNumber) {
    const SensorTypes types;
    const SensorType wide = with_size(*types.find(0x03), 4);
    const Bytes data = little_endian(0xFFFFFFFE, 4);
    EXPECT_EQ(wide.size, 4);
    EXPECT_EQ(raw_in(wide.fields.front(), data), -2);
    EXPECT_DOUBLE_EQ(*number_of(wide.fields.front(), -2), -0.02);
}

TEST(WithSize, FirstOfSeveralFieldsStays) {
    const SensorTypes types;
    const SensorType narrow = with_size(*types.find(0x41), 2);
    ASSERT_EQ(narrow.fields.size(), 1U);
    EXPECT_EQ(narrow.fields.front().unit, "Pa");
    EXPECT_EQ(narrow.fields.front().bits, 16U);
}

TEST(WithSize, ItsOwnSizeAndThoseOfNoNumberChangeNothing) {
    const SensorTypes types;
    for (const std::uint8_t size : Bytes{0, 4, 9, 14}) {
        EXPECT_EQ(with_size(*types.find(0x41), size).fields.size(), 2U) << int{size};
    }
}

}  // namespace
}  // namespace tribus::ibus_sensor_types_test
