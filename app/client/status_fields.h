#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

/// Reads the fields of a status. It may come from another version, or from another program: a field
/// that is missing or of another type counts as empty. Pure.
namespace tribus::status_fields {

using Json = nlohmann::json;

/// The field, or null.
const Json& field(const Json& object, const char* key);

/// The text as received, unescaped.
std::string raw_text(const Json& object, const char* key);

/// For display: control characters, which a terminal would obey, become question marks.
std::string shown(std::string_view text);
/// A text for display, see `shown`; empty if the field is missing.
std::string text(const Json& object, const char* key);

/// Nothing if the field is missing.
std::optional<double> number(const Json& object, const char* key);

/// A whole number, cut off at +-2^53; nothing if the field is missing. For times in microseconds.
std::optional<std::int64_t> whole(const Json& object, const char* key);

/// Zero if the field is missing.
std::uint64_t count(const Json& object, const char* key);

/// False if the field is missing.
bool flag(const Json& object, const char* key);

/// Empty if the field is missing.
const Json& list(const Json& object, const char* key);

}  // namespace tribus::status_fields
