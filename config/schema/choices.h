#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

#include "config/schema/schema.h"

/// The words of the configuration language for the values of an enumeration.
namespace tribus {

/// Specialised for each enumeration of the language: `kAll`, in the order of its values.
template <class Choice>
struct ChoiceWords;

template <>
struct ChoiceWords<Realtime> {
    static constexpr std::array<std::string_view, 3> kAll{"auto", "off", "require"};
};
template <>
struct ChoiceWords<ScheduleKind> {
    static constexpr std::array<std::string_view, 2> kAll{"follow", "grid"};
};
template <>
struct ChoiceWords<Phase> {
    static constexpr std::array<std::string_view, 2> kAll{"free", "locked"};
};
template <>
struct ChoiceWords<ForeignSender> {
    static constexpr std::array<std::string_view, 2> kAll{"failsafe", "ignore"};
};
template <>
struct ChoiceWords<SelectionMode> {
    static constexpr std::array<std::string_view, 4> kAll{"priority", "sticky", "freshest",
                                                          "median"};
};
template <>
struct ChoiceWords<FailsafeAction> {
    static constexpr std::array<std::string_view, 3> kAll{"preset", "hold", "silence"};
};
template <>
struct ChoiceWords<LineRole> {
    static constexpr std::array<std::string_view, 8> kAll{
        "link", "failsafe", "fresh", "force_failsafe", "select", "inverter", "button", "switch"};
};
template <>
struct ChoiceWords<GpioBias> {
    static constexpr std::array<std::string_view, 4> kAll{"as_is", "pull_up", "pull_down", "none"};
};
template <>
struct ChoiceWords<BusRole> {
    static constexpr std::array<std::string_view, 2> kAll{"sensor", "receiver"};
};
template <>
struct ChoiceWords<Wires> {
    static constexpr std::array<std::string_view, 3> kAll{"auto", "one", "two"};
};
template <>
struct ChoiceWords<SensorDialect> {
    static constexpr auto kAll = kSensorDialectNames;
};

template <class Choice>
constexpr std::string_view word_of(Choice choice) {
    return ChoiceWords<Choice>::kAll[static_cast<std::size_t>(choice)];
}

template <class Choice>
constexpr std::optional<Choice> choice_named(std::string_view word) {
    const auto& words = ChoiceWords<Choice>::kAll;
    const auto found = std::ranges::find(words, word);
    return found == words.end() ? std::nullopt : std::optional(Choice(found - words.begin()));
}

}  // namespace tribus
