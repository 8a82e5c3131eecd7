#pragma once

#include <span>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "config/language/mistakes.h"

namespace tribus {

/// A list of `{"file", "line", "column", "text"}`. A mistake that concerns a file as a whole has
/// neither line nor column.
nlohmann::ordered_json mistakes_json(std::span<const Mistake> mistakes);

/// `{"mistakes": [...]}` with an end of line, for programs.
std::string mistakes_document(std::span<const Mistake> mistakes);

}  // namespace tribus
