#pragma once

#include <optional>
#include <string_view>

/// Units in the spellings that CAN databases and people use, and conversion between them. Pure and
/// reentrant.
namespace tribus {

/// Converts a number into another unit: number * factor + offset.
struct UnitConversion {
    double factor = 1;
    double offset = 0;

    double apply(double number) const { return number * factor + offset; }
    bool operator==(const UnitConversion&) const = default;
};

/// Returns nothing if the units measure different quantities or if one of them is unknown. Equal
/// texts give the identity, known or not. Hz and rpm do not convert: a signal's frequency is no
/// rotation.
std::optional<UnitConversion> unit_conversion(std::string_view from, std::string_view to);

/// Whether a number in `from` may be sent where `to` is meant: converted, or as it is where one of
/// both has no unit. Not if they measure different quantities or one of them is unknown.
bool may_be_sent(std::string_view from, std::string_view to);

/// Whether `unit` is a known spelling. Case counts: "mW" is not "MW". The empty text is not a unit.
bool is_known_unit(std::string_view unit);

}  // namespace tribus
