#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "config/schema/choices.h"
#include "core/pulse.h"
#include "core/setting.h"
#include "core/time.h"
#include "pipelines/rules/settings.h"

/// The member of a struct that a row of the key table sets.
namespace tribus {

/// Access to one member, in values of the configuration language. A row without a member has null
/// pointers. `object` is the struct that `owner` stands for.
struct Field {
    const char* owner = nullptr;
    void (*set)(void* object, const SettingValue& value) = nullptr;
    /// Absent: the member is empty.
    std::optional<SettingValue> (*get)(const void* object) = nullptr;
    /// `get` of a new object.
    std::optional<SettingValue> (*initial)() = nullptr;
};

/// Stands for a type of struct. Its address counts.
template <class Owner>
inline constexpr char kOwner{};

/// How a type of member is written in the language.
template <class T>
struct Notation {
    static_assert(std::is_enum_v<T>, "this type of member needs a Notation");
    static constexpr SettingType kType = SettingType::choice;
    static T from(const SettingValue& value) {
        return *choice_named<T>(std::get<std::string>(value));
    }
    static std::optional<SettingValue> to(T member) { return std::string(word_of(member)); }
};

/// Types that a SettingValue has.
template <class T, SettingType type>
struct SameNotation {
    static constexpr SettingType kType = type;
    static const T& from(const SettingValue& value) { return std::get<T>(value); }
    static std::optional<SettingValue> to(const T& member) { return member; }
};
template <>
struct Notation<bool> : SameNotation<bool, SettingType::boolean> {};
template <>
struct Notation<Duration> : SameNotation<Duration, SettingType::duration> {};
template <>
struct Notation<double> : SameNotation<double, SettingType::number> {};
template <>
struct Notation<SettingFile> : SameNotation<SettingFile, SettingType::file> {};
template <>
struct Notation<KeyFile> : SameNotation<KeyFile, SettingType::key_file> {};

template <>
struct Notation<std::string> : SameNotation<std::string, SettingType::text> {
    static std::optional<SettingValue> to(const std::string& member) {
        return member.empty() ? std::nullopt : std::optional<SettingValue>(member);
    }
};

template <std::integral T>
struct Notation<T> {
    static constexpr SettingType kType = SettingType::integer;
    static T from(const SettingValue& value) {
        return static_cast<T>(std::get<std::int64_t>(value));
    }
    static std::optional<SettingValue> to(T member) { return static_cast<std::int64_t>(member); }
};

/// A channel counts from 1 in the language, and from 0 in the program.
struct ChannelNotation {
    static constexpr SettingType kType = SettingType::integer;
    static std::size_t from(const SettingValue& value) {
        return static_cast<std::size_t>(std::get<std::int64_t>(value) - 1);
    }
    static std::optional<SettingValue> to(std::size_t member) {
        return static_cast<std::int64_t>(member) + 1;
    }
};

template <>
struct Notation<Pulse> {
    static constexpr SettingType kType = SettingType::pulse;
    static Pulse from(const SettingValue& value) {
        return Pulse::from_fractional_microseconds(std::get<double>(value));
    }
    static std::optional<SettingValue> to(Pulse member) { return member.microseconds(); }
};

template <>
struct Notation<PulseRange> {
    static constexpr SettingType kType = SettingType::pulses;
    static PulseRange from(const SettingValue& value) {
        const auto& range = std::get<NumberRange>(value);
        return {Pulse::from_fractional_microseconds(range.low),
                Pulse::from_fractional_microseconds(range.high)};
    }
    static std::optional<SettingValue> to(const PulseRange& member) {
        return NumberRange{member.low.microseconds(), member.high.microseconds()};
    }
};

template <class T>
struct Notation<std::optional<T>> {
    static constexpr SettingType kType = Notation<T>::kType;
    static T from(const SettingValue& value) { return Notation<T>::from(value); }
    static std::optional<SettingValue> to(const std::optional<T>& member) {
        return member ? Notation<T>::to(*member) : std::nullopt;
    }
};

template <class Pointer>
struct PartsOf;
template <class OwnerType, class MemberType>
struct PartsOf<MemberType OwnerType::*> {
    using Owner = OwnerType;
    using Member = MemberType;
};

/// The member at the end of a path of pointers to members.
template <auto first, auto... rest, class Object>
constexpr auto& member_of(Object& object) {
    if constexpr (sizeof...(rest) == 0) {
        return object.*first;
    } else {
        return member_of<rest...>(object.*first);
    }
}

template <auto... path>
struct TypesOf;
template <auto first, auto... rest>
struct TypesOf<first, rest...> {
    using Owner = typename PartsOf<decltype(first)>::Owner;
    using Member = std::remove_cvref_t<decltype(member_of<first, rest...>(std::declval<Owner&>()))>;
};

/// The member at the end of the path, which the language writes as `Written` says.
template <class Written, auto... path>
struct Access {
    using Owner = typename TypesOf<path...>::Owner;

    static void set(void* object, const SettingValue& value) {
        member_of<path...>(*static_cast<Owner*>(object)) = Written::from(value);
    }
    static std::optional<SettingValue> get(const void* object) {
        return Written::to(member_of<path...>(*static_cast<const Owner*>(object)));
    }
    static std::optional<SettingValue> initial() {
        const Owner object{};
        return get(&object);
    }
    static constexpr Field kField{&kOwner<Owner>, set, get, initial};
};

template <class Member>
constexpr std::span<const std::string_view> choices_of() {
    if constexpr (std::is_enum_v<Member>) {
        return ChoiceWords<Member>::kAll;
    } else {
        return {};
    }
}

}  // namespace tribus
