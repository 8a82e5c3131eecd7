#pragma once

#include <optional>
#include <string_view>

/// Units as data bases and people spell them, and how a number gets from one into another. Pure
/// and reentrant.
namespace tribus {

/// The number in the other unit is number * factor + offset.
struct UnitConversion {
    double factor = 1;
    double offset = 0;

    double apply(double number) const { return number * factor + offset; }
    bool operator==(const UnitConversion&) const = default;
};

/// Nothing where the units measure different things, or one of them is not known. The identity for
/// equal texts, known or not. Rates of a signal in Hz are no rotation in rpm: nothing.
std::optional<UnitConversion> unit_conversion(std::string_view from, std::string_view to);

/// In any of its spellings, which are compared to the letter: "mW" is no "MW". The empty text is
/// no unit.
bool is_known_unit(std::string_view unit);

}  // namespace tribus
