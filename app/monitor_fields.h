#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

/// How a monitor reads what a daemon tells, which may be another version, or no daemon at all: a
/// field that is not there, or of another kind, is nothing. Pure.
namespace tribus::monitor {

using Json = nlohmann::json;

const Json& field(const Json& object, const char* key);

/// As it was told, whatever is in it.
std::string raw_text(const Json& object, const char* key);

/// To be shown: control characters, which a terminal would obey, are question marks.
std::string shown(std::string_view text);
std::string text(const Json& object, const char* key);

std::optional<double> number(const Json& object, const char* key);

/// Zero where there is none.
std::uint64_t count(const Json& object, const char* key);

bool flag(const Json& object, const char* key);

/// Empty where there is none.
const Json& list(const Json& object, const char* key);

}  // namespace tribus::monitor
