#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "config/keys/keys.h"

/// Values of the effective configuration in words. Pure.
namespace tribus {

/// A value as in the file, without quotation marks.
std::string plain_text(const nlohmann::ordered_json& value);

/// The keys of `table` that are not at their default, each with its value and in the order of the
/// rows: "reverse", "trim 12 us", "mix { 1 = 0.5, 2 = -0.5 }".
std::vector<std::string> row_texts(const nlohmann::ordered_json& table, std::span<const Key> rows);

/// How a channel is made, by its entry in a map: "channel 2, reverse, trim 12 us".
std::string channel_text(const nlohmann::ordered_json& rule);

}  // namespace tribus
