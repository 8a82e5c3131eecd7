#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "core/pulse.h"
#include "core/secret_key.h"
#include "core/time.h"

namespace tribus {

/// Type of a configuration key. The reader, the JSON schema and the messages are made from tables
/// of `Setting`.
enum class SettingType : std::uint8_t {
    boolean,
    integer,
    number,
    text,
    choice,    ///< text, one of `choices`
    duration,  ///< text with a unit: "500us", "14ms", "2s"
    pulse,     ///< microseconds, fractions allowed
    pulses,    ///< [low, high], microseconds
    slew,      ///< text: "2000us/s"
    scale,     ///< one of `choices`, or { raw = [a, b], us = [c, d] }
    file,      ///< text: path of a text file, relative to the folder of the configuration
    key_file,  ///< text: path of a file with a secret, relative to that folder
    tree,      ///< a table whose content the protocol checks itself
};

/// Two points that define a straight line between raw values of a wire format and microseconds.
struct TwoPoints {
    std::array<double, 2> raw{};
    std::array<double, 2> microseconds{};
    bool operator==(const TwoPoints&) const = default;
};

/// A closed range: `low` <= `high`.
struct NumberRange {
    double low = 0;
    double high = 0;
    bool operator==(const NumberRange&) const = default;
};

/// Where a protocol's own key is allowed.
enum class SettingScope : std::uint8_t { both, input, output };

/// One row of the key table. All text has static storage. `absent` and `help` are plain sentences
/// without the last full stop; keys and values in them stand in backticks.
struct Setting {
    std::string_view key;
    SettingType type = SettingType::text;
    /// Default as written in a configuration file. Empty: the key has no default.
    std::string_view fallback = {};
    /// What holds where the key is left out, if `fallback` is empty; empty: nothing.
    std::string_view absent = {};
    bool required = false;
    /// Allowed range, ends included, in the unit of the type (durations: seconds; pulses and slew:
    /// microseconds). Both 0: no limit.
    double least = 0;
    double most = 0;
    /// Unit of a number whose type does not tell it, such as "KiB".
    std::string_view unit = {};
    std::span<const std::string_view> choices = {};
    SettingScope scope = SettingScope::both;
    /// Only where the bytes pass a serial line, which has a rate.
    bool of_line = false;
    std::string_view help = {};
    /// A value as one would write it in the file, for the manual.
    std::string_view example = {};
    /// Instead, for an output; empty: the same.
    std::string_view output_example = {};
    /// Keys inside a tree, for the manual: the protocol reads and judges them itself.
    std::span<const Setting> inside = {};
};

/// A text file that a key names, with its content.
struct SettingFile {
    std::string path;
    std::string content;
    bool operator==(const SettingFile&) const = default;
};

/// A key file that a key names, with its secret. Only the path may be shown.
struct KeyFile {
    std::string path;
    SecretKey secret{};
    bool operator==(const KeyFile&) const = default;
};

struct SettingEntry;

/// A value as the user wrote it, of any depth.
struct SettingTree {
    using List = std::vector<SettingTree>;
    using Table = std::vector<SettingEntry>;
    std::variant<bool, std::int64_t, double, std::string, List, Table> content;

    template <class T>
    const T* as() const {
        return std::get_if<T>(&content);
    }
    bool operator==(const SettingTree&) const = default;
};

/// A key of a tree, with its value.
struct SettingEntry {
    std::string key;
    SettingTree value;
    bool operator==(const SettingEntry&) const = default;
};

using SettingValue = std::variant<bool, std::int64_t, double, std::string, Duration, NumberRange,
                                  TwoPoints, SettingFile, KeyFile, SettingTree>;

/// An error in one of a protocol's own keys.
struct SettingMistake {
    /// The key, followed by the keys inside its tree.
    std::vector<std::string> path;
    /// What is wrong, and what is allowed.
    std::string text;
};

/// The checked values of one table: each key of its `Setting` rows that was given or has a default.
class SettingValues {
  public:
    void set(std::string_view key, SettingValue value) {
        values_.emplace_back(std::string(key), std::move(value));
    }
    /// The value of a key, or null.
    const SettingValue* find(std::string_view key) const {
        for (const auto& [name, value] : values_) {
            if (name == key) {
                return &value;
            }
        }
        return nullptr;
    }
    /// The value of a key as a T, or null; also null if it has another type.
    template <class T>
    const T* find_as(std::string_view key) const {
        const SettingValue* value = find(key);
        return value == nullptr ? nullptr : std::get_if<T>(value);
    }
    template <class T>
    T get_or(std::string_view key, T fallback) const {
        const T* value = find_as<T>(key);
        return value == nullptr ? std::move(fallback) : *value;
    }

    bool operator==(const SettingValues&) const = default;

    auto begin() const { return values_.begin(); }
    auto end() const { return values_.end(); }

  private:
    std::vector<std::pair<std::string, SettingValue>> values_;
};

}  // namespace tribus
