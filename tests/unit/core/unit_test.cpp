#include "core/unit.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <optional>
#include <ostream>
#include <string_view>
#include <utility>

namespace tribus::unit_test {
namespace {

struct Converted {
    std::string_view from;
    std::string_view to;
    double number = 0;
    double expected = 0;
};

std::ostream& operator<<(std::ostream& out, const Converted& converted) {
    return out << converted.number << " " << converted.from << " in " << converted.to;
}

class ConvertedUnit : public testing::TestWithParam<Converted> {};

TEST_P(ConvertedUnit, IsTheNumberInTheOtherUnit) {
    const auto conversion = unit_conversion(GetParam().from, GetParam().to);
    ASSERT_TRUE(conversion);
    EXPECT_NEAR(conversion->apply(GetParam().number), GetParam().expected,
                1e-12 * (1 + std::abs(GetParam().expected)));
}

// Definitions of the units: the inch of 25.4 mm, the nautical mile of 1852 m, the standard gravity
// of 9.80665 m/s^2, the zero of the Celsius scale at 273.15 K.
INSTANTIATE_TEST_SUITE_P(
    EachQuantity, ConvertedUnit,
    testing::Values(Converted{"mV", "V", 12600, 12.6}, Converted{"kV", "mV", 0.4, 400000},
                    Converted{"V", "uV", 1.5, 1.5e6}, Converted{"mA", "A", -1500, -1.5},
                    Converted{"Ah", "mAh", 2.2, 2200}, Converted{"kW", "W", 1.5, 1500},
                    Converted{"mW", "MW", 1e9, 1}, Converted{"kWh", "Wh", 0.5, 500},
                    Converted{"degC", "K", 25, 298.15}, Converted{"K", "C", 0, -273.15},
                    Converted{"degF", "degC", 32, 0}, Converted{"degF", "degC", 212, 100},
                    Converted{"degC", "\u00B0F", -40, -40}, Converted{"K", "degF", 310.15, 98.6},
                    Converted{"deg/s", "rpm", 360, 60},
                    Converted{"rpm", "rad/s", 30, 3.14159265358979},
                    Converted{"kHz", "Hz", 0.1, 100}, Converted{"km/h", "m/s", 36, 10},
                    Converted{"m/s", "kph", 10, 36}, Converted{"mph", "km/h", 100, 160.9344},
                    Converted{"kn", "km/h", 10, 18.52}, Converted{"ft/s", "m/s", 10, 3.048},
                    Converted{"cm", "m", 150, 1.5}, Converted{"km", "mm", 0.002, 2000},
                    Converted{"ft", "cm", 1, 30.48}, Converted{"nmi", "m", 1, 1852},
                    Converted{"hPa", "Pa", 1013.25, 101325}, Converted{"mbar", "hPa", 1000, 1000},
                    Converted{"bar", "kPa", 1.5, 150}, Converted{"psi", "Pa", 1, 6894.757293168361},
                    Converted{"g", "m/s^2", 2, 19.6133}, Converted{"m/s2", "mg", 9.80665, 1000},
                    Converted{"rad", "deg", 3.14159265358979, 180},
                    Converted{"mrad", "rad", 1500, 1.5}, Converted{"ms", "s", 20, 0.02},
                    Converted{"h", "min", 1.5, 90}, Converted{"\u03BCs", "\u00B5s", 7, 7},
                    Converted{"ratio", "%", 0.42, 42}, Converted{"%", "ratio", 100, 1},
                    Converted{"L", "ml", 0.5, 500}));

TEST(UnitConversion, IsTheIdentityForEqualTextsKnownOrNot) {
    EXPECT_EQ(unit_conversion("V", "V"), UnitConversion{});
    EXPECT_EQ(unit_conversion("sheep", "sheep"), UnitConversion{});
    EXPECT_EQ(unit_conversion("", ""), UnitConversion{});
}

TEST(UnitConversion, IsExactWhereTheFactorIs) {
    EXPECT_EQ(unit_conversion("V", "mV"), (UnitConversion{1000, 0}));
    EXPECT_EQ(unit_conversion("mV", "V"), (UnitConversion{0.001, 0}));
    EXPECT_EQ(unit_conversion("mV", "kV"), (UnitConversion{1e-6, 0}));
    EXPECT_EQ(unit_conversion("degC", "K"), (UnitConversion{1, 273.15}));
}

TEST(UnitConversion, IsNoneBetweenDifferentQuantities) {
    EXPECT_EQ(unit_conversion("V", "A"), std::nullopt);
    EXPECT_EQ(unit_conversion("Hz", "rpm"), std::nullopt);
    EXPECT_EQ(unit_conversion("dB", "dBm"), std::nullopt);
    EXPECT_EQ(unit_conversion("deg", "degC"), std::nullopt);
}

TEST(UnitConversion, IsNoneFromOrToAUnitThatIsNotKnown) {
    EXPECT_EQ(unit_conversion("", "V"), std::nullopt);
    EXPECT_EQ(unit_conversion("V", ""), std::nullopt);
    EXPECT_EQ(unit_conversion("V", "sheep"), std::nullopt);
}

TEST(UnitOfASentNumber, MustConvertUnlessOneOfBothIsMissing) {
    for (const auto& [from, to] :
         {std::pair{"mV", "V"}, {"", "V"}, {"V", ""}, {"", ""}, {"sheep", "sheep"}}) {
        EXPECT_TRUE(may_be_sent(from, to)) << from << " to " << to;
    }
    for (const auto& [from, to] : {std::pair{"degC", "V"}, {"bananas", "V"}, {"V", "bananas"}}) {
        EXPECT_FALSE(may_be_sent(from, to)) << from << " to " << to;
    }
}

TEST(KnownUnit, IsComparedToTheLetter) {
    EXPECT_TRUE(is_known_unit("mV"));
    EXPECT_FALSE(is_known_unit("MV"));
    EXPECT_FALSE(is_known_unit("v"));
    EXPECT_FALSE(is_known_unit(""));
}

TEST(KnownUnit, HasTheSpellingsOfDbcFiles) {
    for (const std::string_view celsius :
         {"degC", "C", "\u00B0C", "\u2103", "deg C", "DegC", "deg_C", "Celsius"}) {
        EXPECT_EQ(unit_conversion(celsius, "degC"), UnitConversion{}) << celsius;
    }
    for (const std::string_view rpm : {"rpm", "RPM", "1/min", "/min", "U/min", "min^-1"}) {
        EXPECT_EQ(unit_conversion(rpm, "rpm"), UnitConversion{}) << rpm;
    }
}

}  // namespace
}  // namespace tribus::unit_test
