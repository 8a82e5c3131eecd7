#include "core/unit.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace tribus {
namespace {

/// Units of one quantity can be converted into each other.
enum class Measured : std::uint8_t {
    voltage,
    current,
    charge,
    power,
    energy,
    temperature,
    rotation,
    frequency,
    speed,
    length,
    pressure,
    acceleration,
    angle,
    time,
    share,
    gain,
    level,
    volume,
};

/// A number in this unit is number * numerator / denominator + offset in the first unit of its
/// quantity. A fraction, because 1 / 1000 and 5 / 18 have no exact binary value.
struct Unit {
    std::string_view spelling;
    Measured measured;
    double numerator = 1;
    double denominator = 1;
    double offset = 0;
};

constexpr double kPi = 3.14159265358979323846;
constexpr double kZeroCelsiusInKelvin = 273.15;
/// 0 degF is (0 - 32) * 5 / 9 degC.
constexpr double kZeroFahrenheitInCelsius = -160.0 / 9.0;
constexpr double kFootInMetres = 0.3048;
constexpr double kMileInMetres = 1609.344;
constexpr double kNauticalMileInMetres = 1852;
constexpr double kPsiInPascals = 6894.757293168361;
constexpr double kStandardGravity = 9.80665;

// "\u00B0" is the degree sign, "\u2103" degrees Celsius, "\u00B2" superscript 2, "\u00B5" micro,
// "\u03BC" the Greek letter that many write instead.
constexpr std::array kUnits{
    Unit{"V", Measured::voltage},
    Unit{"Volt", Measured::voltage},
    Unit{"Volts", Measured::voltage},
    Unit{"volt", Measured::voltage},
    Unit{"volts", Measured::voltage},
    Unit{"uV", Measured::voltage, 1, 1e6},
    Unit{"mV", Measured::voltage, 1, 1e3},
    Unit{"kV", Measured::voltage, 1e3},

    Unit{"A", Measured::current},
    Unit{"Amp", Measured::current},
    Unit{"Amps", Measured::current},
    Unit{"amps", Measured::current},
    Unit{"Ampere", Measured::current},
    Unit{"uA", Measured::current, 1, 1e6},
    Unit{"mA", Measured::current, 1, 1e3},
    Unit{"kA", Measured::current, 1e3},

    Unit{"Ah", Measured::charge},
    Unit{"mAh", Measured::charge, 1, 1e3},

    Unit{"W", Measured::power},
    Unit{"Watt", Measured::power},
    Unit{"mW", Measured::power, 1, 1e3},
    Unit{"kW", Measured::power, 1e3},
    Unit{"MW", Measured::power, 1e6},

    Unit{"Wh", Measured::energy},
    Unit{"mWh", Measured::energy, 1, 1e3},
    Unit{"kWh", Measured::energy, 1e3},

    Unit{"degC", Measured::temperature},
    Unit{"C", Measured::temperature},
    Unit{"\u00B0C", Measured::temperature},
    Unit{"\u00B0 C", Measured::temperature},
    Unit{"\u2103", Measured::temperature},
    Unit{"deg C", Measured::temperature},
    Unit{"Deg C", Measured::temperature},
    Unit{"DegC", Measured::temperature},
    Unit{"deg_C", Measured::temperature},
    Unit{"celsius", Measured::temperature},
    Unit{"Celsius", Measured::temperature},
    Unit{"K", Measured::temperature, 1, 1, -kZeroCelsiusInKelvin},
    Unit{"degK", Measured::temperature, 1, 1, -kZeroCelsiusInKelvin},
    Unit{"Kelvin", Measured::temperature, 1, 1, -kZeroCelsiusInKelvin},
    Unit{"degF", Measured::temperature, 5, 9, kZeroFahrenheitInCelsius},
    Unit{"F", Measured::temperature, 5, 9, kZeroFahrenheitInCelsius},
    Unit{"\u00B0F", Measured::temperature, 5, 9, kZeroFahrenheitInCelsius},
    Unit{"deg F", Measured::temperature, 5, 9, kZeroFahrenheitInCelsius},
    Unit{"DegF", Measured::temperature, 5, 9, kZeroFahrenheitInCelsius},

    Unit{"rpm", Measured::rotation},
    Unit{"RPM", Measured::rotation},
    Unit{"Rpm", Measured::rotation},
    Unit{"1/min", Measured::rotation},
    Unit{"/min", Measured::rotation},
    Unit{"U/min", Measured::rotation},
    Unit{"r/min", Measured::rotation},
    Unit{"rev/min", Measured::rotation},
    Unit{"min-1", Measured::rotation},
    Unit{"min^-1", Measured::rotation},
    Unit{"deg/s", Measured::rotation, 1, 6},
    Unit{"\u00B0/s", Measured::rotation, 1, 6},
    Unit{"rad/s", Measured::rotation, 30, kPi},

    Unit{"Hz", Measured::frequency},
    Unit{"kHz", Measured::frequency, 1e3},
    Unit{"MHz", Measured::frequency, 1e6},

    Unit{"m/s", Measured::speed},
    Unit{"mps", Measured::speed},
    Unit{"cm/s", Measured::speed, 1, 100},
    Unit{"mm/s", Measured::speed, 1, 1e3},
    Unit{"km/h", Measured::speed, 5, 18},
    Unit{"Km/h", Measured::speed, 5, 18},
    Unit{"KM/H", Measured::speed, 5, 18},
    Unit{"kmh", Measured::speed, 5, 18},
    Unit{"kph", Measured::speed, 5, 18},
    Unit{"KPH", Measured::speed, 5, 18},
    Unit{"mph", Measured::speed, kMileInMetres, 3600},
    Unit{"MPH", Measured::speed, kMileInMetres, 3600},
    Unit{"kn", Measured::speed, kNauticalMileInMetres, 3600},
    Unit{"kt", Measured::speed, kNauticalMileInMetres, 3600},
    Unit{"kts", Measured::speed, kNauticalMileInMetres, 3600},
    Unit{"knot", Measured::speed, kNauticalMileInMetres, 3600},
    Unit{"knots", Measured::speed, kNauticalMileInMetres, 3600},
    Unit{"ft/s", Measured::speed, kFootInMetres},

    Unit{"m", Measured::length},
    Unit{"meter", Measured::length},
    Unit{"meters", Measured::length},
    Unit{"metre", Measured::length},
    Unit{"metres", Measured::length},
    Unit{"cm", Measured::length, 1, 100},
    Unit{"mm", Measured::length, 1, 1e3},
    Unit{"km", Measured::length, 1e3},
    Unit{"ft", Measured::length, kFootInMetres},
    Unit{"feet", Measured::length, kFootInMetres},
    Unit{"mi", Measured::length, kMileInMetres},
    Unit{"miles", Measured::length, kMileInMetres},
    Unit{"nmi", Measured::length, kNauticalMileInMetres},

    Unit{"Pa", Measured::pressure},
    Unit{"hPa", Measured::pressure, 100},
    Unit{"mbar", Measured::pressure, 100},
    Unit{"kPa", Measured::pressure, 1e3},
    Unit{"kpa", Measured::pressure, 1e3},
    Unit{"KPa", Measured::pressure, 1e3},
    Unit{"MPa", Measured::pressure, 1e6},
    Unit{"bar", Measured::pressure, 1e5},
    Unit{"Bar", Measured::pressure, 1e5},
    Unit{"psi", Measured::pressure, kPsiInPascals},
    Unit{"PSI", Measured::pressure, kPsiInPascals},

    Unit{"m/s^2", Measured::acceleration},
    Unit{"m/s2", Measured::acceleration},
    Unit{"m/s/s", Measured::acceleration},
    Unit{"m/s\u00B2", Measured::acceleration},
    Unit{"g", Measured::acceleration, kStandardGravity},
    Unit{"G", Measured::acceleration, kStandardGravity},
    Unit{"mg", Measured::acceleration, kStandardGravity, 1e3},

    Unit{"deg", Measured::angle},
    Unit{"Deg", Measured::angle},
    Unit{"\u00B0", Measured::angle},
    Unit{"degree", Measured::angle},
    Unit{"degrees", Measured::angle},
    Unit{"rad", Measured::angle, 180, kPi},
    Unit{"mrad", Measured::angle, 0.18, kPi},
    Unit{"1e-8 deg", Measured::angle, 1, 1e8},

    Unit{"s", Measured::time},
    Unit{"sec", Measured::time},
    Unit{"Sec", Measured::time},
    Unit{"seconds", Measured::time},
    Unit{"ms", Measured::time, 1, 1e3},
    Unit{"msec", Measured::time, 1, 1e3},
    Unit{"us", Measured::time, 1, 1e6},
    Unit{"\u00B5s", Measured::time, 1, 1e6},
    Unit{"\u03BCs", Measured::time, 1, 1e6},
    Unit{"min", Measured::time, 60},
    Unit{"minutes", Measured::time, 60},
    Unit{"h", Measured::time, 3600},
    Unit{"hr", Measured::time, 3600},
    Unit{"hours", Measured::time, 3600},

    Unit{"%", Measured::share},
    Unit{"percent", Measured::share},
    Unit{"Percent", Measured::share},
    Unit{"ratio", Measured::share, 100},

    Unit{"dB", Measured::gain},
    Unit{"dBm", Measured::level},

    Unit{"l", Measured::volume},
    Unit{"L", Measured::volume},
    Unit{"ml", Measured::volume, 1, 1e3},
    Unit{"mL", Measured::volume, 1, 1e3},
    Unit{"cm3", Measured::volume, 1, 1e3},
};

constexpr bool each_spelling_once() {
    for (std::size_t i = 0; i < kUnits.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            if (kUnits[i].spelling == kUnits[j].spelling) {
                return false;
            }
        }
    }
    return true;
}
static_assert(each_spelling_once());

const Unit* find(std::string_view spelling) {
    const auto* found = std::ranges::find(kUnits, spelling, &Unit::spelling);
    return found == kUnits.end() ? nullptr : found;
}

}  // namespace

std::optional<UnitConversion> unit_conversion(std::string_view from, std::string_view to) {
    if (from == to) {
        return UnitConversion{};
    }
    const Unit* source = find(from);
    const Unit* target = find(to);
    if (source == nullptr || target == nullptr || source->measured != target->measured) {
        return std::nullopt;
    }
    return UnitConversion{
        .factor =
            source->numerator * target->denominator / (source->denominator * target->numerator),
        .offset = (source->offset - target->offset) * target->denominator / target->numerator};
}

bool may_be_sent(std::string_view from, std::string_view to) {
    return from.empty() || to.empty() || unit_conversion(from, to).has_value();
}

bool is_known_unit(std::string_view unit) {
    return find(unit) != nullptr;
}

}  // namespace tribus
