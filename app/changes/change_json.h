#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "app/changes/change_journal.h"

namespace tribus {

/// The answer to `changes SINCE`, one JSON object: the changes after that number, at most 100, with
/// the number of the newest one and how many are no longer kept. Nothing in `words`: all.
std::string changes_json(const ChangeJournal& changes, std::span<const std::string> words);

}  // namespace tribus
