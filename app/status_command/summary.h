#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>
#include <tl/expected.hpp>

/// The summary of a status that `tribus status` prints: few fields with fixed meanings
/// (docs/commands.md, "status"). Pure.
namespace tribus::status_summary {

/// The version of a summary rises if one of its fields changes its meaning.
inline constexpr int kVersion = 1;

/// The summary of a status as `docs/status.md` describes it. Figures older than a second say
/// nothing about now: then states and causes are "unknown", and no input is good. The error says
/// that `status` is none.
tl::expected<nlohmann::ordered_json, std::string> of_status(const nlohmann::json& status);

/// The summary in words, one line for the daemon and one for each trial, input, output and device.
/// Control characters of names become question marks.
std::vector<std::string> lines(const nlohmann::ordered_json& summary);

/// Whatever differs between two summaries of one daemon, as objects of type "change": causes,
/// states, the input in control, devices, the configuration, trials; also a loss or a failsafe that
/// came and went between the two. A part that is in one of them only has null in the other.
std::vector<nlohmann::ordered_json> changes(const nlohmann::ordered_json& before,
                                            const nlohmann::ordered_json& after);

/// A change of whether the daemon answers; `why` may be empty. Times in microseconds as in a
/// status.
nlohmann::ordered_json change_of_answers(const nlohmann::ordered_json& summary, bool answers,
                                         const std::string& why, std::int64_t t_us,
                                         std::int64_t unix_time_us);

/// The change in words, with its time in UTC in front.
std::string line(const nlohmann::ordered_json& change);

}  // namespace tribus::status_summary
